# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The pictures of a report: what each shows, said once, and how it is drawn for a page and for a paper."""

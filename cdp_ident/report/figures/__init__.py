# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The pictures of a report: what each shows, said once; those of its curves; and how they are drawn for a paper."""

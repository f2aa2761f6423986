# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Machine code: what is compiled, where it is kept, how it is called, and how work is shared out among the cores."""

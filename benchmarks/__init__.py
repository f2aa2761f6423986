# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How fast and how good the package is, beside what a user would use instead: one module a topic."""

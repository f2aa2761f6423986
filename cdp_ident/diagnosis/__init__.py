# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How good a fit is, and what it determines: errors, uncertainty, identifiability, warnings."""

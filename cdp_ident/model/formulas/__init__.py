# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Formulas of laws: read as text, differentiated, and made into compiled code; see `language`."""

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Campaigns of damaged and hostile input: serial frames, bags and texts. `make fuzz` runs them."""

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Many bags of many rigs: identified piece by piece, by several processes or machines, and looked at together."""

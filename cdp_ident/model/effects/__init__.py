# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects that the paper's model lacks: friction of other kinds, drag, springs, and what encoders do to angles."""

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Recording of trials: when one begins and ends, what is known of it, and how nothing of it gets lost."""

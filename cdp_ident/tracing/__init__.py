# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From the residual of a fitted model to the effects that it lacks."""

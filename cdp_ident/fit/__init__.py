# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From windows of trials to the values that fit them best: windows, model, prior, refinement."""

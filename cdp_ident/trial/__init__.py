# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From the samples of a bag to a trial: one motion, free or with known inputs, in the model's angles."""

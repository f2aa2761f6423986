# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A rig that is not there: its physics, the hand that lets it go, its microcontroller, its cable and their faults."""

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which trial to record next: what it would tell, before it is recorded (optimal design of experiments)."""

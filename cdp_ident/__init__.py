# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Identification of a cart double pendulum from free-swing trials."""

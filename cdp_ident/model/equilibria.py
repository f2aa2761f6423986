# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where the rods of the paper's model can rest."""

from math import pi

EQUILIBRIA = {"upright": (0.0, 0.0), "hanging": (pi, pi), "up-down": (0.0, pi), "down-up": (pi, 0.0)}
"""Angles theta1, theta2 [rad] by name: the inner rod's direction comes first."""

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The paper's identified pendulum (Table 5) as the package counts it."""

import numpy as np

from cdp_ident.model.parameters import SYMBOLS, groups_of, inertia_about_cart, physical_coefficients
from reference.pendulum import TABLE_5

LENGTH = TABLE_5["L"]
PHYSICAL = np.array([TABLE_5[symbol] for symbol in SYMBOLS])
GROUPS = groups_of(PHYSICAL, LENGTH)
"""Its base parameters."""
COEFFICIENTS = physical_coefficients(TABLE_5)
A22 = float(inertia_about_cart(PHYSICAL, LENGTH))
"""Inertia about the cart's joint [kg m^2]."""

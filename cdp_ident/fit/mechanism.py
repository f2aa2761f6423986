# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a model must know of the rig beforehand."""

from dataclasses import dataclass

from cdp_ident.fit.prior import Prior
from cdp_ident.model.acting import outer_rod_length
from cdp_ident.model.parameters import SYMBOLS, inertia_about_cart


@dataclass(frozen=True)
class Mechanism:
    """What the model must know of the rig beforehand, because no zero-input trial shows it."""

    length: float
    """L [m], or the value to begin with where it is free."""
    gravity: float
    """g [m/s^2], or the value to begin with where it is free."""
    outer_length: float
    """Length of the outer rod [m]."""
    inertia: float
    """A22 [kg m^2], or the value to begin with where it is free."""

    @classmethod
    def of(cls, prior: Prior) -> "Mechanism":
        """Take it from what is known before any trial."""
        l2 = float(prior.centre[SYMBOLS.index("l2")])
        inertia = float(inertia_about_cart(prior.centre, prior.length))
        return cls(prior.length, prior.gravity, outer_rod_length(prior.length, l2), inertia)

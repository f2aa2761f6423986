# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A22, the inertia about the cart's joint, relative to which a free swing determines all parameters."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.physical import PhysicalValues
from cdp_ident.model.parameters import INVERSE_INERTIA, inertia_about_cart

Array = npt.NDArray[np.float64]

GUESSED = 0.5
"""Relative standard deviation from which on a value is as good as guessed."""


@dataclass(frozen=True)
class Inertia:
    """A22, and how well it is known."""

    value: float
    """[kg m^2]"""
    relative_std: float
    covariance: Array
    """(unknowns,) covariance of its logarithm with each unknown of the model."""
    shown: bool
    """Whether weights or motors show it; if not, it is that of the nearest physical values."""

    @property
    def std(self) -> float:
        """Standard deviation [kg m^2]."""
        return self.value * self.relative_std

    @classmethod
    def of(cls, model: MotionModel, values: Array, covariance: Array, physical: PhysicalValues) -> "Inertia":
        """Take it from the fitted values (unknowns,) and their covariance, or from physical values."""
        inverse, (length, _) = model.inverse_inertia(values), model.constants(values)
        if not model.inertia_free or inverse <= 0.0:
            value = float(inertia_about_cart(physical.values, length))
            return cls(value, physical.inertia_relative_std, np.zeros(len(values)), False)
        spread = covariance[:, model.names.index(INVERSE_INERTIA.symbol)] / inverse
        of_torques = model.torque_std if model.motors else 0.0
        std = float(np.hypot(np.sqrt(spread[model.names.index(INVERSE_INERTIA.symbol)] / inverse), of_torques))
        return cls(1.0 / inverse, std, -spread, True)

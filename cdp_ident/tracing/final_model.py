# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A chosen model, evaluated by the motion that was held out."""

from dataclasses import dataclass

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.data import Data
from cdp_ident.fit.initial_states import Fit, fit_initial_states
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.likelihood.maxima import values_with_less_torque
from cdp_ident.likelihood.whole_swing import WholeSwings

_CLEARLY = 0.9
"""Values with less unknown torque are taken where their error is at most this share of that of the most likely ones:
by chance either predicts somewhat better, and the most likely ones are the more exact."""
_WORSE = 1.02
"""From so many times the error on, a model is worse than another one beyond chance."""


def is_worse(error: float, other: float) -> bool:
    """Return whether an error is larger than another one beyond chance, or not a number."""
    return not error <= _WORSE * other


@dataclass(frozen=True)
class FinalModel:
    """A model as it is reported."""

    fit: Fit
    """Over the windows that were fitted, its values held."""
    holdout: Fit
    """Over those that were held out, likewise."""
    less_torque: bool
    """Whether its values are not the most likely ones, but those with less unknown torque: they predict better."""

    @property
    def model(self) -> MotionModel:
        """The model that was fitted."""
        return self.fit.model

    @classmethod
    def of(cls, found: WholeSwings, data: Data, followed: Fit | None = None) -> "FinalModel":
        """Evaluate a model; where torques are missing, what was held out judges which values predict better.

        Args:
            found: given whole swings.
            data: windows, fitted and held out.
            followed: the windows that were fitted under the model's values, where they were followed before.

        Raises:
            IdentificationError, LinAlgError: no motion can be computed.
        """
        likely = cls._with(found, found.values, False, data, followed)
        if not np.any(found.is_missing):
            return likely
        try:
            other = cls._with(found, values_with_less_torque(found), True, data)
        except (IdentificationError, np.linalg.LinAlgError):
            return likely
        return other if other.holdout.rmse() < _CLEARLY * likely.holdout.rmse() else likely

    @classmethod
    def _with(
        cls, found: WholeSwings, values: Array, less_torque: bool, data: Data, followed: Fit | None = None
    ) -> "FinalModel":
        followed = followed or fit_initial_states(found.model, values, data.fit)
        return cls(followed, fit_initial_states(found.model, values, data.holdout), less_torque)

    def error_of(self, found: WholeSwings) -> float:
        """Return the error of another model, with values of the same kind, over what was held out [rad].

        Not a number where it cannot be computed.
        """
        try:
            less = self.less_torque and bool(np.any(found.is_missing))
            values = values_with_less_torque(found) if less else found.values
            return fit_initial_states(found.model, values, self.holdout.windows).rmse()
        except (IdentificationError, np.linalg.LinAlgError):
            return float("nan")

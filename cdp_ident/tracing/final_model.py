"""A chosen model, evaluated by the motion that was held out."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.diagnosis.uncertainty import reduced_sensitivities
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.astray import with_starts_found_again
from cdp_ident.fit.data import Data
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.refinement import Fit, fit_initial_states, fit_initial_states_near, with_all_derivatives

Array = npt.NDArray[np.float64]

_AS_GOOD = 1.05
"""Fitted initial states are good if the error is at most so many times that of another model …"""
_LIKE_THE_FIT = 1.5
"""… and at most so many times the fit's."""
_WORSE = 1.02
"""From so many times the error on, a model is worse than another one beyond chance."""


def is_worse(error: float, other: float) -> bool:
    """Return whether an error is larger than another one beyond chance, or not a number."""
    return not error <= _WORSE * other


@dataclass(frozen=True)
class FinalModel:
    """A model as it is reported."""

    fit: Fit
    holdout: Fit
    """Over the held-out windows, its values held."""

    @property
    def model(self) -> MotionModel:
        """The model that was fitted."""
        return self.fit.model

    @classmethod
    def of(cls, fit: Fit, data: Data) -> "FinalModel":
        """Evaluate a fitted model."""
        holdout = fit_initial_states(fit.model, fit.values, data.holdout)
        return cls(fit, with_starts_found_again(holdout, hold_values=True))

    def like_this(self, fit: Fit) -> "FinalModel":
        """Evaluate another fitted model over the same windows; initial states are fitted from those of this one."""
        good_enough = min(_AS_GOOD * self.holdout.rmse(), _LIKE_THE_FIT * fit.rmse())
        holdout = fit_initial_states_near(fit.model, fit.values, self.holdout.windows, good_enough)
        return FinalModel(fit, with_starts_found_again(holdout, hold_values=True))

    def moved_by(self, covariance: Array) -> Array:
        """Return by how much (2,) one standard deviation of all values moves theta1 and theta2 held out [rad].

        It is a root mean square, less what initial states make up for; 0 where it cannot be computed.

        Args:
            covariance: (unknowns, unknowns) of the values; those that are not determined move nothing.
        """
        known = np.isfinite(np.diag(covariance))
        spread = covariance[np.ix_(known, known)]
        try:
            by_values = list(reduced_sensitivities(with_all_derivatives(self.holdout)))
        except (IdentificationError, np.linalg.LinAlgError):
            return np.zeros(2)
        moves = [rows[..., known] for rows in by_values]
        squares = np.sum([np.einsum("nrp,pq,nrq->r", rows, spread, rows) for rows in moves], axis=0)
        return np.asarray(np.sqrt(np.nan_to_num(squares, posinf=0.0) / sum(map(len, moves))))

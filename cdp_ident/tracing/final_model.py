"""A chosen model, evaluated by the motion that was held out."""

from dataclasses import dataclass

from cdp_ident.fit.astray import with_starts_found_again
from cdp_ident.fit.data import Data
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.refinement import Fit, fit_initial_states, fit_initial_states_near

_AS_GOOD = 1.05
"""Fitted initial states are good if the error is at most so many times that of another model …"""
_LIKE_THE_FIT = 1.5
"""… and at most so many times the fit's."""


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

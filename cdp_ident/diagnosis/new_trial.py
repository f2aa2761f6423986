# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The check of a new trial by the model that was identified before it came."""

from dataclasses import dataclass, replace

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.diagnosis.warnings import FAR_OFF, MOST_NAMED, FitWarning
from cdp_ident.fit.data import Data
from cdp_ident.fit.initial_states import Fit, fit_initial_states
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.likelihood.gauss_newton import GaussNewton
from cdp_ident.likelihood.maxima import NEAR
from cdp_ident.likelihood.noise import Noise
from cdp_ident.likelihood.recorded import one_recorded, states_of
from cdp_ident.trial.trial import Trial

_NO_LONGER = 1.5
"""A new trial no longer fits if its error is so many times that on held-out motion."""


@dataclass(frozen=True)
class Changed:
    """A value that the new trial alone gives otherwise than the trials before it."""

    name: str
    before: float
    alone: float
    deviations: float
    """Difference in its standard deviations."""

    @property
    def words(self) -> str:
        """It in words."""
        relative = f"{100 * (self.alone / self.before - 1):+.2g} %, " if self.before else ""
        return (
            f"{self.name} {self.before:.4g} -> {self.alone:.4g} ({relative}{self.deviations:.0f} standard deviations)"
        )


@dataclass(frozen=True)
class NewTrialCheck:
    """The errors of a model over a new trial that it was not fitted to."""

    trial: str
    rmse: float
    """Root mean square error over the new trial's windows, only their initial states fitted [rad]."""
    expected_rmse: float
    """The same over the held-out motion [rad]."""
    changed: tuple[Changed, ...]
    """Values that differ clearly in a fit of the new trial alone, the most clearly changed first."""

    @property
    def fits(self) -> bool:
        """Whether the model holds for it."""
        return self.rmse < _NO_LONGER * self.expected_rmse

    @property
    def words(self) -> str:
        """How well the trial fits, in a sentence."""
        numbers = f"{1e3 * self.rmse:.3g} mrad, where held-out motion had {1e3 * self.expected_rmse:.3g} mrad"
        if self.fits:
            return f"{self.trial}, before it was seen: {numbers}"
        alone = "; ".join(changed.words for changed in self.changed[:MOST_NAMED])
        changes = f"; alone it gives {alone}" if alone else ""
        return (
            f"{self.trial} no longer fits: {numbers}{changes}; has friction changed, or something come loose? "
            "It is fitted jointly with the others all the same"
        )

    def warning(self) -> FitWarning | None:
        """Return the reason for doubt, where there is one."""
        return None if self.fits else FitWarning("no_longer_fits", (self.trial,), self.words)


def check_new_trial(fitted: Fit, spread: Array, expected: float, trial: Trial, data: Data) -> NewTrialCheck:
    """Check a trial by a model that was not fitted to it.

    Args:
        fitted: gives the model, with its effects, and its values.
        spread: (unknowns, unknowns) their covariance.
        expected: its error on held-out motion [rad].
        trial: the new trial.
        data: that of the trials before it, which gives the length of windows, and scales.

    Raises:
        IdentificationError: the trial is too short for a single window, or has no motion that can be computed.
    """
    number = len(data.trials)  # no effect of an instant is of it
    windows = [replace(w, trial=number) for w in cut_into_windows([trial], min(data.window, trial.duration))]
    # A single trial does not determine A22; nor do trials that all had the same weights.
    model, remain = fitted.model.with_inertia_known(fitted.values)
    values = fitted.values[remain]
    held = fit_initial_states(model, values, windows)
    recorded = one_recorded(data, trial, number, NEAR)
    states = states_of(recorded, held.model)
    noise = Noise.white(recorded.encoders, recorded.large_torque)
    alone = GaussNewton(held.model, held.values, recorded, states, noise).run().found()
    # Zeros of a trial are not the rig's, and coefficients of curves have no meaning one by one.
    new, old = (of.of_rig & ~of.of_curves for of in (alone.model, model))
    names, before, now = np.array(model.names)[old], values[old], alone.values[new]
    variances = np.diag(alone.covariance)[new] + np.diag(spread)[remain][old]
    variances[~(variances > 0)] = np.inf
    deviations = np.abs(now - before) / np.sqrt(variances)
    changed = [
        Changed(str(names[k]), float(before[k]), float(now[k]), float(deviations[k]))
        for k in np.argsort(-deviations, kind="stable")
        if deviations[k] > FAR_OFF
    ]
    return NewTrialCheck(trial.name, held.rmse(), expected, tuple(changed))

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Errors of a model with given values, simulated against measured motion, and whether it follows that at all."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.diagnosis.warnings import FAR_OFF
from cdp_ident.errors import FitFailedError, IdentificationError
from cdp_ident.fit.data import Data
from cdp_ident.fit.initial_states import Fit, fit_initial_states
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.windows import Window, beginning_of, cut_at, shared
from cdp_ident.machine.parallel import parallel_map
from cdp_ident.trial.trial import Trial

_LOST = 0.2
"""An error of the angles, as a share of their scatter, beyond which a simulation no longer follows the motion."""
_MOST_LOST = 0.25
"""Share of the windows in which the simulation may fail to follow the motion: an event affects only a few."""


@dataclass(frozen=True)
class Errors:
    """Errors of a model over windows whose initial states were fitted, the parameters held."""

    rmse: float
    """Root mean square of measured minus simulated angles, theta1 and theta2 together [rad]."""
    rmse_theta1: float
    rmse_theta2: float
    sse_free_run: float
    """Eq. (10): squared error of one simulation of each whole trial from its beginning, over these windows [rad^2]."""
    fit_theta1: float
    """Fit of theta1 [%]; see `fit_per_cent`."""
    fit_theta2: float
    window: float
    """Mean duration of the windows, to the millisecond [s]."""


@dataclass(frozen=True)
class ErrorsByRole:
    """Errors of a model over motion of each role."""

    fit: Errors
    """Over the windows that it was fitted to."""
    holdout: Errors


def evaluate(model: MotionModel, values: Array, data: Data, enough: float) -> ErrorsByRole:
    """Return the errors of a model whose values (unknowns,) are held, initial states of windows being fitted.

    Where there is more motion than `enough` [s], they are taken over a share of the windows (`fit/share.py`); those of
    whole trials, Eq. (10), are always over all.
    """

    def followed(windows: Sequence[Window]) -> Fit | None:
        try:
            return fit_initial_states(model, values, shared(windows, enough))
        except (IdentificationError, np.linalg.LinAlgError):  # under these values there may be no motion
            return None

    return errors_by_role(followed(data.fit), followed(data.holdout), data)


def errors_by_role(fit: Fit | None, holdout: Fit | None, data: Data) -> ErrorsByRole:
    """Return the errors of a model that was followed over windows that were fitted, and over those that were held out.

    They are infinite where there is no motion.
    """
    every = holdout or fit  # over what was held out a model knows the zeros of trials held out, too
    runs = free_runs(every, data.trials, data.window) if every else {}
    return ErrorsByRole(errors_of(fit, runs, data.fit), errors_of(holdout, runs, data.holdout))


def errors_of(fit: Fit | None, runs: Mapping[int, Array], windows: Sequence[Window]) -> Errors:
    """Return the errors of a fit; Eq. (10) is taken from `free_runs`, over its own choice of windows."""
    window = round(float(np.mean([window.duration for window in windows])), 3)
    if fit is None:
        return Errors(np.inf, np.inf, np.inf, np.inf, -np.inf, -np.inf, window)
    squared = sum(float(np.sum(runs[window.trial][window.samples] ** 2)) for window in windows)
    squared = squared if np.isfinite(squared) else np.inf
    of_theta1, of_theta2 = fit_per_cent(fit).tolist()
    return Errors(fit.rmse(), fit.rmse(0), fit.rmse(1), squared, of_theta1, of_theta2, window)


def fit_per_cent(fit: Fit) -> Array:
    """Return how much of the motion of theta1 and theta2 (2,) a model accounts for: 100 for all of it [%].

    It is 100 (1 - |y - yhat| / |y - mean y|) with the norms over all windows together, as `compare` of MATLAB's System
    Identification Toolbox has it. Each window is an experiment with an initial state and a mean of its own; with one
    mean over all, full turns of a rod would make the fit look better than it is.
    """
    left = sum(np.sum(error**2, axis=0) for error in fit.errors)
    moved = sum(np.sum((window.theta - window.theta.mean(axis=0)) ** 2, axis=0) for window in fit.windows)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(100.0 * (1.0 - np.sqrt(left / moved)))


def start_of(model: MotionModel, values: Array, trial: Trial, index: int, duration: float) -> Array:
    """Return the state (states,) in which a trial begins, fitted to its first `duration` [s], values (unknowns,) held.

    `index` says which trial it is, for effects that happen once.
    """
    return fit_initial_states(model, values, [beginning_of(trial, index, duration)]).windows[0].start


def free_run(model: MotionModel, values: Array, trial: Trial, index: int, duration: float) -> Array:
    """Return the angles (n, 2) [rad] of one simulation of a whole trial from `start_of` it, as Eq. (10) has it."""
    start = start_of(model, values, trial, index, duration)
    (whole,) = cut_at(trial, index, [0, len(trial.time)])
    return model.predict(values, start, whole)


def free_runs(fit: Fit, trials: Sequence[Trial], duration: float) -> dict[int, Array]:
    """Return measured angles (n, 2) minus those of a `free_run` [rad], by the trial's number; infinite without one."""

    def left(index: int) -> Array:
        try:
            return trials[index].theta - free_run(fit.model, fit.values, trials[index], index, duration)
        except IdentificationError:
            return np.full_like(trials[index].theta, np.inf)

    return dict(enumerate(parallel_map(left, range(len(trials)))))


def refuse_a_failed_fit(fits: Sequence[Fit], noise: float) -> None:
    """Raise `FitFailedError` where the model follows the motion in too few windows.

    Args:
        fits: how it follows the motion it was fitted to, and how it predicts it.
        noise: root mean square of what the encoders add to both angles [rad].
    """
    scatter = np.sqrt(np.mean([np.var(window.theta, axis=0).mean() for fit in fits for window in fit.windows]))
    # However small the motion is, an error that is not far above the noise is none of the simulation's.
    limit = max(_LOST * min(float(scatter), 1.0), FAR_OFF * noise)
    for fit, which in zip(fits, ("fitted", "predicted"), strict=True):
        # An encoder that is off by the same all the time shows no other motion: the scatter is about the mean, too.
        errors = [float(np.sqrt(np.var(error, axis=0).mean())) for error in fit.errors]
        lost = [error for error in errors if error > limit]
        if len(lost) > _MOST_LOST * len(errors):
            raise FitFailedError(
                f"the fit failed: in {len(lost)} of {len(errors)} windows {which} the model moves otherwise than the "
                f"rods, by {np.median(lost):.2g} rad; no parameter means anything. Check L, g and what the angles mean "
                "(zero, outer_angle, inner_sign and outer_sign below trial), the counts per turn, whether "
                "somebody touched the rods, and whether all bags are of one rig; or set a shorter window"
            )

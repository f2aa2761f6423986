"""How a model predicts motion that it is not fitted to: cross-validation (Stone, J. R. Stat. Soc. B 36, 1974).

The windows are divided into folds. Each fold is simulated with the values of a fit to the other folds; only its
windows' initial states are fitted to it. These values are approximated by one Gauss-Newton step from the fit to all
folds, so that no fold needs a fit of its own (approximate cross-validation: Rad and Maleki, J. R. Stat. Soc. B 82,
2020). Shape parameters of effects are held.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from cdp_ident.diagnosis.uncertainty import eliminated, normal_equations, scaled_inverse
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.refinement import Fit, fit_initial_states_near, refine
from cdp_ident.fit.windows import Window
from cdp_ident.machine.parallel import parallel_map

Array = npt.NDArray[np.float64]
Folds = tuple[tuple[int, ...], ...]
"""Indices of the windows of each fold."""

_UNOBSERVABLE = 1e-10
"""Share of the curvature over all folds below which the others do not determine a direction: its values are kept."""
_LOST = 4.0
"""Initial states that leave an error of so many times the fit's are fitted again over windows of growing length."""


def cross_validated(fit: Fit, folds: Folds) -> Fit:
    """Return a fit whose residuals are those of predictions: each window's by a fit without its fold.

    Its values are those of the fit to all windows.

    Args:
        fit: of a model to all windows.
        folds: every window is in one of them.
    """
    gradients, curvatures = normal_equations(fit)
    penalty = fit.model.penalty
    strong = np.flatnonzero(~_kept(fit.model))
    sizes = np.diag(curvatures.sum(axis=0) + penalty)[strong]

    def predicted(fold: tuple[int, ...]) -> Fit:
        chosen = list(fold)
        gradient = np.delete(gradients, chosen, axis=0).sum(axis=0) - penalty @ fit.values
        curvature = np.delete(curvatures, chosen, axis=0).sum(axis=0) + penalty
        # What only this fold shows, as the zeros of its trial, stays as it is fitted to it.
        inverse, _ = scaled_inverse(curvature[np.ix_(strong, strong)], _UNOBSERVABLE, sizes)
        values = fit.values.copy()
        values[strong] += inverse @ gradient[strong]
        return _followed(fit, np.clip(values, *fit.model.limits), chosen)

    found = {
        index: of_window
        for fold, of_fold in zip(folds, parallel_map(predicted, folds), strict=True)
        for index, *of_window in zip(fold, of_fold.windows, of_fold.residuals, strict=True)
    }
    windows, residuals = zip(*(found[index] for index in range(len(fit.windows))), strict=True)
    return replace(fit, windows=windows, residuals=residuals)


def error_from_other_trials(fit: Fit) -> float:
    """Return the error over all trials, each predicted by a fit to the others [rad].

    Unknowns of one trial, such as its encoders' zeros, keep the values of the fit to all.

    Args:
        fit: to more than one trial.

    Raises:
        IdentificationError: the motion cannot be computed.
    """
    squared, samples = 0.0, 0.0
    for trial in sorted({window.trial for window in fit.windows}):
        own = [index for index, window in enumerate(fit.windows) if window.trial == trial]
        others = refine(fit.model, fit.values, [window for window in fit.windows if window.trial != trial])
        predicted = _followed(fit, others.values, own)
        squared, samples = squared + predicted.samples * predicted.rmse() ** 2, samples + predicted.samples
    return float(np.sqrt(squared / samples))


def _kept(model: MotionModel) -> npt.NDArray[np.bool_]:
    """Return which unknowns (unknowns,) keep their values whatever is left out.

    In shape parameters of effects, such as a Stribeck speed, the motion is nonlinear, and hardly determines some, so
    that one linear step would be wrong. Of an impulse the window before may hold the first of its ten milliseconds,
    which say next to nothing of it.
    """
    kept = [
        p.shape or (active.effect.moves and active.effect.at_an_instant)
        for active in model.effects
        for p in active.fitted
    ]
    return np.array([False] * (len(model.names) - len(kept)) + kept)


def _followed(fit: Fit, values: Array, chosen: Sequence[int]) -> Fit:
    """Fit initial states of some windows under given values, or under the fit's where no motion can be computed."""
    windows = _moved(fit.over(chosen), values - fit.values)
    before = float(np.sqrt(np.mean(np.concatenate([fit.errors[index].ravel() for index in chosen]) ** 2)))
    try:
        return fit_initial_states_near(fit.model, values, windows, _LOST * before)
    except IdentificationError:
        as_fitted = [fit.windows[index] for index in chosen]
        return fit_initial_states_near(fit.model, fit.values, as_fitted, _LOST * before)


def _moved(fit: Fit, change: Array) -> list[Window]:
    """Return a fit's windows with the initial states that suit changed values (unknowns,), to first order."""
    windows, states = [], fit.model.states
    for window, state, sensitivity, weight in zip(
        fit.windows, eliminated(fit), fit.sensitivities, fit.weights, strict=True
    ):
        by_values = (sensitivity[..., states:] @ change) * np.sqrt(weight)
        start = fit.model.initial_state(window.start) - state.change_for(by_values.ravel())
        windows.append(replace(window, start=start))
    return windows

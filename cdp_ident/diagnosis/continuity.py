"""Whether the windows of a trial join: each begins where the model, run from the one before, arrives."""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cdp_ident.diagnosis.uncertainty import reduced_sensitivities
from cdp_ident.fit.motion_model import STATE
from cdp_ident.fit.refinement import Fit
from cdp_ident.model.time_grid import TimeGrid

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Continuity:
    """The jumps of the angles from the end of each window to the start of the next."""

    rms: float
    """Root mean square of the jumps [rad]."""
    relative: float
    """The same in units of what the uncertainty of starts and values lets expect: about 1 where the model holds."""
    joints: int
    """How many pairs of neighbouring windows were compared."""


def continuity(fit: Fit) -> Continuity | None:
    """Compare the fitted starts of windows with where their neighbours before them end; None where none have any."""
    jumps, expected = [], []
    variance = fit.rmse() ** 2
    curvature = sum(np.einsum("nrp,nrq->pq", s, s) for s in reduced_sensitivities(fit))
    spread_of_values = variance * np.linalg.pinv(curvature, hermitian=True)
    for index, (window, after) in enumerate(zip(fit.windows, fit.windows[1:], strict=False)):
        if window.trial != after.trial or after.first != window.first + len(window.theta):
            continue
        time = np.array([after.begin - window.begin])
        grid = TimeGrid.over(time, window.grid.step)
        u = np.interp(grid.half_step_times(), window.grid.half_step_times(), window.u)
        end = replace(window, time=time, theta=np.zeros((1, 2)), grid=grid, u=u)
        arrival, sensitivity = fit.model.predict(fit.values, window.start, end)
        carried = sensitivity[0, :, :STATE]
        spread = carried @ _start_covariance(fit, index, variance) @ carried.T
        spread += _start_covariance(fit, index + 1, variance)[:2, :2]
        by_values = (
            _starts_by_values(fit, index + 1)[:2] - carried @ _starts_by_values(fit, index) - sensitivity[0, :, STATE:]
        )
        spread += by_values @ spread_of_values @ by_values.T
        jumps.append(after.start[:2] - arrival[0])
        expected.append(np.diag(spread))
    if not jumps:
        return None
    squared = np.square(jumps)
    return Continuity(
        rms=float(np.sqrt(squared.mean())),
        relative=float(np.sqrt(np.mean(squared / np.maximum(expected, np.finfo(float).tiny)))),
        joints=len(jumps),
    )


def _start_covariance(fit: Fit, index: int, variance: float) -> Array:
    rows = fit.sensitivities[index][..., :STATE].reshape(-1, STATE)
    return np.asarray(variance * np.linalg.pinv(rows.T @ rows, hermitian=True), dtype=float)


def _starts_by_values(fit: Fit, index: int) -> Array:
    """Return how the fitted start of a window follows the values (4, unknowns)."""
    rows = fit.sensitivities[index].reshape(-1, STATE + len(fit.values))
    return np.asarray(-np.linalg.lstsq(rows[:, :STATE], rows[:, STATE:], rcond=None)[0])

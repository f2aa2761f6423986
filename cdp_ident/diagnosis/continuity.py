"""Whether windows join: whether a simulation of one window ends where the fitted next one begins."""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cdp_ident.diagnosis.uncertainty import reduced_sensitivities
from cdp_ident.fit.initial_states import InitialState
from cdp_ident.fit.refinement import Fit
from cdp_ident.fit.windows import Window
from cdp_ident.model.time_grid import TimeGrid

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Continuity:
    """The jumps of the angles from the end of each window to the beginning of the next."""

    rms: float
    """Root mean square of the jumps [rad]."""
    relative: float
    """The same over its expected size, from the uncertainty of initial states and values: about 1 if the model is
    right."""
    boundaries: int
    """How many boundaries between neighbouring windows were compared."""


def continuity(fit: Fit) -> Continuity | None:
    """Compare each window's initial state with the end of the one before it; None where there are no neighbours."""
    jumps, expected, states = [], [], fit.model.states
    rods, of_rods = fit.model.with_exact_encoders()
    variance = fit.variance
    curvature = sum(np.einsum("nrp,nrq->pq", s, s) for s in reduced_sensitivities(fit))
    spread_of_values = variance * np.linalg.pinv(curvature, hermitian=True)
    for index in followed(fit):
        window, after = fit.windows[index], fit.windows[index + 1]
        end = at_times(window, np.array([after.begin - window.begin]))
        arrival, sensitivity = rods.predict(fit.values[of_rods], window.start, end)
        carried = sensitivity[0, :, :states]
        (of_this, this_by_values), (of_next, next_by_values) = (initial_state(fit, index + k) for k in range(2))
        spread = variance * (carried @ of_this @ carried.T + of_next[:2, :2])
        by_values = next_by_values[:2] - carried @ this_by_values
        by_values[:, of_rods] -= sensitivity[0, :, states:]
        spread += by_values @ spread_of_values @ by_values.T
        jumps.append(after.start[:2] - arrival[0])
        expected.append(np.diag(spread))
    if not jumps:
        return None
    squared = np.square(jumps)
    return Continuity(
        rms=float(np.sqrt(squared.mean())),
        relative=float(np.sqrt(np.mean(squared / np.maximum(expected, np.finfo(float).tiny)))),
        boundaries=len(jumps),
    )


def followed(fit: Fit) -> list[int]:
    """Return the indices of the windows that another one follows at once."""
    pairs = enumerate(zip(fit.windows, fit.windows[1:], strict=False))
    return [k for k, (one, after) in pairs if one.trial == after.trial and after.first == one.first + len(one.theta)]


def at_times(window: Window, time: Array) -> Window:
    """Return a window that is looked at at other times [s]."""
    grid = TimeGrid.over(time, window.grid.step)
    u = np.interp(grid.half_step_times(), window.grid.half_step_times(), window.u)
    return replace(window, time=time, theta=np.zeros((len(time), 2)), grid=grid, u=u)


def initial_state(fit: Fit, index: int) -> tuple[Array, Array]:
    """Return an initial state's covariance (4, 4), over that of the angles, and its derivative by the values."""
    states = fit.model.states
    rows = fit.sensitivities[index].reshape(-1, states + len(fit.values))
    state = InitialState.of(rows[:, :states], fit.windows[index].start_known)
    return state.covariance, -state.change_for(rows[:, states:])

"""The motion of one pendulum from an initial state, at given times."""

import numpy as np
import numpy.typing as npt

from cdp_ident.errors import OptionError
from cdp_ident.model.time_grid import DEFAULT_STEP, TimeGrid
from cdp_ident.model.torques import NO_TORQUES, Torques
from cdp_ident.model.trajectory import trajectory

Array = npt.NDArray[np.float64]


def simulate(
    coefficients: Array,
    start: Array,
    times: Array,
    cart_acceleration: Array | None = None,
    step: float = DEFAULT_STEP,
    torques: Torques = NO_TORQUES,
    begin: float = 0.0,
) -> Array:
    """Return the states (n, states) at `times`: theta1, theta2 [rad], omega1, omega2 [rad/s], …; see `trajectory`.

    Args:
        coefficients: (7,) `COEFFICIENTS` of the pendulum; see `physical_coefficients` and `coefficients_of`.
        start: (4,) or (states,) state at time 0.
        times: (n,) ascending times from 0 on [s], on the integrator's steps or anywhere between.
        cart_acceleration: u [m/s^2] at `TimeGrid.over(times, step).half_step_times()`; None for a cart at rest.
        step: step of the fourth-order Runge-Kutta method [s].
        torques: of effects that the paper's model lacks.
        begin: time in the trial at time 0 [s], for effects that happen at an instant.

    Raises:
        OptionError: an argument is of the wrong size, not finite, or not ascending.
    """
    grid = TimeGrid.over(times, step)
    coefficients = np.ascontiguousarray(coefficients, dtype=float)
    start = np.ascontiguousarray(start, dtype=float)
    if (
        coefficients.shape != (7,)
        or start.shape not in {(4,), (torques.states,)}
        or not np.all(np.isfinite([*coefficients, *start]))
    ):
        raise OptionError("a simulation needs 7 finite coefficients and a start of 4 finite numbers")
    halves = 2 * grid.steps + 1
    u = np.zeros(halves) if cart_acceleration is None else np.ascontiguousarray(cart_acceleration, dtype=float)
    if u.shape != (halves,):
        raise OptionError(f"the cart's acceleration must be given at the {halves} half steps, not {u.shape}")
    return trajectory(coefficients, start, grid, u, torques, begin)

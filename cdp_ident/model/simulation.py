"""The motion of one pendulum from one start, at the times asked for."""

import numpy as np
import numpy.typing as npt

from cdp_ident.errors import OptionError
from cdp_ident.model.compilation import compiled
from cdp_ident.model.equations import accelerations, runge_kutta_step
from cdp_ident.model.time_grid import DEFAULT_STEP, TimeGrid

Array = npt.NDArray[np.float64]


def simulate(
    coefficients: Array, start: Array, times: Array, cart_acceleration: Array | None = None, step: float = DEFAULT_STEP
) -> Array:
    """Return the states (n, 4) at `times`: theta1, theta2 [rad], omega1, omega2 [rad/s].

    Args:
        coefficients: (7,) `COEFFICIENTS` of the pendulum; see `physical_coefficients` and `coefficients_of`.
        start: (4,) state at time 0.
        times: (n,) ascending times from 0 on [s], on the integrator's steps or anywhere between.
        cart_acceleration: u [m/s^2] at `TimeGrid.over(times, step).half_step_times()`; None for a cart at rest.
        step: step of the fourth-order Runge-Kutta method [s].

    Raises:
        OptionError: an argument is of the wrong size, not finite, or not ascending.
    """
    grid = TimeGrid.over(times, step)
    coefficients = np.ascontiguousarray(coefficients, dtype=float)
    start = np.ascontiguousarray(start, dtype=float)
    if coefficients.shape != (7,) or start.shape != (4,) or not np.all(np.isfinite([*coefficients, *start])):
        raise OptionError("a simulation needs 7 finite coefficients and a start of 4 finite numbers")
    halves = 2 * grid.steps + 1
    u = np.zeros(halves) if cart_acceleration is None else np.ascontiguousarray(cart_acceleration, dtype=float)
    if u.shape != (halves,):
        raise OptionError(f"the cart's acceleration must be given at the {halves} half steps, not {u.shape}")
    states = np.empty((len(grid.weights), 4))
    _trajectory(coefficients, start, u, grid.step, grid.first_sample, grid.weights, states)
    return states


@compiled
def _trajectory(coefficients, start, u, step, first_sample, weights, states):  # type: ignore[no-untyped-def]
    A23, A33, a1, c1, c2, m2_l2, g = coefficients
    theta1, theta2, omega1, omega2 = start
    alpha1, alpha2 = accelerations(theta1, theta2, omega1, omega2, u[0], A23, A33, a1, c1, c2, m2_l2, g)
    for k in range(len(first_sample) - 1):
        end1, end2, speed1, speed2 = runge_kutta_step(
            theta1, theta2, omega1, omega2, step, u[2 * k], u[2 * k + 1], u[2 * k + 2], A23, A33, a1, c1, c2, m2_l2, g
        )
        beta1, beta2 = accelerations(end1, end2, speed1, speed2, u[2 * k + 2], A23, A33, a1, c1, c2, m2_l2, g)
        for j in range(first_sample[k], first_sample[k + 1]):
            begin, end, begin_slope, end_slope = weights[j, 0], weights[j, 1], weights[j, 2], weights[j, 3]
            states[j, 0] = begin * theta1 + end * end1 + begin_slope * omega1 + end_slope * speed1
            states[j, 1] = begin * theta2 + end * end2 + begin_slope * omega2 + end_slope * speed2
            states[j, 2] = begin * omega1 + end * speed1 + begin_slope * alpha1 + end_slope * beta1
            states[j, 3] = begin * omega2 + end * speed2 + begin_slope * alpha2 + end_slope * beta2
        theta1, theta2, omega1, omega2, alpha1, alpha2 = end1, end2, speed1, speed2, beta1, beta2

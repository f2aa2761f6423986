"""A motion together with its derivatives with respect to its start and to the coefficients.

The derivatives are carried forward through the same Runge-Kutta steps as the motion itself (the tangent linear model
of the integrator), all directions side by side in the lanes of a vector register.
"""

import numpy as np
import numpy.typing as npt

from cdp_ident.model.compilation import compiled
from cdp_ident.model.equations import acceleration_derivatives
from cdp_ident.model.time_grid import TimeGrid

Array = npt.NDArray[np.float64]

DIRECTIONS = 11
"""Directions of the derivatives: the start's four numbers, then the seven coefficients."""
_LANES = 16


def simulate_with_sensitivities(
    coefficients: Array, start: Array, grid: TimeGrid, u: Array, theta: Array, sensitivities: Array
) -> None:
    """Fill in the angles at the grid's measurement times and their derivatives.

    Args:
        coefficients: (7,) `COEFFICIENTS` of the pendulum.
        start: (4,) state at time 0: theta1, theta2 [rad], omega1, omega2 [rad/s].
        grid: the integrator's steps and the measurement times.
        u: (2 steps + 1,) the cart's acceleration at the half steps [m/s^2].
        theta: (n, 2) takes the angles [rad].
        sensitivities: (n, 2, 11) takes their derivatives in the `DIRECTIONS`.
    """
    _tangent_trajectory(coefficients, start, u, grid.step, grid.first_sample, grid.weights, theta, sensitivities)


@compiled
def _tangent_trajectory(  # type: ignore[no-untyped-def]
    coefficients, start, u, step, first_sample, weights, theta, sensitivities
):
    A23, A33, a1, c1, c2, m2_l2, g = coefficients
    by_state, by_coefficient = np.empty((2, 4)), np.empty((2, 7))
    # Tangents of theta1, theta2, omega1, omega2, their slopes at a stage, and the Runge-Kutta sum of the slopes.
    tangent, before, slope, total = (
        np.zeros((4, _LANES)), np.empty((4, _LANES)), np.zeros((4, _LANES)), np.empty((4, _LANES)),
    )  # fmt: skip
    direct = np.zeros((2, _LANES))
    for k in range(4):
        tangent[k, k] = 1.0
    state, rate, summed, begun = start.copy(), np.zeros(4), np.empty(4), np.empty(4)
    for k in range(len(first_sample) - 1):
        begun[:] = state
        before[:] = tangent
        summed[:] = 0.0
        total[:] = 0.0
        for stage in range(4):
            offset = 0.0 if stage == 0 else (step if stage == 3 else 0.5 * step)
            weight = step / 6.0 if stage in (0, 3) else step / 3.0
            omega1, omega2 = state[2] + offset * rate[2], state[3] + offset * rate[3]
            alpha1, alpha2 = acceleration_derivatives(
                state[0] + offset * rate[0], state[1] + offset * rate[1], omega1, omega2,
                u[2 * k + (stage + 1) // 2], A23, A33, a1, c1, c2, m2_l2, g, by_state, by_coefficient,
            )  # fmt: skip
            rate[0], rate[1], rate[2], rate[3] = omega1, omega2, alpha1, alpha2
            for r in range(4):
                summed[r] += weight * rate[r]
            for r in range(2):
                for p in range(7):
                    direct[r, 4 + p] = by_coefficient[r, p]
            s00, s01, s02, s03 = by_state[0, 0], by_state[0, 1], by_state[0, 2], by_state[0, 3]
            s10, s11, s12, s13 = by_state[1, 0], by_state[1, 1], by_state[1, 2], by_state[1, 3]
            for i in range(_LANES):
                t1 = tangent[0, i] + offset * slope[0, i]
                t2 = tangent[1, i] + offset * slope[1, i]
                w1 = tangent[2, i] + offset * slope[2, i]
                w2 = tangent[3, i] + offset * slope[3, i]
                v1 = s00 * t1 + s01 * t2 + s02 * w1 + s03 * w2 + direct[0, i]
                v2 = s10 * t1 + s11 * t2 + s12 * w1 + s13 * w2 + direct[1, i]
                slope[0, i], slope[1, i], slope[2, i], slope[3, i] = w1, w2, v1, v2
                total[0, i] += weight * w1
                total[1, i] += weight * w2
                total[2, i] += weight * v1
                total[3, i] += weight * v2
        for r in range(4):
            state[r] += summed[r]
            for i in range(_LANES):
                tangent[r, i] += total[r, i]
        for j in range(first_sample[k], first_sample[k + 1]):
            begin, end, begin_slope, end_slope = weights[j, 0], weights[j, 1], weights[j, 2], weights[j, 3]
            for r in range(2):
                theta[j, r] = begin * begun[r] + end * state[r] + begin_slope * begun[2 + r] + end_slope * state[2 + r]
                for i in range(DIRECTIONS):
                    sensitivities[j, r, i] = (
                        begin * before[r, i]
                        + end * tangent[r, i]
                        + begin_slope * before[2 + r, i]
                        + end_slope * tangent[2 + r, i]
                    )

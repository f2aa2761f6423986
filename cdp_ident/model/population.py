# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Many pendulums at once, each compared with the same measured motions, for the genetic search.

The members of the population lie in lanes side by side, and the compiled loop over lanes does the whole
Runge-Kutta step of each, so that one instruction of the processor moves several members.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.errors import OptionError
from cdp_ident.machine.compilation import compiled, inlined
from cdp_ident.machine.parallel import parallel_for
from cdp_ident.model.formulas.compiled import pushes
from cdp_ident.model.rates import copy, sine_and_cosine
from cdp_ident.model.time_grid import DEFAULT_STEP, TimeGrid

_LANES = 16
"""Members moved together: two of the widest vector registers, so that one waits while the other computes.

With fewer, LLVM does not vectorise the loop over lanes; with more, the state no longer stays in the fastest cache.
"""


@dataclass(frozen=True)
class Segment:
    """A stretch of measured motion and the initial state of its simulation."""

    start: Array
    """(4,) state at time 0: theta1, theta2 [rad], omega1, omega2 [rad/s]."""
    time: Array
    """(n,) times of the samples from the segment's start on [s], ascending, none below 0."""
    theta: Array
    """(n, 2) measured angles [rad]."""
    cart_acceleration: Array | None = None
    """(n,) cart's acceleration u at the samples [m/s^2], or None for a cart at rest."""
    torques: Array | None = None
    """(n, 2) torques of motors in both joints at the samples [N m], or None for joints that are free."""

    def __post_init__(self) -> None:
        """Refuse parts that do not fit together, which compiled code would not notice."""
        samples = len(self.time)
        u = (samples,) if self.cart_acceleration is None else self.cart_acceleration.shape
        torques = (samples, 2) if self.torques is None else self.torques.shape
        of_angles = {self.theta.shape, torques}
        if self.start.shape != (4,) or of_angles != {(samples, 2)} or u != (samples,):
            raise OptionError(
                f"a segment of {samples} samples needs a start (4,), angles ({samples}, 2) and, if any, the cart's "
                f"acceleration ({samples},) and torques ({samples}, 2); it got {self.start.shape}, "
                f"{self.theta.shape}, {u} and {torques}"
            )


class Population:
    """The squared error of any number of pendulums over fixed segments of measured motion."""

    def __init__(self, segments: Sequence[Segment], step: float = DEFAULT_STEP):
        """Lay out the segments for the compiled loop; `step` is the integrator's [s]."""
        grids = [TimeGrid.over(segment.time, step) for segment in segments]
        self._segments = [
            (
                np.ascontiguousarray(segment.start, dtype=float),
                inputs_at_half_steps(segment, grid),
                grid.step,
                grid.first_sample,
                grid.weights,
                np.ascontiguousarray(segment.theta, dtype=float),
            )
            for segment, grid in zip(segments, grids, strict=True)
        ]

    def squared_errors(self, coefficients: Array, inertia: Array | float = np.inf) -> Array:
        """Return the sum of Eq. (10) over each segment for each pendulum, (members, segments) [rad^2].

        It is infinite where the motion of a member could not be computed. Given are the `COEFFICIENTS` (members, 7),
        and the inertias A22 (members,) [kg m^2], which matter where motors act.
        """
        members = len(coefficients)
        coefficients = np.column_stack([coefficients, np.broadcast_to(1.0 / np.asarray(inertia), members)])
        blocks = -(-members // _LANES)
        # Lanes beyond the last member repeat it, so that every member is computed by the same instructions.
        padded = np.concatenate([coefficients, np.repeat(coefficients[-1:], blocks * _LANES - members, axis=0)])
        lanes = np.ascontiguousarray(padded.reshape(blocks, _LANES, -1).transpose(0, 2, 1))
        errors = np.empty((blocks, len(self._segments), _LANES))

        def work(first: int, last: int) -> None:
            for item in range(first, last):
                block, segment = divmod(item, len(self._segments))
                _squared_errors(lanes[block], *self._segments[segment], errors[block, segment])

        parallel_for(work, blocks * len(self._segments))
        by_member = errors.transpose(0, 2, 1).reshape(blocks * _LANES, -1)[:members]
        return np.where(np.isfinite(by_member), by_member, np.inf)


def inputs_at_half_steps(segment: Segment, grid: TimeGrid) -> Array:
    """Return the cart's acceleration [m/s^2] and both motors' torques [N m] at the half steps of a grid (k, 3)."""
    times = grid.half_step_times()
    inputs = np.zeros((len(times), 3))
    if segment.cart_acceleration is not None:
        inputs[:, 0] = np.interp(times, segment.time, segment.cart_acceleration)
    torques = grid.at_half_steps(segment.time, segment.torques)
    if torques is not None:
        inputs[:, 1:] = torques
    return inputs


@inlined
def _accelerations(theta1, theta2, omega1, omega2, inputs, pendulum, per_inertia):
    (u, inner, outer), A33 = inputs, pendulum[1]
    sin1, cos1 = sine_and_cosine(theta1)
    sin2, cos2 = sine_and_cosine(theta2)
    n1, n2, m = pushes(u, (sin1, cos1, sin2, cos2), (omega1, omega2), pendulum)
    n1, n2 = n1 + per_inertia * (inner - outer), n2 + per_inertia * outer
    inverse = 1.0 / (A33 - m * m)
    return (A33 * n1 - m * n2) * inverse, (n2 - m * n1) * inverse


@inlined
def _runge_kutta_step(theta1, theta2, omega1, omega2, step, inputs, pendulum):
    """Return the state after one step, given the inputs at its beginning, middle and end."""
    half, (u0, u1, u2) = 0.5 * step, inputs
    k1, j1 = _accelerations(theta1, theta2, omega1, omega2, u0, *pendulum)
    p1, q1 = omega1 + half * k1, omega2 + half * j1
    k2, j2 = _accelerations(theta1 + half * omega1, theta2 + half * omega2, p1, q1, u1, *pendulum)
    p2, q2 = omega1 + half * k2, omega2 + half * j2
    k3, j3 = _accelerations(theta1 + half * p1, theta2 + half * q1, p2, q2, u1, *pendulum)
    p3, q3 = omega1 + step * k3, omega2 + step * j3
    k4, j4 = _accelerations(theta1 + step * p2, theta2 + step * q2, p3, q3, u2, *pendulum)
    sixth = step / 6.0
    return (
        theta1 + sixth * (omega1 + 2.0 * p1 + 2.0 * p2 + p3),
        theta2 + sixth * (omega2 + 2.0 * q1 + 2.0 * q2 + q3),
        omega1 + sixth * (k1 + 2.0 * k2 + 2.0 * k3 + k4),
        omega2 + sixth * (j1 + 2.0 * j2 + 2.0 * j3 + j4),
    )


@compiled
def _squared_errors(lanes, start, inputs, step, first_sample, weights, theta, errors):
    theta1, theta2 = np.empty(_LANES), np.empty(_LANES)
    omega1, omega2 = np.empty(_LANES), np.empty(_LANES)
    before1, before2 = np.empty(_LANES), np.empty(_LANES)
    speed1, speed2 = np.empty(_LANES), np.empty(_LANES)
    sums = np.zeros(_LANES)
    A23, A33, a1, c1, c2, L, g = lanes[0], lanes[1], lanes[2], lanes[3], lanes[4], lanes[5], lanes[6]
    per_inertia = lanes[7]
    for i in range(_LANES):
        theta1[i], theta2[i], omega1[i], omega2[i] = start[0], start[1], start[2], start[3]
    for k in range(len(first_sample) - 1):
        begins = inputs[2 * k, 0], inputs[2 * k, 1], inputs[2 * k, 2]
        halfway = inputs[2 * k + 1, 0], inputs[2 * k + 1, 1], inputs[2 * k + 1, 2]
        ends = inputs[2 * k + 2, 0], inputs[2 * k + 2, 1], inputs[2 * k + 2, 2]
        for i in range(_LANES):
            before1[i], before2[i], speed1[i], speed2[i] = theta1[i], theta2[i], omega1[i], omega2[i]
            theta1[i], theta2[i], omega1[i], omega2[i] = _runge_kutta_step(
                theta1[i], theta2[i], omega1[i], omega2[i], step, (begins, halfway, ends),
                ((A23[i], A33[i], a1[i], c1[i], c2[i], L[i], g[i]), per_inertia[i]),
            )  # fmt: skip
        for j in range(first_sample[k], first_sample[k + 1]):
            begin, end, begin_slope, end_slope = weights[j, 0], weights[j, 1], weights[j, 2], weights[j, 3]
            measured1, measured2 = theta[j, 0], theta[j, 1]
            for i in range(_LANES):
                error1 = begin * before1[i] + end * theta1[i] + begin_slope * speed1[i] + end_slope * omega1[i]
                error2 = begin * before2[i] + end * theta2[i] + begin_slope * speed2[i] + end_slope * omega2[i]
                error1 -= measured1
                error2 -= measured2
                sums[i] += error1 * error1 + error2 * error2
    copy(sums, errors)

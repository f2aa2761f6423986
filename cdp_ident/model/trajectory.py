"""The motion of one pendulum, with any effects, and on request its derivatives.

The derivatives, with respect to the start, to the coefficients and to parameters of effects, are carried forward
through the same Runge-Kutta steps as the motion itself (the tangent linear model of the integrator), all directions
side by side in the lanes of vector registers. An effect states only its torque: what is needed of that torque's
derivatives, in four state variables and its own parameters, is taken by differences of the torque.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from cdp_ident.model.compilation import compiled, inlined, part
from cdp_ident.model.effects.catalogue import effect_torque, kind_of
from cdp_ident.model.effects.constants import COUNT
from cdp_ident.model.effects.effect import TorqueEffect
from cdp_ident.model.equations import acceleration_derivatives, accelerations
from cdp_ident.model.time_grid import TimeGrid

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

DIRECTIONS = 11
"""Directions in which derivatives are always carried: the start's four numbers, then the seven coefficients."""
_VECTOR = 8
"""Lanes are made a multiple of the widest vector register's."""
_MOST_PARAMETERS = 3


@dataclass(frozen=True)
class Torques:
    """The torques of effects as compiled code takes them."""

    kinds: Indices = field(default_factory=lambda: np.empty(0, dtype=np.int64))
    """(effects,) the number of each one's formula."""
    values: Array = field(default_factory=lambda: np.empty((0, _MOST_PARAMETERS)))
    """(effects, 3) their parameters."""
    constants: Array = field(default_factory=lambda: np.zeros(COUNT))
    """What formulas know of the mechanism: see `effect_constants`."""
    directions: Indices = field(default_factory=lambda: np.empty((0, 2), dtype=np.int64))
    """(k, 2) effect and parameter of each further direction, the effects ascending."""

    @classmethod
    def of(
        cls,
        effects: Sequence[tuple[TorqueEffect, Sequence[float]]],
        constants: Array,
        directions: Sequence[tuple[int, int]] = (),
    ) -> "Torques":
        """Lay out effects with their parameters."""
        values = np.zeros((len(effects), _MOST_PARAMETERS))
        for row, (_, parameters) in zip(values, effects, strict=True):
            row[: len(parameters)] = parameters
        kinds = np.array([kind_of(effect) for effect, _ in effects], dtype=np.int64)
        return cls(kinds, values, constants, np.array(directions, dtype=np.int64).reshape(-1, 2))


NO_TORQUES = Torques()


def trajectory(
    coefficients: Array, start: Array, grid: TimeGrid, u: Array, torques: Torques = NO_TORQUES, begin: float = 0.0
) -> Array:
    """Return the states (n, 4) at the grid's measurement times: theta1, theta2 [rad], omega1, omega2 [rad/s].

    Args:
        coefficients: (7,) `COEFFICIENTS` of the pendulum.
        start: (4,) state at the grid's time 0.
        grid: the integrator's steps and the measurement times.
        u: (2 steps + 1,) the cart's acceleration at the half steps [m/s^2].
        torques: of effects.
        begin: time in the trial at the grid's time 0 [s], for effects that happen at an instant.
    """
    states = np.empty((len(grid.weights), 4))
    _run(coefficients, start, grid, u, torques, begin, 0, states, np.empty((0, 0, 0)))
    return states


def trajectory_with_derivatives(
    coefficients: Array, start: Array, grid: TimeGrid, u: Array, torques: Torques = NO_TORQUES, begin: float = 0.0
) -> tuple[Array, Array]:
    """Return states (n, 4) as `trajectory` does, and their derivatives (n, 4, 11 + k).

    The directions are the start's four numbers, the seven coefficients, and the k parameters of effects that
    `torques.directions` names.
    """
    directions = DIRECTIONS + len(torques.directions)
    lanes = -(-directions // _VECTOR) * _VECTOR
    states, derivatives = np.empty((len(grid.weights), 4)), np.empty((len(grid.weights), 4, directions))
    _run(coefficients, start, grid, u, torques, begin, lanes, states, derivatives)
    return states, derivatives


def accelerations_at(
    coefficients: Array, states: Array, u: Array, torques: Torques = NO_TORQUES, times: Array | None = None
) -> Array:
    """Return the angular accelerations (n, 2) [rad/s^2] in given states (n, 4).

    Args:
        coefficients: (7,) `COEFFICIENTS` of the pendulum.
        states: (n, 4) theta1, theta2 [rad], omega1, omega2 [rad/s].
        u: (n,) the cart's acceleration [m/s^2].
        torques: of effects.
        times: (n,) times in the trial [s], for effects that happen at an instant.
    """
    rates = np.empty((len(states), 4))
    times = np.zeros(len(states)) if times is None else times
    _accelerations_at(coefficients, states, u, times, torques.kinds, torques.values, torques.constants, rates)
    return rates[:, 2:]


def _run(
    coefficients: Array,
    start: Array,
    grid: TimeGrid,
    u: Array,
    torques: Torques,
    begin: float,
    lanes: int,
    states: Array,
    derivatives: Array,
) -> None:
    # Compiled once, for arrays that may be written to: processes that keep code for several kinds of arrays at the same
    # time could take one's for the other's.
    u = u if u.flags.writeable else u.copy()
    _trajectory(
        coefficients, start, begin, u, grid.step, grid.first_sample, grid.weights,
        torques.kinds, torques.values, torques.constants, torques.directions, lanes, states, derivatives,
    )  # fmt: skip


_NUDGE = 1e-6
"""Step of the differences of effects' torques: [rad], [rad/s], or relative to a parameter of at least 1e-3."""


@inlined
def _is_present(values, e):
    # Strengths are among an effect's first two parameters; with none it is no effect, wherever the pendulum is.
    return values[e, 0] != 0.0 or values[e, 1] != 0.0


@part
def _add_effects(state, time, kinds, values, constants, directions, i11, i12, i22, by_state, direct):
    """Add to the accelerations' derivatives what they owe to effects."""
    j = 0
    for e in range(len(kinds)):
        at1, at2 = 0.0, 0.0
        if _is_present(values, e):
            at1, at2 = effect_torque(kinds[e], state[0], state[1], state[2], state[3], time, values, e, constants)
            for k in range(4):
                kept = state[k]
                state[k] = kept + _NUDGE
                up1, up2 = effect_torque(kinds[e], state[0], state[1], state[2], state[3], time, values, e, constants)
                state[k] = kept
                d1, d2 = (up1 - at1) / _NUDGE, (up2 - at2) / _NUDGE
                by_state[0, k] += i11 * d1 + i12 * d2
                by_state[1, k] += i12 * d1 + i22 * d2
        while j < len(directions) and directions[j, 0] == e:
            p = directions[j, 1]
            kept = values[e, p]
            nudge = _NUDGE * max(abs(kept), 1e-3)
            values[e, p] = kept + nudge
            up1, up2 = effect_torque(kinds[e], state[0], state[1], state[2], state[3], time, values, e, constants)
            values[e, p] = kept
            d1, d2 = (up1 - at1) / nudge, (up2 - at2) / nudge
            direct[0, DIRECTIONS + j] = i11 * d1 + i12 * d2
            direct[1, DIRECTIONS + j] = i12 * d1 + i22 * d2
            j += 1


@part
def _differentiate(state, time, u, coefficients, kinds, values, constants, directions, rates, stage, by_state, direct):
    """Fill in the state's rate of change at a stage and, where there are lanes, its derivatives."""
    theta1, theta2, omega1, omega2 = state[0], state[1], state[2], state[3]
    A23, A33, a1, c1, c2, m2_l2, g = (
        coefficients[0], coefficients[1], coefficients[2], coefficients[3], coefficients[4], coefficients[5],
        coefficients[6],
    )  # fmt: skip
    extra1, extra2 = 0.0, 0.0
    for e in range(len(kinds)):
        if _is_present(values, e):
            added1, added2 = effect_torque(kinds[e], theta1, theta2, omega1, omega2, time, values, e, constants)
            extra1 += added1
            extra2 += added2
    rates[stage, 0], rates[stage, 1] = omega1, omega2
    if direct.shape[1] == 0:
        rates[stage, 2], rates[stage, 3] = accelerations(
            theta1, theta2, omega1, omega2, u, A23, A33, a1, c1, c2, m2_l2, g, extra1, extra2
        )
        return
    rates[stage, 2], rates[stage, 3], i11, i12, i22 = acceleration_derivatives(
        theta1, theta2, omega1, omega2, u, A23, A33, a1, c1, c2, m2_l2, g, extra1, extra2, by_state, direct, 4
    )
    if len(kinds) > 0:
        _add_effects(state, time, kinds, values, constants, directions, i11, i12, i22, by_state, direct)


@part
def _propagate(tangent, offset, slopes, before, stage, by_state, direct):
    """Fill in the tangents' slopes at a stage, at `tangent + offset slopes[before]`."""
    s00, s01, s02, s03 = by_state[0, 0], by_state[0, 1], by_state[0, 2], by_state[0, 3]
    s10, s11, s12, s13 = by_state[1, 0], by_state[1, 1], by_state[1, 2], by_state[1, 3]
    for i in range(tangent.shape[1]):
        t1 = tangent[0, i] + offset * slopes[before, 0, i]
        t2 = tangent[1, i] + offset * slopes[before, 1, i]
        w1 = tangent[2, i] + offset * slopes[before, 2, i]
        w2 = tangent[3, i] + offset * slopes[before, 3, i]
        slopes[stage, 0, i] = w1
        slopes[stage, 1, i] = w2
        slopes[stage, 2, i] = s00 * t1 + s01 * t2 + s02 * w1 + s03 * w2 + direct[0, i]
        slopes[stage, 3, i] = s10 * t1 + s11 * t2 + s12 * w1 + s13 * w2 + direct[1, i]


@compiled
def _trajectory(
    coefficients, start, begin, u, step, first_sample, weights,
    kinds, given_values, constants, directions, lanes, states, derivatives,
):  # fmt: skip
    values = given_values.copy()  # differences nudge them
    by_state, direct = np.zeros((2, 4)), np.zeros((2, lanes))
    state, at, rates = start.copy(), np.empty(4), np.empty((5, 4))
    # The tangents at a step's beginning and end, and their slopes at the four stages and the end.
    tangent, ended, slopes = np.zeros((4, lanes)), np.empty((4, lanes)), np.zeros((5, 4, lanes))
    for k in range(min(4, lanes)):
        tangent[k, k] = 1.0
    end = np.empty(4)
    _differentiate(state, begin, u[0], coefficients, kinds, values, constants, directions, rates, 0, by_state, direct)
    _propagate(tangent, 0.0, slopes, 4, 0, by_state, direct)
    for k in range(len(first_sample) - 1):
        time = begin + k * step
        for stage in range(1, 4):
            offset = step if stage == 3 else 0.5 * step
            for r in range(4):
                at[r] = state[r] + offset * rates[stage - 1, r]
            _differentiate(
                at, time + offset, u[2 * k + (stage + 1) // 2], coefficients, kinds, values, constants, directions,
                rates, stage, by_state, direct,
            )  # fmt: skip
            _propagate(tangent, offset, slopes, stage - 1, stage, by_state, direct)
        sixth = step / 6.0
        for r in range(4):
            end[r] = state[r] + sixth * (rates[0, r] + 2.0 * rates[1, r] + 2.0 * rates[2, r] + rates[3, r])
            for i in range(lanes):
                ended[r, i] = tangent[r, i] + sixth * (
                    slopes[0, r, i] + 2.0 * slopes[1, r, i] + 2.0 * slopes[2, r, i] + slopes[3, r, i]
                )
        # The rates at the end are the next step's first, and give the measurements in this one their slopes.
        _differentiate(
            end, time + step, u[2 * k + 2], coefficients, kinds, values, constants, directions,
            rates, 4, by_state, direct,
        )  # fmt: skip
        _propagate(ended, 0.0, slopes, 3, 4, by_state, direct)
        for j in range(first_sample[k], first_sample[k + 1]):
            w0, w1, w2, w3 = weights[j, 0], weights[j, 1], weights[j, 2], weights[j, 3]
            for r in range(4):
                states[j, r] = w0 * state[r] + w1 * end[r] + w2 * rates[0, r] + w3 * rates[4, r]
                for i in range(derivatives.shape[2]):
                    derivatives[j, r, i] = (
                        w0 * tangent[r, i] + w1 * ended[r, i] + w2 * slopes[0, r, i] + w3 * slopes[4, r, i]
                    )
        state[:] = end
        rates[0] = rates[4]
        tangent[:] = ended
        slopes[0] = slopes[4]


@compiled
def _accelerations_at(coefficients, states, u, times, kinds, values, constants, rates):
    nothing, directions = np.empty((2, 0)), np.empty((0, 2), dtype=np.int64)
    for j in range(len(states)):
        _differentiate(
            states[j], times[j], u[j], coefficients, kinds, values, constants, directions, rates, j, nothing, nothing
        )

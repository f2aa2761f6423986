"""The motion of one pendulum, with any effects, and on request its derivatives.

The derivatives, with respect to the initial state, to the coefficients and to parameters of effects, are carried
forward through the same Runge-Kutta steps as the motion itself (the tangent linear model of the integrator), all
directions side by side in the lanes of vector registers. A step is divided where a joint with dry friction stops or
breaks loose (`sticking`), and where its error would be too large (`is_rough`).
"""

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from cdp_ident.model.compilation import compiled, part, with_arrays
from cdp_ident.model.dynamics import COUNT_OF_SUMS, STICKS
from cdp_ident.model.effects.effect import Form
from cdp_ident.model.equations import RODS_STATES
from cdp_ident.model.events import AT_ONCE, SMALLEST, instant_of, share_by_speed
from cdp_ident.model.initial_value_problem import EndToEnd, InitialValueProblem
from cdp_ident.model.parameters import COEFFICIENTS
from cdp_ident.model.runge_kutta import copy, hermite, input_at, is_rough, step_on
from cdp_ident.model.sticking import carry_across, dip, hold, inertia_of_both, settle, stop, violation
from cdp_ident.model.tangents import (
    BLOCK,
    OLD,
    STAGES,
    VECTOR,
    accept,
    advance,
    begin_tangents,
    blocks_of,
    reading,
    restart,
    room_for,
    row_of,
    size_of,
    width_of,
)
from cdp_ident.model.time_grid import TimeGrid
from cdp_ident.model.torques import NO_TORQUES, Torques

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

_COEFFICIENTS = len(COEFFICIENTS)
_BASE = int(Form.BASE)
MOST_EVENTS = 32
"""Most events in one step; further ones are ignored."""
_MOST_PARTS = 4096
"""A step that needs more parts, of 1/256 or up to an event, has a motion that cannot be computed: it is given up."""
FASTEST = math.pi
"""No step resolves a rod that turns by more than this within it [rad]: such a motion is given up."""


def trajectory(
    coefficients: Array, start: Array, grid: TimeGrid, u: Array, torques: Torques = NO_TORQUES, begin: float = 0.0
) -> Array:
    """Return the states (n, states) at the grid's measurement times.

    They are theta1, theta2 [rad], omega1, omega2 [rad/s] and the states that effects bring; not a number from where a
    rod turns by more than half a turn within a step, as it does from a senseless initial state.

    Args:
        coefficients: (7,) `COEFFICIENTS` of the pendulum.
        start: (states,) state at the grid's time 0; what is left out at its end is zero.
        grid: the integrator's steps and the measurement times.
        u: (2 steps + 1,) the cart's acceleration at the half steps [m/s^2].
        torques: of effects.
        begin: time in the trial at the grid's time 0 [s], for effects that happen at an instant.
    """
    return motions([InitialValueProblem(coefficients, start, grid, u, torques, begin)])[0]


def trajectory_with_derivatives(
    coefficients: Array,
    start: Array,
    grid: TimeGrid,
    u: Array,
    torques: Torques = NO_TORQUES,
    begin: float = 0.0,
    by_start_only: bool = False,
    of_angles_only: bool = False,
) -> tuple[Array, Array]:
    """Return states (n, states) as `trajectory` does, and their derivatives (n, states, directions).

    The directions are the numbers of the initial state and, unless those alone are asked for, the seven coefficients
    and the parameters of effects that `torques.lanes` names: see `directions`. On request only the derivatives of
    theta1 and theta2 are returned (n, 2, directions).
    """
    problem = InitialValueProblem(coefficients, start, grid, u, torques, begin)
    states, derivatives, _ = motions_with_derivatives([problem], by_start_only, of_angles_only)
    return states, derivatives


def motions(problems: Sequence[InitialValueProblem]) -> tuple[Array, Array, Indices]:
    """Return the states (samples, states) of problems with the same effects, end to end, as `trajectory` does of one.

    There are no derivatives (samples, 2, 0); the third array (problems + 1,) says where each one's samples begin, and
    the last one's end.
    """
    return _motions(problems, 0, 2, 0)


def motions_with_derivatives(
    problems: Sequence[InitialValueProblem], by_start_only: bool = False, of_angles_only: bool = False
) -> tuple[Array, Array, Indices]:
    """Return the same with derivatives (samples, states or 2, directions), as `trajectory_with_derivatives` does."""
    torques = problems[0].torques
    count = torques.states if by_start_only else directions(torques)
    return _motions(problems, -(-count // VECTOR) * VECTOR, 2 if of_angles_only else torques.states, count)


def directions(torques: Torques) -> int:
    """Return in how many directions `trajectory_with_derivatives` carries derivatives."""
    return torques.states + _COEFFICIENTS + torques.directions


def accelerations_at(
    coefficients: Array, states: Array, u: Array, torques: Torques = NO_TORQUES, times: Array | None = None
) -> Array:
    """Return the angular accelerations (n, 2) [rad/s^2] in given states.

    Args:
        coefficients: (7,) `COEFFICIENTS` of the pendulum.
        states: (n, states) theta1, theta2 [rad], omega1, omega2 [rad/s] and those that effects bring; where these are
            left out, so are their effects.
        u: (n,) the cart's acceleration [m/s^2].
        torques: of effects.
        times: (n,) times in the trial [s], for effects that happen at an instant.
    """
    rates = np.empty(states.shape)
    times = np.zeros(len(states)) if times is None else times
    if states.shape[1] == RODS_STATES:
        torques = torques.of_rods(np.ones(len(torques.table), dtype=bool))
    _accelerations_at(
        coefficients, states, u, times, torques.table, torques.values, torques.lanes, torques.constants, rates
    )
    return rates[:, 2:RODS_STATES]


def _motions(
    problems: Sequence[InitialValueProblem], lanes: int, rows: int, count: int
) -> tuple[Array, Array, Indices]:
    """Return the same, derivatives (samples, rows, count) being carried in so many lanes."""
    torques, laid_out = problems[0].torques, EndToEnd(problems)
    with_parameters = count > torques.states
    samples = int(laid_out.grids[-1][-1])
    states, derivatives = np.empty((samples, torques.states)), np.empty((samples, rows, count))
    computed = np.empty(len(problems), dtype=np.int64)
    _trajectories(
        laid_out.coefficients, laid_out.starts(torques.states), laid_out.begins, *laid_out.grids,
        torques.table, np.array([problem.torques.values for problem in problems]),
        torques.lanes if with_parameters else np.full_like(torques.lanes, -1),
        np.array([problem.torques.constants for problem in problems]),
        lanes, states, derivatives, computed,
    )  # fmt: skip
    laid_out.mark_uncomputed(states, derivatives, computed)
    return states, derivatives, laid_out.grids[-1]


@compiled
def _trajectories(
    coefficients, starts, begins, step, u, of_u, first_sample, of_steps, place, of_samples, table, values, lanes_of,
    constants, lanes, states, derivatives, computed,
):  # fmt: skip
    """Compute motions with the same effects one after the other, and fill in how many measurements each reaches.

    Args:
        coefficients: (motions, 7) `COEFFICIENTS` of each.
        starts: (motions, n) state at the beginning.
        begins: (motions,) time in the trial then [s].
        step: (motions,) as `EndToEnd.grids`, like all up to `of_samples`.
        u: likewise.
        of_u: likewise.
        first_sample: likewise.
        of_steps: likewise.
        place: likewise.
        of_samples: likewise.
        table: the effects, as `Torques` has them.
        values: (motions, effects, p) their parameters.
        lanes_of: the lanes of these, as `Torques` has them.
        constants: (motions, …) of the mechanism.
        lanes: in so many derivatives are carried.
        states: (samples, n) takes the states at the measurements of all motions.
        derivatives: (samples, …, directions) takes the derivatives of the first numbers of the state.
        computed: (motions,) takes how many measurements are reached.
    """
    for m in range(len(starts)):
        computed[m] = _trajectory(
            coefficients[m], starts[m], begins[m], u[of_u[m] : of_u[m + 1]], step[m],
            first_sample[of_steps[m] : of_steps[m + 1]], place[of_samples[m] : of_samples[m + 1]], table, values[m],
            lanes_of, constants[m], lanes, states[of_samples[m] : of_samples[m + 1]],
            derivatives[of_samples[m] : of_samples[m + 1]],
        )  # fmt: skip


@with_arrays
def _trajectory(
    coefficients, start, begin, u, step, first_sample, place, table, values, lanes_of, constants, lanes, states,
    derivatives,
):  # fmt: skip
    """Compute one motion, and return how many measurements it reaches."""
    n, base = len(start), -1
    dry, sought = np.zeros(2, dtype=np.bool_), np.zeros(2, dtype=np.bool_)
    turns_over = False
    for e in range(len(table)):
        turns_over = turns_over or table[e, 4] >= 0
        if table[e, 1] == _BASE:
            base = e
        if table[e, 3]:
            # A friction with a memory has no size: its joint does not stick, but steps are divided where it turns.
            dry[table[e, 2]] = True
    modes = np.ones(2, dtype=np.int64)
    state, end, at, trial_end, first_row = start.copy(), np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    rates, before, inputs, violations = np.zeros((5, n)), np.empty(n), np.empty(3), np.zeros(2)
    slopes, sums = np.zeros((2, 2 + values.shape[1])), np.zeros(COUNT_OF_SUMS)
    room = room_for(n)
    by_own, by_state = np.zeros((2, n)), np.zeros((STAGES, room - 2, room))
    by_lane, direct, no_torques, no_direct = (
        np.zeros((2, lanes)), np.zeros((STAGES, room - 2, lanes)), np.zeros((2, 0)), np.zeros((STAGES, room - 2, 0)),
    )  # fmt: skip
    tangents = np.zeros(size_of(n, lanes))
    begin_tangents(tangents, n, lanes)
    return _steps(
        begin, u, step, first_sample, place, coefficients, table, values, lanes_of, constants, base, turns_over, dry,
        sought, modes, state, end, at, trial_end, first_row, rates, before, inputs, violations, slopes, sums, by_own,
        by_lane, by_state, direct, no_torques, no_direct, tangents, states, derivatives,
    )  # fmt: skip


@part
def _steps(
    begin, u, step, first_sample, place, coefficients, table, values, lanes_of, constants, base, turns_over, dry,
    sought, modes, state, end, at, trial_end, first_row, rates, before, inputs, violations, slopes, sums, by_own,
    by_lane, by_state, direct, no_torques, no_direct, tangents, states, derivatives,
):  # fmt: skip
    """Make all steps, and return how many measurements they reach; a `part`, so that no array is counted in them."""
    n, lanes = len(state), direct.shape[2]
    longest, loose, fresh, crossed = 1.0, -1, True, -1
    for k in range(len(first_sample) - 1):
        if max(abs(state[2]), abs(state[3])) * step > FASTEST:
            return first_sample[k]
        time = begin + k * step
        inputs[0], inputs[1], inputs[2] = u[2 * k], u[2 * k + 1], u[2 * k + 2]
        done, j, events, share, stopped, located = 0.0, first_sample[k], 0, longest, -1, False
        for parts in range(_MOST_PARTS + 1):
            if done >= 1.0:
                break
            if parts == _MOST_PARTS:
                return j
            if fresh:
                # At the beginning, and after a mode has ended.
                settle(
                    state, time + done * step, input_at(inputs, done), modes, dry, loose, coefficients, table, values,
                    lanes_of, constants, base, slopes, by_own, by_lane, sums, by_state, direct,
                    rates, 0,
                )  # fmt: skip
                if lanes > 0:
                    if crossed >= 0:
                        carry_across(tangents, lanes, crossed, before, rates)
                    for joint in range(2):
                        if modes[joint] == STICKS:
                            m = inertia_of_both(state, coefficients, table, values)
                            hold(tangents, n, lanes, joint, coefficients[1], m)
                    restart(tangents, n, by_state, direct)
                fresh, loose, crossed = False, -1, -1
            if not located:
                share, stopped = min(longest, 1.0 - done), -1
                if turns_over:
                    share = min(share, share_by_speed(state, rates, table, values, step))
            step_on(
                state, done, share, step, time, inputs, modes, coefficients, table, values, lanes_of, constants, base,
                slopes, by_own, by_lane, sums, by_state, direct, at, rates, end,
            )  # fmt: skip
            if not located:
                if share > SMALLEST and is_rough(rates, share * step):
                    longest = 0.5 * share
                    continue
                if (dry[0] or dry[1]) and events < MOST_EVENTS:
                    looks = False
                    for joint in range(2):
                        violations[joint] = violation(end, joint, modes, sums) if dry[joint] else -1.0
                        may_dip = dry[joint] and modes[joint] != STICKS and dip(joint, modes, rates) > 0.0
                        sought[joint] = violations[joint] > 0.0 or may_dip
                        looks = looks or sought[joint]
                    if looks:
                        # The step is repeated, up to the instant or as before: the search has overwritten its rates.
                        whole = share
                        copy(rates[4], first_row)
                        for joint in range(2):
                            if sought[joint]:
                                copy(first_row, rates[4])
                                instant = instant_of(
                                    joint, violations[joint], state, done, whole, step, time, inputs, modes,
                                    coefficients, table, values, lanes_of, constants, base, slopes, by_own,
                                    no_torques, sums, by_state, no_direct, at, rates, trial_end,
                                )  # fmt: skip
                                if instant <= share:
                                    share, stopped = instant, joint
                        located = True
                        events += 1
                        continue
            located = False
            if lanes > 0:
                advance(tangents, n, share * step, by_state, direct)
            reached = done + share
            if reached > 1.0 - AT_ONCE:
                reached = 1.0
            while j < first_sample[k + 1] and (place[j] <= reached or reached == 1.0):
                w0, w1, w2, w3 = hermite((place[j] - done) / share, share * step)
                for r in range(n):
                    states[j, r] = w0 * state[r] + w1 * end[r] + w2 * rates[0, r] + w3 * rates[4, r]
                for r in range(derivatives.shape[1]):
                    for block in range(blocks_of(lanes)):
                        first, lane = row_of(n, block, r, OLD), np.uint64(block * BLOCK)
                        for i in range(width_of(block, derivatives.shape[2])):
                            derivatives[j, r, lane + i] = reading(tangents, first, i, w0, w1, w2, w3)
                j += 1
            copy(end, state)
            if lanes > 0:
                accept(tangents, n, lanes)
            if stopped >= 0:
                copy(rates[4], before)
                fresh = True
                if modes[stopped] == STICKS:
                    loose = stopped
                else:
                    stop(state, stopped)
                    # A joint that sticks goes on doing so, whatever the other one does.
                    if modes[1 - stopped] == STICKS:
                        stop(state, 1 - stopped)
                    crossed = stopped
            else:
                copy(rates[4], rates[0])
            done = reached
            longest = min(1.0, 2.0 * longest)
    return len(place)


@compiled
def _accelerations_at(coefficients, states, u, times, table, values, lanes_of, constants, rates):
    n, base = states.shape[1], -1
    dry = np.zeros(2, dtype=np.bool_)
    for e in range(len(table)):
        if table[e, 1] == _BASE:
            base = e
        if table[e, 3]:
            dry[table[e, 2]] = True
    slopes, sums = np.zeros((2, 2 + values.shape[1])), np.zeros(COUNT_OF_SUMS)
    modes = np.ones(2, dtype=np.int64)
    by_own, no_torques, by_state, no_direct = (
        np.zeros((2, n)), np.zeros((2, 0)), np.zeros((len(states), n - 2, n)), np.zeros((1, n - 2, 0)),
    )  # fmt: skip
    for j in range(len(states)):
        settle(
            states[j], times[j], u[j], modes, dry, -1, coefficients, table, values, lanes_of, constants, base, slopes,
            by_own, no_torques, sums, by_state, no_direct, rates, j,
        )  # fmt: skip

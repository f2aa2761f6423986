# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Motions of a pendulum from given beginnings, with any effects, and on request their derivatives."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.errors import OptionError
from cdp_ident.model import layout as at
from cdp_ident.model.acting import NO_EFFECTS, ActingEffects
from cdp_ident.model.layout import DIRECTIONS, RODS_STATES, plan_and_room
from cdp_ident.model.steps import (
    Results,
    Times,
    addresses,
    compute,
    fill_each_jacobian,
    fill_each_rate,
    fill_each_reading,
)
from cdp_ident.model.time_grid import DEFAULT_STEP, TimeGrid

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]


@dataclass(frozen=True)
class InitialValueProblem:
    """What gives one motion."""

    coefficients: Array
    """(7,) `COEFFICIENTS` of the pendulum."""
    start: Array
    """(states,) state at the grid's time 0; what is left out at its end is zero."""
    grid: TimeGrid
    """The integrator's steps and the measurement times."""
    u: Array
    """(2 steps + 1,) the cart's acceleration at the half steps [m/s^2]."""
    effects: ActingEffects = NO_EFFECTS
    begin: float = 0.0
    """Time in the trial at the grid's time 0 [s], for effects that happen at an instant."""
    drive: Array | None = None
    """(2 steps + 1, 2) the motors' torques in both joints at the half steps [N m]; None where there are none."""


@dataclass(frozen=True)
class Motions:
    """What is computed of several motions with the same effects, their samples end to end."""

    states: Array
    """(samples, states) theta1, theta2 [rad], omega1, omega2 [rad/s] and those that effects bring, where asked for."""
    readings: Array
    """(samples, 2) what the encoders of the inner and the outer joint show [rad], where asked for."""
    by: Array
    """(samples, 2 or states, directions) derivatives of these or of those."""
    ends: Array
    """(motions, states) states at the ends of the last steps."""
    ends_by: Array
    """(motions, states, directions) their derivatives."""
    bounds: Indices
    """(motions + 1,) where the samples of each begin, and the last one's end."""


def motions(problems: Sequence[InitialValueProblem], derive: bool = False, shown: bool = True) -> Motions:
    """Compute motions with the same effects, whose parameters may differ.

    Numbers are not numbers from where a rod turns by more than half a turn within a step, as it does from a senseless
    initial state. Directions of derivatives are the numbers of the initial state, then the coefficients and parameters
    that the effects name.

    Args:
        problems: what gives them.
        derive: whether derivatives are wanted.
        shown: whether readings of the encoders are, or else the states.
    """
    effects = problems[0].effects
    starts = np.zeros((len(problems), effects.states))
    for row, problem in zip(starts, problems, strict=True):
        row[: len(problem.start[: len(row)])] = problem.start[: len(row)]
    given = np.array([_given(problem.coefficients, problem.effects) for problem in problems])
    return _computed(effects, given, starts, _times(problems), derive, shown)


def motions_over(
    times: Times, coefficients: Array, starts: Array, effects: ActingEffects, derive: bool = True
) -> Motions:
    """Return what encoders show of motions of one pendulum, by default with derivatives; see `motions`.

    Args:
        times: when they are computed and read, and what moves the cart and the joints.
        coefficients: (7,) `COEFFICIENTS` of the pendulum.
        starts: (motions, states) states at the beginnings.
        effects: that act.
        derive: whether derivatives are wanted.
    """
    given = np.tile(_given(coefficients, effects), (len(starts), 1))
    return _computed(effects, given, starts, times, derive, shown=True)


def _computed(effects: ActingEffects, given: Array, starts: Array, times: Times, derive: bool, shown: bool) -> Motions:
    n, d = effects.states, effects.directions if derive else 0
    samples, count = len(times.place), len(starts)
    plan, room = plan_and_room(effects.laws(given[:, at.VALUES :]), d, addresses(n))
    carried = int(plan[DIRECTIONS])
    results = Results(
        np.empty((0 if shown else samples, n)), np.empty((samples if shown else 0, 2)),
        np.empty((samples, 2 if shown else n, carried)), np.empty((count, n)), np.empty((count, n, carried)),
    )  # fmt: skip
    compute(plan, given, starts, times, room, results)
    states, readings, by, ends, ends_by = results
    found = Motions(states, readings, by[..., :d], ends, ends_by[..., :d], times.samples_at)
    _mark_uncomputed(found, readings if shown else states)
    return found


def _given(coefficients: Array, effects: ActingEffects) -> Array:
    return np.concatenate([coefficients, [effects.outer_length, effects.carried], effects.values])


def _times(problems: Sequence[InitialValueProblem]) -> Times:
    grids = [problem.grid for problem in problems]

    def begins(lengths: list[int]) -> Indices:
        return np.concatenate([[0], np.cumsum(lengths)]).astype(np.int64)

    return Times(
        np.array([problem.begin for problem in problems], dtype=float),
        np.array([grid.step for grid in grids]),
        begins([grid.steps for grid in grids]),
        begins([len(grid.place) for grid in grids]),
        np.concatenate([grid.place for grid in grids]),
        np.concatenate([problem.u for problem in problems]),
        np.concatenate([np.zeros((0, 2)) if problem.drive is None else problem.drive for problem in problems]),
    )


def _mark_uncomputed(found: Motions, samples: Array) -> None:
    """Let samples be no numbers from where on a motion could not be computed.

    Compiled code cannot tell numbers that are none: it may have gone on with them.
    """
    for m in np.flatnonzero(~np.isfinite(found.ends).all(axis=1)):
        first, end = found.bounds[m], found.bounds[m + 1]
        finite = np.isfinite(samples[first:end]).all(axis=1)
        lost = end if finite.all() else first + int(np.argmin(finite))
        samples[lost:end], found.by[lost:end] = np.nan, np.nan
        found.ends[m], found.ends_by[m] = np.nan, np.nan


def accelerations_at(
    coefficients: Array, states: Array, u: Array, effects: ActingEffects = NO_EFFECTS, times: Array | None = None
) -> Array:
    """Return the angular accelerations (n, 2) [rad/s^2] in given states.

    Args:
        coefficients: (7,) `COEFFICIENTS` of the pendulum.
        states: (n, states) theta1, theta2 [rad], omega1, omega2 [rad/s] and those that effects bring; where these are
            left out, they are zero.
        u: (n,) the cart's acceleration [m/s^2].
        effects: that act.
        times: (n,) times in the trial [s], for effects that happen at an instant.
    """
    whole = np.zeros((len(states), effects.states))
    whole[:, : states.shape[1]] = states[:, : effects.states]
    (plan, room), rates = (
        plan_and_room(effects.laws(effects.values[None]), 0, addresses(effects.states)),
        np.empty((len(states), effects.states)),
    )
    fill_each_rate(
        plan, _given(coefficients, effects), room, whole, np.zeros(len(states)) if times is None else times, u, rates
    )
    return rates[:, 2:RODS_STATES]


def jacobians_at(coefficients: Array, states: Array, effects: ActingEffects = NO_EFFECTS) -> Array:
    """Return the derivatives (k, 2, n) of the rods' accelerations by the state, in states (k, n), the cart at rest.

    Joints are taken to slip forwards.
    """
    n = effects.states
    plan, room = plan_and_room(effects.without_directions().laws(effects.values[None]), n, addresses(n))
    jacobians = np.empty((len(states), 2, n))
    fill_each_jacobian(plan, _given(coefficients, effects), room, np.ascontiguousarray(states, dtype=float), jacobians)
    return jacobians


def readings_of(
    coefficients: Array, rods: Array, own: Array, step: float, effects: ActingEffects, begin: float = 0.0
) -> Array:
    """Return what the encoders of both joints show (k, 2) [rad] of a motion of the rods that is given.

    Args:
        coefficients: (7,) `COEFFICIENTS` of the pendulum.
        rods: (k, 7) at each sample theta1, theta2 [rad], omega1, omega2 [rad/s], both accelerations [rad/s^2], and the
            cart's [m/s^2].
        own: (2, states) the effects' own states and their rates at the sample before; at the last one afterwards.
        step: time between samples [s].
        effects: of the encoders; none of them may be late.
        begin: time in the trial at the first sample [s].
    """
    plan, room = plan_and_room(effects.laws(effects.values[None]), 0, addresses(effects.states))
    readings = np.empty((len(rods), 2))
    fill_each_reading(plan, _given(coefficients, effects), room, np.ascontiguousarray(rods), own, step, begin, readings)
    return readings


def simulate(
    coefficients: Array,
    start: Array,
    times: Array,
    cart_acceleration: Array | None = None,
    step: float = DEFAULT_STEP,
    effects: ActingEffects = NO_EFFECTS,
    begin: float = 0.0,
) -> Array:
    """Return the states (n, states) at `times`: theta1, theta2 [rad], omega1, omega2 [rad/s], …; see `motions`.

    Args:
        coefficients: (7,) `COEFFICIENTS` of the pendulum; see `physical_coefficients` and `coefficients_of`.
        start: (4,) or (states,) state at time 0.
        times: (n,) ascending times from 0 on [s], on the integrator's steps or anywhere between.
        cart_acceleration: u [m/s^2] at `TimeGrid.over(times, step).half_step_times()`; None for a cart at rest.
        step: step of the fourth-order Runge-Kutta method [s].
        effects: that the paper's model lacks.
        begin: time in the trial at time 0 [s], for effects that happen at an instant.

    Raises:
        OptionError: an argument is of the wrong size, not finite, or not ascending.
    """
    grid = TimeGrid.over(times, step)
    coefficients = np.ascontiguousarray(coefficients, dtype=float)
    start = np.ascontiguousarray(start, dtype=float)
    if (
        coefficients.shape != (7,)
        or start.shape not in {(RODS_STATES,), (effects.states,)}
        or not np.all(np.isfinite([*coefficients, *start]))
    ):
        raise OptionError("a simulation needs 7 finite coefficients and a start of 4 finite numbers")
    halves = 2 * grid.steps + 1
    u = np.zeros(halves) if cart_acceleration is None else np.ascontiguousarray(cart_acceleration, dtype=float)
    if u.shape != (halves,):
        raise OptionError(f"the cart's acceleration must be given at the {halves} half steps, not {u.shape}")
    problem = InitialValueProblem(coefficients, start, grid, u, effects, begin)
    return motions([problem], shown=False).states

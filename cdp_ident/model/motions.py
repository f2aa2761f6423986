# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Motions of a pendulum from given beginnings, with any effects, and on request their derivatives."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cdp_ident.arrays import Array, Indices
from cdp_ident.errors import OptionError
from cdp_ident.model import layout as at
from cdp_ident.model.acting import NO_EFFECTS, ActingEffects
from cdp_ident.model.layout import DIRECTIONS, RODS_STATES, plan_and_room
from cdp_ident.model.steps import Times, addresses, compute, fill_each_rate, fill_each_reading
from cdp_ident.model.time_grid import DEFAULT_STEP, TimeGrid


@dataclass(frozen=True)
class InitialValueProblem:
    """What gives one motion."""

    coefficients: Array
    """(7,) `COEFFICIENTS` of the pendulum."""
    start: Array
    """(states,) state at the grid's time 0; what is left out at its end is zero."""
    grid: TimeGrid
    """The integrator's steps and the measurement times."""
    u: Array | None = None
    """(2 steps + 1,) the cart's acceleration at the half steps [m/s^2]; None for a cart at rest."""
    effects: ActingEffects = NO_EFFECTS
    begin: float = 0.0
    """Time in the trial at the grid's time 0 [s], for effects that happen at an instant."""
    drive: Array | None = None
    """(2 steps + 1, 2) the motors' torques in both joints at the half steps [N m]; None where there are none."""


class Motions(NamedTuple):
    """What is computed of some motions with the same effects, end to end; not a number where it cannot be."""

    states: Array
    """(samples, n) theta1, theta2 [rad], omega1, omega2 [rad/s] and those that effects bring; (0, n) if not wanted."""
    readings: Array
    """(samples, 2) what the encoders of the inner and the outer joint show [rad]; (0, 2) if not wanted."""
    by: Array
    """(samples, 2 or n, d) derivatives of these or of those."""
    ends: Array
    """(motions, n) states at the ends of the last steps."""
    ends_by: Array
    """(motions, n, d) their derivatives."""
    bounds: Indices
    """(motions + 1,) where the samples of each begin, and the last one's end."""


def motions(problems: Sequence[InitialValueProblem], derive: bool = False, shown: bool = True) -> Motions:
    """Compute motions with the same effects, whose parameters may differ.

    Numbers are not numbers from where a rod turns by more than half a turn within a step, as it does from a senseless
    initial state. Directions of derivatives, if these are wanted, are the numbers of the initial state, then the
    coefficients and parameters that the effects name. It is `shown` what encoders read, or else there are the states.
    """
    effects = problems[0].effects
    starts = np.array([np.append(p.start, np.zeros(effects.states))[: effects.states] for p in problems])
    given = np.array([_given(problem.coefficients, problem.effects) for problem in problems])
    return _computed(effects, given, starts, _times(problems), derive, shown)


def motions_over(
    times: Times, coefficients: Array, starts: Array, effects: ActingEffects, derive: bool = True
) -> Motions:
    """Return what encoders show of motions of one pendulum from states (motions, states); see `motions`."""
    given = np.tile(_given(coefficients, effects), (len(starts), 1))
    return _computed(effects, given, starts, times, derive, shown=True)


def _computed(effects: ActingEffects, given: Array, starts: Array, times: Times, derive: bool, shown: bool) -> Motions:
    n, d = effects.states, effects.directions if derive else 0
    samples, count = len(times.place), len(starts)
    plan, room = plan_and_room(effects.laws(given[:, at.VALUES :]), d, addresses(n))
    carried = int(plan[DIRECTIONS])
    found = Motions(
        np.full((0 if shown else samples, n), np.nan), np.full((samples if shown else 0, 2), np.nan),
        np.empty((samples, 2 if shown else n, carried)), np.empty((count, n)), np.empty((count, n, carried)),
        times.samples_at,
    )  # fmt: skip
    compute(plan, given, starts, times, room, found)
    _mark_uncomputed(found, found.readings if shown else found.states)
    return found._replace(by=found.by[..., :d], ends_by=found.ends_by[..., :d])


def _given(coefficients: Array, effects: ActingEffects) -> Array:
    return np.concatenate([coefficients, [effects.outer_length, effects.carried], effects.values])


def _times(problems: Sequence[InitialValueProblem]) -> Times:
    grids = [problem.grid for problem in problems]
    return Times(
        np.array([problem.begin for problem in problems], dtype=float),
        np.array([grid.step for grid in grids]),
        np.cumsum([0, *(grid.steps for grid in grids)], dtype=np.int64),
        np.cumsum([0, *(len(grid.place) for grid in grids)], dtype=np.int64),
        np.concatenate([grid.place for grid in grids]),
        np.concatenate([np.zeros(2 * p.grid.steps + 1) if p.u is None else p.u for p in problems]),
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
    """Return the angular accelerations (n, 2) [rad/s^2] in states (n, states), those that effects bring being optional.

    The cart's accelerations u (n,) are in m/s^2, and the times in the trial (n,), for effects that happen at an
    instant, in s.
    """
    times = np.zeros(len(states)) if times is None else times
    return _rates(coefficients, states, times, u, effects, np.empty((0, 2, 0)))[:, 2:RODS_STATES]


def jacobians_at(coefficients: Array, states: Array, effects: ActingEffects = NO_EFFECTS) -> Array:
    """Return the derivatives (k, 2, n) of the rods' accelerations by the state, in states (k, n), the cart at rest.

    Joints are taken to slip forwards.
    """
    jacobians, still = np.empty((len(states), 2, effects.states)), np.zeros(len(states))
    _rates(coefficients, states, still, still, effects.without_directions(), jacobians)
    return jacobians


def _rates(coefficients: Array, states: Array, times: Array, u: Array, effects: ActingEffects, by: Array) -> Array:
    n = effects.states
    whole, rates = np.zeros((len(states), n)), np.empty((len(states), n))
    whole[:, : states.shape[1]] = states[:, :n]
    plan, room = plan_and_room(effects.laws(effects.values[None]), n if len(by) else 0, addresses(n))
    fill_each_rate(plan, _given(coefficients, effects), room, whole, times, u, rates, by)
    return rates


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
    u = None if cart_acceleration is None else np.ascontiguousarray(cart_acceleration, dtype=float)
    if u is not None and u.shape != (halves,):
        raise OptionError(f"the cart's acceleration must be given at the {halves} half steps, not {u.shape}")
    problem = InitialValueProblem(coefficients, start, grid, u, effects, begin)
    return motions([problem], shown=False).states

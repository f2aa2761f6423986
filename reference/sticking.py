# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The motion of a pendulum with dry friction as it is: joints that stick and break away, each event located."""

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from reference.compilation import compiled
from reference.dry_friction import NO_FRICTION, DryFriction
from reference.mechanics import Rig
from reference.modes import change_mode, end_of_mode, first_modes
from reference.plant import Path, Plant
from reference.stepping import STAGES, STATES, System, find_rates, step
from reference.torques import Torque, table

Array = npt.NDArray[np.float64]

TOLERANCE = 1e-12
"""Of each step, absolute and relative; regular motion is then right to 1e-10 over 10 s."""
_LONGEST = 2e-3
"""Longest step [s]: short enough that a joint does not come to rest and go on unseen within it."""
_SHORTEST = 1e-12
_MOST_EVENTS = 100_000
_DONE, _TOO_SMALL, _TOO_MANY = range(3)
_WRONG = {_TOO_SMALL: "the steps became too small", _TOO_MANY: f"there are more than {_MOST_EVENTS} events"}


def motion(
    values: Mapping[str, float],
    start: Sequence[float] | Array,
    times: Array,
    inner: DryFriction = NO_FRICTION,
    outer: DryFriction = NO_FRICTION,
    torques: Sequence[Torque] = (),
) -> Array:
    """Return the states (n, 4) at times (n,): theta1, theta2 [rad], omega1, omega2 [rad/s].

    Args:
        values: physical values of all of `pendulum.SYMBOLS`.
        start: (4,) state at times[0].
        times: (n,) ascending [s].
        inner: dry friction of the inner joint.
        outer: of the outer one.
        torques: what else acts.

    Raises:
        ArithmeticError: the motion could not be followed.
    """
    return path(Plant(Rig(values), inner, outer, tuple(torques)), start, times).states


def path(plant: Plant, start: Sequence[float] | Array, times: Array, tolerance: float = TOLERANCE) -> Path:
    """Return all about a plant's motion, see `motion`; a cart that is free begins at rest at 0.

    Raises:
        ArithmeticError: the motion could not be followed.
    """
    begin = np.zeros(STATES)
    begin[:4] = start
    out, happened = followed(system_of(plant), begin, np.asarray(times, dtype=float), tolerance)
    return Path(times, out[:, :4], out[:, 8:], out[:, 4], happened[:, 0], happened[:, 1:].astype(np.int64))


def system_of(plant: Plant) -> System:
    """Return a plant as compiled code takes it."""
    frictions = (plant.inner, plant.outer)
    return (
        plant.rig.array, table(plant.torques), np.array([friction.array for friction in frictions]),
        np.array([friction.any for friction in frictions]),
    )  # fmt: skip


def followed(system: System, start: Array, times: Array, tolerance: float = TOLERANCE) -> tuple[Array, Array]:
    """Return states and accelerations (n, 10) at times (n,), and events (m, 3), from a state (8,) at the first time.

    Raises:
        ArithmeticError: the motion could not be followed.
    """
    out, events = np.empty((len(times), STATES + 2)), np.empty((_MOST_EVENTS, 3))
    ended, count = _advance(system, start, times, tolerance, out, events)
    if ended != _DONE:
        raise ArithmeticError(_WRONG[ended])
    return out, events[:count]


@compiled
def _advance(
    system: System, start: Array, times: Array, tolerance: float, out: Array, events: Array
) -> tuple[int, int]:
    """Set states and accelerations (n, 10) at times (n,), and events (m, 3); return how it ended, and their number."""
    state, end = start.copy(), np.empty(STATES)
    stages, held, rates = np.empty((STAGES, STATES)), np.empty((2, 2)), np.empty(STATES)
    modes = np.zeros(2, dtype=np.int64)
    time, longest, count = times[0], _LONGEST, 0
    first_modes(system, time, state, modes)
    for n in range(len(times)):
        while time < times[n]:
            left = times[n] - time
            h = left if left <= longest else min(longest, 0.5 * left)
            error = step(system, modes, time, state, h, end, stages, tolerance)
            factor = 5.0 if error == 0.0 else min(5.0, max(0.2, 0.9 * error**-0.125))
            if error > 1.0:
                longest = h * factor
                if longest < _SHORTEST:
                    return _TOO_SMALL, count
                continue
            longest = min(_LONGEST, max(longest, h * factor))
            ends = (
                end_of_mode(system, modes, 0, time, state, h, end, stages, tolerance),
                end_of_mode(system, modes, 1, time, state, h, end, stages, tolerance),
            )
            joint = 0 if ends[0] <= ends[1] else 1
            if ends[joint] > h:
                state[:] = end
                time = times[n] if h == left else time + h
                continue
            step(system, modes, time, state, ends[joint], end, stages, tolerance)
            state[:] = end
            time += ends[joint]
            change_mode(system, time, state, modes, joint)
            if count == len(events):
                return _TOO_MANY, count
            events[count, 0], events[count, 1], events[count, 2] = time, modes[0], modes[1]
            count += 1
        find_rates(system, modes, time, state, rates, held)
        out[n, :STATES] = state
        out[n, STATES], out[n, STATES + 1] = rates[2], rates[3]
    return _DONE, count

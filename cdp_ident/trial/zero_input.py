# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Finding the zero-input part of a recording: no hand at the rods, the cart not driven, and still moving."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy import ndimage

from cdp_ident.arrays import Array, Mask
from cdp_ident.errors import NoFreeMotionError
from cdp_ident.trial.balance import torques
from cdp_ident.trial.meaning import Balance
from cdp_ident.trial.options import TrialOptions
from cdp_ident.trial.scales import PER_UNIT
from cdp_ident.trial.weak_form import WINDOW, Motion

_REST_WINDOW = 8 * PER_UNIT
_BURIED = 4.0
"""Motion of so many times the noise tells next to nothing beside the motion before it: minutes of it would be most of
the error that is to be lowered, and each window's initial state takes up what they tell."""
_CART_WINDOW = 5 * PER_UNIT // 2
_INSTANT = PER_UNIT // 2
"""A torque that acts for no longer than this [grid points] counts as an impulse, not as a hand."""
_NEAR = 5 * PER_UNIT // 2
"""An impulse or a small torque so near [grid points] a hand is the hand's."""
_TRACE = 0.3
"""Torque next to a hand that is the hand's too, as a share of what tells of one."""
_NOISE = 14.0
"""A torque must exceed the median of the windows fitted to by this factor, which is about eight times their noise."""

_FAST = 0.4
"""Share of the typical speed at which the rods show what moves them."""
_TURNING = 0.15
"""Share of the typical speed at which a joint cannot be said to stick."""
_FEWEST = 5 * PER_UNIT
"""Windows without a joint that sticks, below which the others are taken too."""

FREE, REST, CART, HAND, MOTORS = range(5)
_CAUSES = {
    REST: "the rods are still",
    CART: "the cart is driven",
    HAND: "a hand is at the rods",
    MOTORS: "motors drive the joints, by their torque or effort",
}


@dataclass(frozen=True)
class Part:
    """A stretch of one motion to which one cause, or none, applies."""

    motion: int
    """Index of the motion."""
    cause: int
    """FREE, REST, CART, HAND or MOTORS."""
    start: float
    """Time of its beginning [s]."""
    stop: float
    """Time of its end [s]."""

    @property
    def duration(self) -> float:
        """Its length [s]."""
        return self.stop - self.start


def at_rest(motion: Motion, amplitude: float) -> Mask:
    """Return which grid points (m,) lie in a long time in which neither rod moves more than `amplitude` [rad rms].

    Nor does one move more than a few times the noise, where that is larger.
    """
    amplitude = max(amplitude, _BURIED * float(np.max(motion.angle_noise)))
    deviation = motion.angles - np.median(motion.angles, axis=0)
    width = min(_REST_WINDOW, len(deviation))
    mean = np.ones(width) / width
    moments = [np.convolve(values, mean, mode="valid") for values in (*deviation.T, *(deviation**2).T)]
    variance: Array = np.maximum(moments[2] - moments[0] ** 2, moments[3] - moments[1] ** 2)
    return _covered(variance <= amplitude**2, width)


def cart_driven(motion: Motion, limit: float) -> Mask:
    """Return near which grid points (m,) the cart moves further than `limit` [m] within 2.5 units of time."""
    travel = ndimage.maximum_filter1d(motion.cart, _CART_WINDOW) - ndimage.minimum_filter1d(motion.cart, _CART_WINDOW)
    return np.asarray(travel > limit)


def moving_windows(motion: Motion, options: TrialOptions) -> Mask:
    """Return which windows of the balance show the motion well.

    The rods are fast, for this motion, the cart is not driven, and no joint sticks: while one does, meanings of the
    angles that contradict each other can all be right. Where that leaves next to nothing, a joint may stick.
    """
    idle = at_rest(motion, options.rest_amplitude) | cart_driven(motion, options.cart_limit)
    speed = np.linalg.norm(motion.rates, axis=1)
    if np.all(idle) or len(speed) < WINDOW:
        return np.zeros(max(0, len(speed) - WINDOW + 1), dtype=bool)
    typical = np.quantile(speed[~idle], 0.9)
    centre = slice(WINDOW // 2, len(speed) - WINDOW // 2)
    moving = np.asarray(~(covering(idle, WINDOW) | (speed < _FAST * typical)[centre]))
    inner, outer = motion.rates.T
    # Whichever way the outer angle is meant, one of these is the speed of its joint.
    rates = (inner, outer, outer - inner, outer + inner)
    mean = np.ones(WINDOW) / WINDOW
    slowest = np.min([np.convolve(rate**2, mean, mode="valid") for rate in rates], axis=0)
    lively = moving & (slowest > (_TURNING * typical) ** 2)
    return lively if np.count_nonzero(lively) >= _FEWEST else moving


def find_parts(
    motions: Sequence[Motion], balance: Balance | None, driven: Sequence[Mask], options: TrialOptions
) -> tuple[list[Part], list[str]]:
    """Divide motions of the recorded joints by what acts on them; the second value describes impulses in free parts.

    `driven` are the grid points (m,) of each motion at which motors drive the joints.
    """
    parts: list[Part] = []
    instants: list[float] = []
    for i, motion in enumerate(motions):
        causes = np.full(len(motion.time), FREE)
        causes[at_rest(motion, options.rest_amplitude)] = REST
        if balance and len(motion.time) >= WINDOW:
            noise = _NOISE * balance.lumped.spread
            acting = torques(balance.windows[i], balance.lumped.values)
            hand, impulses = _lasting(acting > max(options.hand_torque, noise))
            # A hand that lets go gently, or catches so, pushes less at first: its traces next to it are its own.
            traces = acting > max(_TRACE * options.hand_torque, noise)
            hand = np.asarray(ndimage.binary_dilation(hand, iterations=_NEAR, mask=traces | hand))
            causes[_covered(hand, WINDOW)] = HAND
            instants += [float(motion.time[at + WINDOW // 2]) for at in impulses if causes[at + WINDOW // 2] == FREE]
        causes[ndimage.binary_closing(np.pad(driven[i], WINDOW), np.ones(WINDOW))[WINDOW:-WINDOW]] = MOTORS
        causes[cart_driven(motion, options.cart_limit)] = CART
        changes = [0, *(np.flatnonzero(np.diff(causes)) + 1).tolist()]
        edges = [*motion.time[changes].tolist(), float(motion.time[-1]) + motion.scales.spacing]
        parts += [Part(i, int(causes[at]), *edges[k : k + 2]) for k, at in enumerate(changes)]
    shown = ", ".join(f"{instant:.2f}" for instant in instants[:5]) + (" …" if len(instants) > 5 else "")
    note = (
        f"near {shown} s something other than gravity and friction acts for an instant (an impulse, lost counts, a "
        "bearing that sticks?): kept"
    )
    return parts, [note] if instants else []


def choose_parts(parts: Sequence[Part], shortest: float) -> tuple[list[Part], list[str]]:
    """Take the longest free motion: one part, or several with nothing between them but short gaps in the samples.

    The notes say what is cut and why. Raises NoFreeMotionError where none lasts `shortest` [s].
    """
    motions = _free_motions(parts, shortest)
    longest = max(motions, key=_lasts, default=[])
    if _lasts(longest) < shortest:
        found = f"the longest has {_lasts(longest):.2f} s" if longest else "there is none"
        causes = ", ".join(_describe(part) for part in parts if part.cause != FREE and part.duration > 0.05)
        raise NoFreeMotionError(
            f"no zero-input motion of at least {shortest:.3g} s: {found} ({causes or 'nothing else is there'})"
        )
    notes = [f"cut {_describe(part)}" for part in parts if part.cause != FREE]
    notes += [
        f"another zero-input part from {motion[0].start:.2f} to {motion[-1].stop:.2f} s is not used: another is longer"
        for motion in motions
        if motion is not longest and _lasts(motion) >= shortest
    ]
    return longest, notes


def _free_motions(parts: Sequence[Part], shortest: float) -> list[list[Part]]:
    """Put the free parts together between which only samples are missing, for less than a swing."""
    goes_on = [
        before.cause == part.cause == FREE and 0.0 <= part.start - before.stop < shortest
        for before, part in pairwise(parts)
    ]
    together = np.split(np.arange(len(parts)), np.flatnonzero(np.logical_not(goes_on)) + 1)
    return [[parts[place] for place in places] for places in together if parts[places[0]].cause == FREE]


def _lasts(motion: Sequence[Part]) -> float:
    return sum(part.duration for part in motion)


def _lasting(flags: Mask) -> tuple[Mask, list[int]]:
    """Separate lasting torques from impulses: returns the windows of the former, and the middle of each of the latter.

    What acts for an instant shows in every window around it, so an impulse is as long as a window and a little more. At
    the ends of a motion everything counts as lasting: there the two cannot be distinguished; and so does an impulse
    shortly before or after a lasting torque, with what is between: that is how a hand catches and lets go.
    """
    runs = [run for (run,) in ndimage.find_objects(ndimage.label(flags)[0])]
    lasts: Mask = np.zeros(len(flags), dtype=bool)
    for run in runs:
        lasts[run] = run.start == 0 or run.stop == len(flags) or run.stop - run.start > WINDOW + _INSTANT
    near = ndimage.binary_closing(np.pad(flags, _NEAR), np.ones(_NEAR))[_NEAR:-_NEAR]
    lasting = np.asarray(ndimage.binary_propagation(lasts, mask=near | flags))
    return lasting, [(run.start + run.stop) // 2 for run in runs if not lasting[run.start]]


def _covered(flags: Mask, width: int) -> Mask:
    """Return which points lie in a flagged window, of windows of `width` points that start at each flag."""
    return np.asarray(np.convolve(flags, np.ones(width), mode="full") > 0.5)


def covering(points: Mask, width: int) -> Mask:
    """Return which windows of `width` points hold a flagged point."""
    return np.asarray(np.convolve(points, np.ones(width), mode="valid") > 0.5)


def _describe(part: Part) -> str:
    return f"{part.start:.2f} to {part.stop:.2f} s ({_CAUSES[part.cause]})"

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From samples as recorded to the zero-input motion in them, checked against the physics."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain, groupby, pairwise, product

import numpy as np
from scipy import ndimage

from cdp_ident.arrays import Array, Mask
from cdp_ident.bag.device_messages import ClockRate
from cdp_ident.errors import NoFreeMotionError, OtherMotionError, TrialError
from cdp_ident.model.effects.effect import JOINTS, Joint
from cdp_ident.trial.balance import WINDOW, Motion, Windows, energy, largest_gravity, over_windows, torques, windows
from cdp_ident.trial.conventions import check_conventions, smaller_units_found
from cdp_ident.trial.joints import Samples, model_angles
from cdp_ident.trial.lumped import DRIVEN_JOINTS, FREE_JOINTS, explained
from cdp_ident.trial.meaning import GOOD, MUCH_BETTER, SOME, Balance, balance_of, in_model_angles
from cdp_ident.trial.mechanisms import driven
from cdp_ident.trial.options import Input, TrialOptions
from cdp_ident.trial.order import elapsed
from cdp_ident.trial.outliers import outlier_words
from cdp_ident.trial.recorded_motion import Recorded, at_rest, cart_driven, covered, moving_windows, recorded_motion
from cdp_ident.trial.scales import PER_UNIT, too_slow
from cdp_ident.trial.trial import Trial, joined

_MOSTLY = 0.5
"""What drives more than this share of a motion that is nowhere free for long is its input; what gives rods more than
this share of their energy is no effect of the rig: springs, bases and errors of readings gave up to a third."""
_DRIVES = 0.75
"""Torques drive a motion where at most this share of the squares is left with them that is left without: of geared
motors it is up to 0.6, as joints have dry friction, and of torques that are measured in a free swing nearly all."""
_INSTANT = PER_UNIT // 2
"""A torque that acts for no longer than this [grid points] counts as an impulse, not as a hand."""
_NEAR = 5 * PER_UNIT // 2
"""An impulse or a small torque so near [grid points] a hand is the hand's."""
_TRACE = 0.3
"""Torque next to a hand that is the hand's too, as a share of what tells of one: without it the example bags begin 30
ms earlier, and a torque is missing in them."""
_NOISE = 14.0
"""A torque must exceed the median of the windows fitted to by this factor, which is about eight times their noise."""

FREE, REST, CART, HAND = "", "the rods are still", "the cart is driven", "a hand is at the rods"
GAP = "samples are missing, and a hand may be at the rods"
MOTORS = "motors drive the joints, by their torque or effort"


@dataclass(frozen=True)
class Part:
    """A stretch of one motion to which one cause, or none, applies."""

    motion: int
    """Index of the motion."""
    cause: str
    """FREE, REST, CART, HAND or MOTORS."""
    start: float
    """Time of its beginning [s]."""
    stop: float
    """Time of its end [s]."""

    @property
    def duration(self) -> float:
        """Its length [s]."""
        return self.stop - self.start

    def __str__(self) -> str:
        """Return when it was, and its cause."""
        return f"{self.start:.2f} to {self.stop:.2f} s ({self.cause})"


@dataclass(frozen=True)
class Found:
    """A trial, and the balance of forces in the whole recording that it was found in."""

    trial: Trial
    warnings: tuple[str, ...]
    """What of its notes casts doubt on what the angles are taken to mean."""
    balance: Balance | None
    """Under the options' meaning of the angles; None where there is too little motion for one."""


def find_trial(samples: Samples, options: TrialOptions) -> Found:
    """Find the longest motion without input, or with a known one, and check what the options say about the angles.

    Raises TrialError where the data contradict the conventions, there is no motion long enough, or a hand led the rods
    up and they swing too shortly to tell it from free motion. What is found in samples too far apart is no cause: first
    of all, that is said.
    """
    try:
        return _found_of(samples, options)
    except TrialError as error:
        if slow := too_slow(elapsed(samples.stamps)):
            raise type(error)(f"{slow}; {error}") from error
        raise


def _found_of(samples: Samples, options: TrialOptions) -> Found:
    """Find the trial in samples that are taken to be close enough together."""
    other_units = smaller_units_found(samples, options)
    if other_units and options.conventions == "refuse":
        raise TrialError(f"{other_units}; {options.insist}")
    recorded = recorded_motion(samples, options)
    if other_units:
        recorded = replace(recorded, notes=(*recorded.notes, other_units))
    by_motors, turned = _by_motors(recorded, options)
    if options.input != "auto":
        return _found(recorded, by_motors, turned, options)
    try:
        return _found(recorded, by_motors, turned, replace(options, input="none"))
    except NoFreeMotionError:
        if (driver := _driver(recorded.motions, by_motors, options)) == "none":
            raise
        return _found(recorded, by_motors, turned, replace(options, input=driver))


def _found(recorded: Recorded, by_motors: Sequence[Mask], turned: Sequence[Joint], options: TrialOptions) -> Found:
    """Find a motion with a given input.

    `by_motors` are the grid points (m,) of each motion at which motors drive the joints, and `turned` the joints whose
    motors' torques count against their angles.
    """
    motions, moving, said = recorded.motions, recorded.moving, []
    if options.input == "joints":
        if any(motion.torques is None for motion in motions):
            raise TrialError("input is joints, but neither joint has an effort of a motor, or all are 0")
        if turned:
            raise TrialError(
                f"the efforts of the {' and '.join(turned)} joint count against its angle: positive ones turn it "
                "backwards; record them with the other sign, or set input: none to take free motion alone"
            )
        by_motors = [np.zeros_like(mask) for mask in by_motors]
        said = ["motors drive the joints: their efforts are known torques [N m]"]
    if options.input == "cart":
        options = replace(options, cart_limit=np.finfo(float).max)
        moving = moving_windows(motions, options)
        said = ["the cart is driven: its measured acceleration is a known input"]
    free = [over_windows(flags, np.ones(WINDOW)) < 0.5 for flags in by_motors]
    moving = tuple(mask & is_free for mask, is_free in zip(moving, free, strict=True))
    balance, warnings = check_conventions(replace(recorded, moving=moving), options)
    parts, impulses = find_parts(motions, balance, by_motors, options)
    taken, cuts = choose_parts(parts, options.shortest or motions[0].scales.shortest)
    if balance is None and options.conventions == "refuse":
        lasts = sum(part.duration for part in taken)
        raise TrialError(
            f"{warnings[0]}: {lasts:.2f} s of {parts[-1].stop:.2f} s; record a longer swing, or take the part without "
            f"the hand by {options.called('start')} and {options.called('stop')}; {options.insist}"
        )
    if balance and options.input != "joints" and (gain := _gain(motions, balance, taken)):
        if options.conventions == "refuse":
            raise OtherMotionError(f"{gain}; {options.insist}")
        warnings = [*warnings, gain]
    trial = joined([_stretch(recorded, part, options) for part in taken])
    left_out = [outlier_words(trial.outliers, len(trial.time))] if trial.outliers else []
    notes = (*recorded.notes, *said, *left_out, *warnings, *cuts, *impulses)
    return Found(replace(trial, notes=notes), tuple(warnings), balance)


def _gain(motions: Sequence[Motion], balance: Balance, parts: Sequence[Part]) -> str:
    """Say that rods gain energy in free parts, which no effect gives them; empty where it is less than half of all.

    Nothing speaks against what holds up to noise.
    """
    for part in parts if balance.lumped.beyond > SOME else ():
        motion = in_model_angles(motions[part.motion], balance.meaning)
        inside = (motion.time >= part.start) & (motion.time <= part.stop)
        time, total = motion.time[inside], energy(motion, balance.lumped.values)[inside]
        gained = total - np.minimum.accumulate(total)
        end = int(np.argmax(gained))
        if gained[end] > _MOSTLY * np.abs(total).max():
            begin, share = time[np.argmin(total[: end + 1])], gained[end] / total[end]
            where = driven(balance) or "in either joint or both"
            called = " and ".join(map(balance.meaning.called, ("start", "stop")))
            return (
                f"the motion is not free: from {begin:.2f} to {time[end]:.2f} s the rods gain {share:.0%} of their "
                f"energy, as by motors or a hand: {where}; record the motors' torques, or take a part without them by "
                f"{called}"
            )
    return ""


def _by_motors(recorded: Recorded, options: TrialOptions) -> tuple[list[Mask], list[Joint]]:
    """Return near which grid points (m,) of each motion motors drive the joints, and whose torques are reversed.

    Nowhere, unless torques, as measured or commanded, in any unit, explain most of what gravity, coupling and friction
    leave: what a motor measures in a joint that swings freely does not. It drives from `options.hand_torque` on.
    """
    nowhere: list[Mask] = [np.zeros(len(motion.time), dtype=bool) for motion in recorded.motions]
    measured = [motion.torques for motion in recorded.motions if motion.torques is not None]
    balance = balance_of(recorded, replace(options, input="none")) if measured else None
    if balance is None:
        return nowhere, []
    (_, without), (values, left) = (explained(balance.trusted, columns) for columns in (FREE_JOINTS, DRIVEN_JOINTS))
    if without <= GOOD**2 or left > _DRIVES * without:
        return nowhere, []
    shares = [np.abs(torque * values[-2:]) / largest_gravity(values) for torque in measured]
    where = [np.asarray(np.any(share > options.hand_torque, axis=1)) for share in shares]
    return where, _reversed(balance.trusted, np.array([options.inner_sign, options.outer_sign]))


def _reversed(balance: Windows, signs: Array) -> list[Joint]:
    """Return the joints whose torques count against their angles, by far the best of what the motion may mean.

    Both joints' torques have the same gain, 1 / A22. One alone would be whatever a joint's friction looks like whose
    motor does little. `signs` (2,) are those of the angles over those of the torques as they are taken.
    """

    def left(meant: Array) -> float:
        together = balance.terms.copy()
        together[..., -2] = together[..., -2:] @ meant
        values, left = explained(replace(balance, terms=together), DRIVEN_JOINTS[:-1])
        return left if values[-2] > 0.0 else np.inf

    flips = [np.array(flip) for flip in product((1, -1), repeat=2)]
    best = min(flips, key=lambda flip: left(flip * signs))
    is_clear = left(best * signs) < MUCH_BETTER**2 * left(signs)
    return [joint for joint, flip in zip(JOINTS, best, strict=True) if is_clear and flip < 0]


def _driver(motions: Sequence[Motion], by_motors: Sequence[Mask], options: TrialOptions) -> Input:
    """Return what drives most of the motion: the measured cart, motors in the joints, or nothing."""
    moves = ~np.concatenate([at_rest(motion, options.rest_amplitude) for motion in motions])
    by_cart = [cart_driven(motion, options.cart_limit) for motion in motions]
    drivers: dict[Input, Sequence[Mask]] = {"joints": by_motors, "cart": by_cart}
    lasts = {name: np.count_nonzero(np.concatenate(where)[moves]) for name, where in drivers.items()}
    most = max(lasts, key=lambda name: lasts[name])
    return most if lasts[most] > _MOSTLY * np.count_nonzero(moves) else "none"


def _stretch(recorded: Recorded, part: Part, options: TrialOptions) -> Trial:
    samples, time = recorded.pieces[part.motion].samples, recorded.pieces[part.motion].time
    torques = samples.torques if options.input == "joints" else None
    return Trial(
        name="",
        time=time,
        theta=model_angles(samples.angles, options),
        cart=None if samples.cart is None else options.cart_sign * samples.cart,
        torques=None if torques is None else torques * [options.inner_sign, options.outer_sign],
        clock=ClockRate(0.0, samples.pace_std) if samples.pace_std else None,
        outliers=recorded.outliers,
    ).part((time >= part.start) & (time <= part.stop))


def find_parts(
    motions: Sequence[Motion], balance: Balance | None, driven: Sequence[Mask], options: TrialOptions
) -> tuple[list[Part], list[str]]:
    """Divide motions of the recorded joints by what acts on them; the second value describes impulses in free parts.

    `driven` are the grid points (m,) of each motion at which motors drive the joints.
    """
    parts: list[Part] = []
    instants: list[float] = []
    for i, motion in enumerate(motions):
        causes = np.full(len(motion.time), FREE, dtype=object)
        causes[at_rest(motion, options.rest_amplitude)] = REST
        if balance and len(motion.time) >= WINDOW:
            noise = _NOISE * balance.lumped.spread
            parted = motion.parted(np.ones(len(motion.is_whole), dtype=bool))
            balanced = (windows(in_model_angles(part, balance.meaning)) for part, _ in parted)
            torque = np.concatenate([torques(of, balance.lumped.values) for of in balanced])
            acting = torque > max(options.hand_torque, noise)
            hand, impulses = _lasting(acting, motion.is_whole)
            # A hand that lets go gently, or catches so, pushes less at first: its traces next to it are its own.
            traces = motion.is_whole & (torque > max(_TRACE * options.hand_torque, noise))
            hand = np.asarray(ndimage.binary_dilation(hand, iterations=_NEAR, mask=traces | hand))
            causes[covered(acting & ~motion.is_whole, WINDOW)] = GAP
            causes[covered(hand, WINDOW)] = HAND
            instants += [float(motion.time[at + WINDOW // 2]) for at in impulses if causes[at + WINDOW // 2] == FREE]
        causes[ndimage.binary_closing(np.pad(driven[i], WINDOW), np.ones(WINDOW))[WINDOW:-WINDOW]] = MOTORS
        causes[cart_driven(motion, options.cart_limit)] = CART
        changes = [0, *(np.flatnonzero(causes[1:] != causes[:-1]) + 1).tolist()]
        edges = [*motion.time[changes].tolist(), float(motion.time[-1]) + motion.scales.spacing]
        parts += [Part(i, causes[at], *edges[k : k + 2]) for k, at in enumerate(changes)]
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
    lasts = [sum(part.duration for part in motion) for motion in motions]
    longest = max(lasts, default=0.0)
    if longest < shortest:
        found = f"the longest has {longest:.2f} s" if lasts else "there is none"
        causes = ", ".join(str(part) for part in parts if part.cause != FREE and part.duration > 0.05)
        raise NoFreeMotionError(
            f"no zero-input motion of at least {shortest:.3g} s: {found} ({causes or 'nothing else is there'})"
        )
    taken = motions[lasts.index(longest)]
    notes = [f"cut {part}" for part in parts if not any(of.start <= part.start < of.stop for of in chain(*motions))]
    notes += [
        f"another zero-input part from {motion[0].start:.2f} to {motion[-1].stop:.2f} s is not used: another is longer"
        for motion, duration in zip(motions, lasts, strict=True)
        if motion is not taken and duration >= shortest
    ]
    return taken, notes


def _free_motions(parts: Sequence[Part], shortest: float) -> list[list[Part]]:
    """Put the free parts together between which only samples are missing, for less than a swing.

    What may be free or not as samples are missing is free between free parts, and not before or after them.
    """
    goes_on = [
        {before.cause, part.cause} <= {FREE, GAP} and 0.0 <= part.start - before.stop < shortest
        for before, part in pairwise(parts)
    ]
    motions = []
    for places in np.split(np.arange(len(parts)), np.flatnonzero(np.logical_not(goes_on)) + 1):
        free = [place for place in places if parts[place].cause == FREE]
        between = parts[free[0] : free[-1] + 1] if free else []
        alike = (list(of) for _, of in groupby(between, lambda part: part.motion))
        motions.append([replace(of[0], cause=FREE, stop=of[-1].stop) for of in alike])
    return [motion for motion in motions if motion]


def _lasting(acting: Mask, is_whole: Mask) -> tuple[Mask, list[int]]:
    """Separate lasting torques from impulses: returns the windows of the former, and the middle of each of the latter.

    What acts for an instant shows in every window around it, so an impulse is as long as a window and a little more. At
    the ends of a motion everything counts as lasting: there the two cannot be distinguished; and so does an impulse
    shortly before or after a lasting torque, with what is between: that is how a hand catches and lets go. A window
    that is not whole tells a torque only where it goes on into, or from, one that is.
    """
    runs = [run for (run,) in ndimage.find_objects(ndimage.label(acting)[0]) if np.any(is_whole[run])]
    lasts: Mask = np.zeros(len(acting), dtype=bool)
    for run in runs:
        at_end = run.start == 0 or run.stop == len(acting)
        lasts[run] = at_end or np.ptp(np.flatnonzero(is_whole[run])) >= WINDOW + _INSTANT
    near = ndimage.binary_closing(np.pad(acting & is_whole, _NEAR), np.ones(_NEAR))[_NEAR:-_NEAR]
    lasting = np.asarray(ndimage.binary_propagation(lasts, mask=near | acting))
    return lasting, [(run.start + run.stop) // 2 for run in runs if not lasting[run.start]]

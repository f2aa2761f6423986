"""From samples as recorded to the zero-input motion in them, checked against the physics."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cdp_ident.arrays import Array, Mask
from cdp_ident.errors import NoFreeMotionError, TrialError
from cdp_ident.model.effects.effect import JOINTS
from cdp_ident.trial.cleaning import Piece
from cdp_ident.trial.conventions import check_conventions
from cdp_ident.trial.joints import Samples, model_angles
from cdp_ident.trial.meaning import Balance
from cdp_ident.trial.options import Input, TrialOptions
from cdp_ident.trial.other_motions import driven
from cdp_ident.trial.outliers import outlier_words
from cdp_ident.trial.recorded_motion import Recorded, recorded_motion
from cdp_ident.trial.scales import PER_UNIT
from cdp_ident.trial.trial import Trial, joined
from cdp_ident.trial.units import degrees_found
from cdp_ident.trial.weak_form import WINDOW, Motion
from cdp_ident.trial.wording import KEYS, Wording
from cdp_ident.trial.zero_input import Part, at_rest, cart_driven, choose_parts, covering, find_parts, moving_windows

_MOSTLY = 0.5
"""What drives more than this share of a motion that is nowhere free for long is its input."""
_HANGING = 0.1
"""Share of the largest angle from hanging up to which rods hang still that stay below it for half a unit of time."""


@dataclass(frozen=True)
class Found:
    """A trial, and the balance of forces in the whole recording that it was found in."""

    trial: Trial
    warnings: tuple[str, ...]
    """What of its notes casts doubt on what the angles are taken to mean."""
    balance: Balance | None
    """Under the options' meaning of the angles; None where there is too little motion for one."""


def find_trial(samples: Samples, options: TrialOptions, wording: Wording = KEYS) -> Found:
    """Find the longest motion without input, or with a known one, and check what the options say about the angles.

    Args:
        samples: as recorded.
        options: what they mean, and what of them is taken.
        wording: how the user writes options.

    Raises:
        TrialError: the data contradict the conventions, there is no motion long enough, or a hand led the rods up and
            they swing too shortly to tell it from free motion.
    """
    in_degrees = degrees_found(samples, options) if wording is KEYS else ""
    if in_degrees and options.conventions == "refuse":
        raise TrialError(f"{in_degrees}; {wording.insist}")
    recorded = recorded_motion(samples, options, wording)
    by_motors, gains = driven(*recorded[1:3], options)
    if options.input != "auto":
        return _found(recorded, by_motors, gains, options, wording, in_degrees)
    try:
        return _found(recorded, by_motors, gains, replace(options, input="none"), wording, in_degrees)
    except NoFreeMotionError:
        if (driver := _driver(recorded[1], by_motors, options)) == "none":
            raise
        return _found(recorded, by_motors, gains, replace(options, input=driver), wording, in_degrees)


def _found(
    recorded: Recorded,
    by_motors: Sequence[Mask],
    gains: Array,
    options: TrialOptions,
    wording: Wording,
    in_degrees: str,
) -> Found:
    """Find a motion with a given input.

    Args:
        recorded: see `recorded_motion`.
        by_motors: at which grid points (m,) of each motion motors drive the joints.
        gains: (2,) of their torques.
        options: what the angles mean, and the input.
        wording: how the user writes options.
        in_degrees: that readings are in degrees, in words, or nothing.
    """
    pieces, motions, moving, notes = recorded
    if options.input == "joints":
        if any(motion.torques is None for motion in motions):
            raise TrialError("input is joints, but neither joint has an effort of a motor, or all are 0")
        _refuse_reversed(gains, options)
        by_motors = [np.zeros(len(motion.time), dtype=bool) for motion in motions]
        notes = [*notes, "motors drive the joints: their efforts are known torques [N m]"]
    if options.input == "cart":
        options = replace(options, cart_limit=np.finfo(float).max)
        moving = tuple(moving_windows(motion, options) for motion in motions)
        notes = [*notes, "the cart is driven: its measured acceleration is a known input"]
    moving = tuple(
        mask & ~covering(flags, WINDOW) if len(mask) else mask for mask, flags in zip(moving, by_motors, strict=True)
    )
    balance, warnings = check_conventions(motions, moving, options, wording)
    warnings = [in_degrees, *warnings] if in_degrees else warnings
    parts, impulses = find_parts(motions, balance, by_motors, options)
    taken, cuts = choose_parts(parts, options.shortest or motions[0].scales.shortest)
    if balance is None and _begins_hanging(motions[taken[0].motion], options):
        raise TrialError(
            "the rods hang still at first, so something moved them, and then swing for too short a time to tell a hand "
            f"from free motion: record a longer swing, or take the part without the hand by {wording.name('start')} "
            f"and {wording.name('stop')}"
        )
    trial = joined([_stretch(pieces[part.motion], part, options) for part in taken])
    trial = trial if options.input == "joints" else replace(trial, torques=None)
    left_out = [outlier_words(trial.outliers, len(trial.time))] if trial.outliers else []
    return Found(replace(trial, notes=(*notes, *left_out, *warnings, *cuts, *impulses)), tuple(warnings), balance)


def _driver(motions: Sequence[Motion], by_motors: Sequence[Mask], options: TrialOptions) -> Input:
    """Return what drives most of the motion: the measured cart, motors in the joints, or nothing."""
    moves = ~np.concatenate([at_rest(motion, options.rest_amplitude) for motion in motions])
    by_cart = np.concatenate([cart_driven(motion, options.cart_limit) for motion in motions])
    shares: dict[Input, float] = {"joints": np.mean(np.concatenate(by_motors)[moves]), "cart": np.mean(by_cart[moves])}
    most = max(shares, key=lambda name: shares[name])
    return most if shares[most] > _MOSTLY else "none"


def _refuse_reversed(gains: Array, options: TrialOptions) -> None:
    """Raise TrialError where a motor's recorded torque acts the other way."""
    for joint, gain in zip(JOINTS, gains * [options.inner_sign, options.outer_sign], strict=True):
        if gain < 0.0:
            raise TrialError(
                f"the efforts of the {joint} joint count against its angle: positive ones turn it backwards; record "
                "them with the other sign, or set input: none to take free motion alone"
            )


def _begins_hanging(motion: Motion, options: TrialOptions) -> bool:
    """Return whether the rods hang still when a motion of the recorded joints begins."""
    away = np.abs(np.angle(-np.exp(1j * model_angles(motion.angles, options))))
    return bool(np.max(away[: PER_UNIT // 2]) < _HANGING * np.max(away))


def _stretch(piece: Piece, part: Part, options: TrialOptions) -> Trial:
    taken = piece[(piece.time >= part.start) & (piece.time <= part.stop)]
    first, last = taken.time[[0, -1]].tolist()
    return Trial(
        name="",
        time=taken.time - first,
        theta=model_angles(taken.angles, options),
        cart=None if taken.cart is None else options.cart_sign * taken.cart,
        start=first,
        torques=None if taken.torques is None else taken.torques * [options.inner_sign, options.outer_sign],
        outliers=tuple(at for at in taken.outliers if first <= at <= last),
    )

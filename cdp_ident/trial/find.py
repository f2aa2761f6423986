# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From samples as recorded to the zero-input motion in them, checked against the physics."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cdp_ident.arrays import Mask
from cdp_ident.errors import NoFreeMotionError, TrialError
from cdp_ident.model.effects.effect import Joint
from cdp_ident.trial.conventions import check_conventions
from cdp_ident.trial.gravity import smaller_units_found
from cdp_ident.trial.joints import Samples, model_angles
from cdp_ident.trial.meaning import Balance, Recorded
from cdp_ident.trial.options import Input, TrialOptions
from cdp_ident.trial.other_motions import driven
from cdp_ident.trial.outliers import outlier_words
from cdp_ident.trial.recorded_motion import recorded_motion
from cdp_ident.trial.trial import Trial, joined
from cdp_ident.trial.weak_form import WINDOW, Motion
from cdp_ident.trial.zero_input import Part, at_rest, cart_driven, choose_parts, covering, find_parts, moving_windows

_MOSTLY = 0.5
"""What drives more than this share of a motion that is nowhere free for long is its input."""


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

    Args:
        samples: as recorded.
        options: what they mean, and what of them is taken.

    Raises:
        TrialError: the data contradict the conventions, there is no motion long enough, or a hand led the rods up and
            they swing too shortly to tell it from free motion.
    """
    other_units = smaller_units_found(samples, options)
    if other_units and options.conventions == "refuse":
        raise TrialError(f"{other_units}; {options.insist}")
    recorded = recorded_motion(samples, options)
    if other_units:
        recorded = replace(recorded, notes=(*recorded.notes, other_units))
    by_motors, turned = driven(recorded, options)
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

    Args:
        recorded: the motion of the recorded joints.
        by_motors: at which grid points (m,) of each motion motors drive the joints.
        turned: joints whose motors' torques count against their angles.
        options: what the angles mean, and the input.
    """
    motions, moving, said = recorded.motions, recorded.moving, []
    if options.input == "joints":
        _refuse_unusable(motions, turned)
        by_motors = [np.zeros(len(motion.time), dtype=bool) for motion in motions]
        said = ["motors drive the joints: their efforts are known torques [N m]"]
    if options.input == "cart":
        options = replace(options, cart_limit=np.finfo(float).max)
        moving = tuple(moving_windows(motion, options) for motion in motions)
        said = ["the cart is driven: its measured acceleration is a known input"]
    moving = tuple(
        mask & ~covering(flags, WINDOW) if len(mask) else mask for mask, flags in zip(moving, by_motors, strict=True)
    )
    balance, warnings = check_conventions(replace(recorded, moving=moving), options)
    parts, impulses = find_parts(motions, balance, by_motors, options)
    taken, cuts = choose_parts(parts, options.shortest or motions[0].scales.shortest)
    if balance is None and options.conventions == "refuse":
        lasts = sum(part.duration for part in taken)
        raise TrialError(
            f"{warnings[0]}: {lasts:.2f} s of {parts[-1].stop:.2f} s; record a longer swing, or take the part without "
            f"the hand by {options.called('start')} and {options.called('stop')}; {options.insist}"
        )
    trial = joined([_stretch(recorded, part, options) for part in taken])
    left_out = [outlier_words(trial.outliers, len(trial.time))] if trial.outliers else []
    notes = (*recorded.notes, *said, *left_out, *warnings, *cuts, *impulses)
    return Found(replace(trial, notes=notes), tuple(warnings), balance)


def _driver(motions: Sequence[Motion], by_motors: Sequence[Mask], options: TrialOptions) -> Input:
    """Return what drives most of the motion: the measured cart, motors in the joints, or nothing."""
    moves = ~np.concatenate([at_rest(motion, options.rest_amplitude) for motion in motions])
    by_cart = [cart_driven(motion, options.cart_limit) for motion in motions]
    drivers: dict[Input, Sequence[Mask]] = {"joints": by_motors, "cart": by_cart}
    lasts = {name: np.count_nonzero(np.concatenate(where)[moves]) for name, where in drivers.items()}
    most = max(lasts, key=lambda name: lasts[name])
    return most if lasts[most] > _MOSTLY * np.count_nonzero(moves) else "none"


def _refuse_unusable(motions: Sequence[Motion], turned: Sequence[Joint]) -> None:
    """Raise TrialError where no motor's torque is recorded, or one acts the other way."""
    if any(motion.torques is None for motion in motions):
        raise TrialError("input is joints, but neither joint has an effort of a motor, or all are 0")
    if turned:
        raise TrialError(
            f"the efforts of the {' and '.join(turned)} joint count against its angle: positive ones turn it "
            "backwards; record them with the other sign, or set input: none to take free motion alone"
        )


def _stretch(recorded: Recorded, part: Part, options: TrialOptions) -> Trial:
    samples, time = recorded.pieces[part.motion].samples, recorded.pieces[part.motion].time
    torques = samples.torques if options.input == "joints" else None
    return Trial(
        name="",
        time=time,
        theta=model_angles(samples.angles, options),
        cart=None if samples.cart is None else options.cart_sign * samples.cart,
        torques=None if torques is None else torques * [options.inner_sign, options.outer_sign],
        outliers=recorded.outliers,
    ).part((time >= part.start) & (time <= part.stop))

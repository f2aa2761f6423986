"""From samples as recorded to the zero-input motion in them, checked against the physics."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cdp_ident.errors import TrialError
from cdp_ident.trial.balance import WINDOW, Motion
from cdp_ident.trial.cleaning import Piece
from cdp_ident.trial.conventions import check_conventions
from cdp_ident.trial.joints import Samples, model_angles
from cdp_ident.trial.meaning import Balance
from cdp_ident.trial.options import TrialOptions
from cdp_ident.trial.other_motions import driven
from cdp_ident.trial.outliers import outlier_words
from cdp_ident.trial.recorded_motion import recorded_motion
from cdp_ident.trial.scales import PER_UNIT
from cdp_ident.trial.trial import Trial, joined
from cdp_ident.trial.units import degrees_found
from cdp_ident.trial.wording import KEYS, Wording
from cdp_ident.trial.zero_input import Part, choose_parts, covering, find_parts

Mask = npt.NDArray[np.bool_]

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
    """Find the longest zero-input motion in samples of the joints, and check what the options say about the angles.

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
    pieces, motions, moving, notes = recorded_motion(samples, options, wording)
    by_motors = _driven(pieces, motions, moving, options)
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
    stretches = [_stretch(pieces[part.motion], part, options) for part in taken]
    trial = joined(stretches)
    left_out = [outlier_words(trial.outliers, len(trial.time))] if trial.outliers else []
    trial = replace(trial, notes=(*notes, *left_out, *warnings, *cuts, *impulses))
    return Found(trial, tuple(warnings), balance)


def _driven(
    pieces: Sequence[Piece], motions: tuple[Motion, ...], moving: tuple[Mask, ...], options: TrialOptions
) -> list[Mask]:
    """Return at which grid points of each motion motors drive the joints, by their torques."""
    torques = [
        np.column_stack([np.interp(motion.time, piece.time, of_joint) for of_joint in piece.torques.T])
        for piece, motion in zip(pieces, motions, strict=True)
        if piece.torques is not None
    ]
    return (
        driven(motions, moving, torques, options) if torques else [np.zeros(len(m.time), dtype=bool) for m in motions]
    )


def _begins_hanging(motion: Motion, options: TrialOptions) -> bool:
    """Return whether the rods hang still when a motion of the recorded joints begins."""
    away = np.abs(np.angle(-np.exp(1j * model_angles(motion.angles, options))))
    return bool(np.max(away[: PER_UNIT // 2]) < _HANGING * np.max(away))


def _stretch(piece: Piece, part: Part, options: TrialOptions) -> Trial:
    chosen = (piece.time >= part.start) & (piece.time <= part.stop)
    time = piece.time[chosen]
    return Trial(
        name="",
        time=time - time[0],
        theta=model_angles(piece.angles[chosen], options),
        cart=None if piece.cart is None else options.cart_sign * piece.cart[chosen],
        start=float(time[0]),
        outliers=tuple(at for at in piece.outliers.tolist() if time[0] <= at <= time[-1]),
    )

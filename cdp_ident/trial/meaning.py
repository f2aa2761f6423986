"""The balance of forces of recorded joints, under one meaning of their angles."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cdp_ident.arrays import Mask
from cdp_ident.trial.balance import Windows, joined, windows
from cdp_ident.trial.joints import model_angles
from cdp_ident.trial.lumped import Lumped, fit_lumped
from cdp_ident.trial.options import TrialOptions
from cdp_ident.trial.weak_form import Motion

GOOD = 0.02
"""Up to this unexplained share of the acceleration, there is no evidence against a meaning."""
EVIDENT = 0.1
"""Unexplained share up to which a meaning explains the motion, and wrong signs are evidence of a wrong zero."""
MUCH_BETTER = 0.5
"""Another meaning must leave less than this share of the residual to speak against the one given."""
_FEWEST_WINDOWS = 100
"""Windows that show motion, below which nothing can be said: five units of its time scale."""


@dataclass(frozen=True)
class Balance:
    """The balance of forces of some motions, under one meaning of their angles."""

    windows: tuple[Windows, ...]
    """Of each motion."""
    lumped: Lumped


def in_model_angles(motion: Motion, options: TrialOptions) -> Motion:
    """Return a motion of the recorded joints as one of theta1 and theta2, with torques if they are its input."""
    still = model_angles(np.zeros((1, 2)), options)
    of_inner, of_outer = motion.angle_noise / [options.inner_scale, options.outer_scale]
    return replace(
        motion,
        angles=model_angles(motion.angles, options),
        rates=model_angles(motion.rates, options) - still,
        cart=options.cart_sign * motion.cart,
        cart_velocity=options.cart_sign * motion.cart_velocity,
        angle_noise=np.array([of_inner, np.hypot(of_outer, of_inner * (options.outer_angle == "relative"))]),
        torques=motion.torques if options.input == "joints" else None,
    )


def balance_of(motions: Sequence[Motion], moving: Sequence[Mask], options: TrialOptions) -> Balance | None:
    """Return the balance of forces of motions of the recorded joints under a meaning; None with too little motion.

    `moving` are, of each motion, the windows (as many as `balance.windows` returns) that show one.
    """
    if sum(np.count_nonzero(mask) for mask in moving) < _FEWEST_WINDOWS:
        return None
    parts = [windows(in_model_angles(motion, options)) for motion in motions]
    return Balance(tuple(parts), fit_lumped(joined(parts), np.concatenate(moving)))

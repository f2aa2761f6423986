# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The balance of forces of recorded joints, under one meaning of their angles."""

import itertools
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import get_args

import numpy as np

from cdp_ident.arrays import Mask
from cdp_ident.trial.balance import Windows, joined, windows
from cdp_ident.trial.joints import Piece, model_angles
from cdp_ident.trial.lumped import Lumped, fit_lumped, gravity_directions
from cdp_ident.trial.options import OuterAngle, TrialOptions
from cdp_ident.trial.weak_form import Motion

GOOD = 0.02
"""Up to this unexplained share of the acceleration, there is no evidence against a meaning."""
EVIDENT = 0.1
"""Unexplained share up to which a meaning explains the motion, and wrong signs are evidence of a wrong zero."""
MUCH_BETTER = 0.5
"""Another meaning must leave less than this share of the residual to speak against the one given."""
_NO_OFFSET = 0.02
"""A zero that is off by less [rad] is left to be found with a deviation."""
_FEWEST_WINDOWS = 100
"""Windows that show motion, below which nothing can be said: five units of its time scale."""


@dataclass(frozen=True)
class Recorded:
    """The motion in a recording, before anything is known of what its angles mean."""

    pieces: tuple[Piece, ...]
    """Those that are long enough."""
    motions: tuple[Motion, ...]
    """Of each piece, of the recorded joints."""
    moving: tuple[Mask, ...]
    """Of each motion, the windows (as many as `balance.windows` returns) that show it well."""
    notes: tuple[str, ...] = ()
    """What was dropped and parted, in words."""
    outliers: tuple[float, ...] = ()
    """Times since the recording's first sample at which outliers were left out [s]."""


@dataclass(frozen=True)
class Balance:
    """The balance of forces in a recording, under one meaning of its angles."""

    meaning: TrialOptions
    windows: tuple[Windows, ...]
    """Of each motion."""
    trusted: Windows
    """Those of all motions that show it well."""
    lumped: Lumped


def in_model_angles(motion: Motion, options: TrialOptions) -> Motion:
    """Return a motion of the recorded joints as one of theta1 and theta2."""
    still = model_angles(np.zeros((1, 2)), options)
    of_inner, of_outer = motion.angle_noise / [options.inner_scale, options.outer_scale]
    return replace(
        motion,
        angles=model_angles(motion.angles, options),
        rates=model_angles(motion.rates, options) - still,
        cart=options.cart_sign * motion.cart,
        cart_velocity=options.cart_sign * motion.cart_velocity,
        angle_noise=np.array([of_inner, np.hypot(of_outer, of_inner * (options.outer_angle == "relative"))]),
    )


def balance_of(recorded: Recorded, meaning: TrialOptions) -> Balance | None:
    """Return the balance of forces under a meaning; None with too little motion."""
    if sum(map(np.count_nonzero, recorded.moving)) < _FEWEST_WINDOWS:
        return None
    parts = [windows(in_model_angles(motion, meaning)) for motion in recorded.motions]
    trusted = joined(parts)[np.concatenate(recorded.moving)]
    return Balance(meaning, tuple(parts), trusted, fit_lumped(trusted, meaning.input == "joints"))


def outer_meanings(recorded: Recorded, options: TrialOptions) -> list[Balance]:
    """Return the balances under the meanings that the outer angle can have; none with too little motion."""
    meanings = itertools.product(get_args(OuterAngle), (1, -1))
    tried = (balance_of(recorded, replace(options, outer_angle=angle, outer_sign=sign)) for angle, sign in meanings)
    return [balance for balance in tried if balance]


def with_other_zeros(recorded: Recorded, balances: Iterable[Balance]) -> Iterator[Balance]:
    """Yield the balances with the zeros of both angles where, under each meaning, gravity shows them to be."""
    for balance in balances:
        meaning = balance.meaning
        inner, outer = gravity_directions(balance.trusted).tolist()
        outer -= inner * (meaning.outer_angle == "relative")
        offsets = np.array([meaning.inner_offset + inner, meaning.outer_offset + outer])
        offsets = np.angle(np.exp(1j * offsets))
        inner, outer = np.where(np.abs(offsets) < _NO_OFFSET, 0.0, offsets).tolist()
        if other := balance_of(recorded, replace(meaning, inner_offset=inner, outer_offset=outer)):
            yield other


def exchanged(recorded: Recorded) -> Recorded:
    """Return a motion with each joint's readings as the other's."""
    of_joints = ("angles", "rates", "angle_noise", "torques")
    turned = [
        {name: of[..., ::-1] for name in of_joints if (of := getattr(motion, name)) is not None}
        for motion in recorded.motions
    ]
    motions = [replace(motion, **values) for motion, values in zip(recorded.motions, turned, strict=True)]
    return replace(recorded, motions=tuple(motions))


def best_of(balances: Iterable[Balance]) -> Balance | None:
    """Return that of them which leaves least, of those that may be a double pendulum's."""
    possible = (balance for balance in balances if balance.lumped.turned is not None)
    return min(possible, key=lambda balance: balance.lumped.unexplained, default=None)

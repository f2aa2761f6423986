# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The balance of forces of recorded joints, under one meaning of their angles or another.

Gravity's torque goes with the sine of an angle, and so shows where it is zero and how large it is. Where edges of an
encoder's signals are counted once or four times, or a gear is forgotten, forces balance with the readings over this
factor only.
"""

import itertools
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import get_args

import numpy as np
from scipy.optimize import minimize_scalar

from cdp_ident.trial.balance import Motion, Windows, joined, windows
from cdp_ident.trial.joints import model_angles
from cdp_ident.trial.lumped import Lumped, fit_lumped, gravity_directions
from cdp_ident.trial.options import OuterAngle, TrialOptions
from cdp_ident.trial.recorded_motion import Recorded, on_grid
from cdp_ident.trial.scales import Scales

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

_TOGETHER = (("inner",), ("outer",), ("inner", "outer"))
"""Joints whose readings have the same factor."""
_LIKELY = (0.5 / np.pi, 0.25, 0.5, 2.0, 4.0)
"""Factors of readings in turns, and by edges that are counted or not."""
_BETWEEN = 0.067
"""Distance of the others' logarithms that are tried first."""
_LOGARITHMS = np.sort([*np.arange(-24, 25) * _BETWEEN, *np.log(_LIKELY[1:])])
_NONE = 1e30
_NEAREST = 0.2
"""Least logarithm of a factor that no effect of the rig is like: one within a tenth is an effect itself, and drag or
friction that no balance knows may look like more."""
_ENOUGH = 1500
"""Windows: of more, only some are taken, for neighbours overlap."""
_EXPLAINED = 0.003
"""What leaves no more than this leaves next to nothing: a likely factor is taken only then."""
SOME = 0.05
"""Share of the windows, in which more is left than noise leaves, that is looked at."""
_CLEARLY = 0.05
"""Of two factors the likelier one has a misfit that is less by this."""
_WITHIN = 3e-4
"""Accuracy of the logarithm."""


@dataclass(frozen=True)
class Balance:
    """The balance of forces in a recording, under one meaning of its angles."""

    meaning: TrialOptions
    trusted: Windows
    """The windows of all motions that show it well."""
    lumped: Lumped

    @property
    def holds(self) -> bool:
        """Whether two rods move so, up to noise and next to nothing: what one pendulum does is no evidence then."""
        return self.lumped.may_be_rods and self.lumped.beyond <= SOME and self.lumped.unexplained <= _EXPLAINED


def in_model_angles(motion: Motion, options: TrialOptions) -> Motion:
    """Return a motion of the recorded joints as one of theta1 and theta2, with the cart at rest if it has no joint."""
    still = model_angles(np.zeros((1, 2)), options)
    cart_sign = options.cart_sign if options.cart_joint else 0
    of_inner, of_outer = motion.angle_noise / [options.inner_scale, options.outer_scale]
    return replace(
        motion,
        angles=model_angles(motion.angles, options),
        rates=model_angles(motion.rates, options) - still,
        cart=cart_sign * motion.cart,
        cart_velocity=cart_sign * motion.cart_velocity,
        angle_noise=np.array([of_inner, np.hypot(of_outer, of_inner * (options.outer_angle == "relative"))]),
    )


def balance_of(recorded: Recorded, meaning: TrialOptions) -> Balance | None:
    """Return the balance of forces under a meaning; None with too little motion."""
    if sum(map(np.count_nonzero, recorded.moving)) < _FEWEST_WINDOWS:
        return None
    trusted = joined([windows(in_model_angles(part, meaning))[moving] for part, moving in recorded.moving_parts])
    return Balance(meaning, trusted, fit_lumped(trusted, meaning.input == "joints"))


def outer_meanings(recorded: Recorded, options: TrialOptions) -> list[Balance]:
    """Return the balances under the meanings that the outer angle can have; none with too little motion."""
    meanings = itertools.product(get_args(OuterAngle), (1, -1))
    tried = (balance_of(recorded, replace(options, outer_angle=angle, outer_sign=sign)) for angle, sign in meanings)
    return [balance for balance in tried if balance]


def other_meanings(recorded: Recorded, options: TrialOptions, least: float, beyond: float) -> Iterator[Balance | None]:
    """Yield the balances with readings over a factor and, where much is left, with other zeros and joints exchanged.

    `least` is what is left without, `beyond` noise in such a share of the windows.
    """
    from_zero = options.zero == "upright" and options.scale_from == "hanging"
    yield _best_scale(recorded, options, least, beyond, from_zero=from_zero)
    if least > GOOD:
        moved = _with_other_zeros(recorded, outer_meanings(recorded, options))
        yield best_of(other for other in moved if other.lumped.is_certain)
        turned = replace(options, inner_joint=options.outer_joint, outer_joint=options.inner_joint)
        yield best_of(other for other in outer_meanings(_exchanged(recorded), turned) if other.lumped.may_be_rods)
    if least > GOOD and options.all_settable and any(np.any(motion.cart) for motion in recorded.motions):
        free = balance_of(recorded, replace(options, cart_joint=""))
        yield free if free and free.lumped.may_be_rods else None


def _with_other_zeros(recorded: Recorded, balances: Iterable[Balance]) -> Iterator[Balance]:
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


def _exchanged(recorded: Recorded) -> Recorded:
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


def explains_more(other: Balance, unexplained: float, beyond: float) -> bool:
    """Return whether it leaves far less than an unexplained share of the acceleration, or next to nothing in far more.

    `beyond` is the share of the windows in which the balance does not hold up to noise. A meaning that is wrong may
    hold in the others, as a wrong factor does where the rods swing little; that a hand acts is left by any.
    """
    in_more = beyond > SOME and other.lumped.beyond < MUCH_BETTER * beyond
    return other.lumped.unexplained < MUCH_BETTER * unexplained or (in_more and other.lumped.unexplained <= _EXPLAINED)


def _best_scale(
    recorded: Recorded, options: TrialOptions, least: float, beyond: float, *, from_zero: bool
) -> Balance | None:
    """Return the balance under the meaning of the angles with the factor with which forces balance best.

    A likely factor is taken where it explains more than what leaves `least`, `beyond` noise in such a share of the
    windows. None where no factor is possible, or the best one is so near to one that something else may act like it.
    Other factors are tried where that is much, or a little of one would explain more, and readings that are right at
    zero (`scale_from`) with `from_zero`.
    """
    apart = max(1, sum(map(np.count_nonzero, recorded.moving)) // _ENOUGH)
    some = replace(recorded, moving=tuple(mask & (np.arange(len(mask)) % apart == 0) for mask in recorded.moving))
    bases = [options, replace(options, scale_from="zero")] if from_zero else [options]
    choices = list(itertools.product(bases, _TOGETHER))

    def scaled(choice: int, logarithm: float) -> TrialOptions:
        base, joints = choices[choice]
        factor = float(np.exp(logarithm))
        return replace(base, **{f"{joint}_scale": factor * getattr(base, f"{joint}_scale") for joint in joints})

    def tried(choice: int, logarithm: float) -> Balance | None:
        return _possible(balance_of(some, scaled(choice, logarithm)))

    def misfit(choice: int, logarithm: float) -> float:
        other = tried(choice, logarithm)
        return other.lumped.misfit if other else np.inf

    def explains(other: Balance) -> bool:
        return explains_more(other, least, beyond) and other.lumped.unexplained <= _EXPLAINED

    likely = [tried(choice, logarithm) for choice in range(len(choices)) for logarithm in np.log(_LIKELY)]
    explaining = [other for other in likely if other and explains(other)]
    nearest = min(filter(None, likely), key=lambda other: other.lumped.misfit, default=None)
    if nearest and not explaining:
        # By readings so far off, the motion is faster or slower than it is.
        longest = max(recorded.pieces, key=lambda piece: len(piece.time))
        angles = model_angles(longest.samples.angles, nearest.meaning)
        slower = on_grid(recorded, Scales.of(longest.time, angles), options)
        again = _possible(balance_of(slower, nearest.meaning))
        if again and explains(again):
            return again
    if explaining:
        most = min(other.lumped.misfit for other in explaining) / MUCH_BETTER
        # A small swing cannot tell these apart, but what rods are like can.
        as_good = (other for other in explaining if other.lumped.misfit <= most)
        return _possible(balance_of(recorded, min(as_good, key=_unlike_rods).meaning))
    beside = [misfit(choice, at) for choice in range(len(choices)) for at in (-_BETWEEN, _BETWEEN)]
    if least <= GOOD and misfit(0, 0.0) < min(beside) + _CLEARLY:
        return None
    left = np.array([[misfit(choice, at) for at in _LOGARITHMS] for choice in range(len(choices))])
    choice, near = np.unravel_index(int(np.argmin(left)), left.shape)
    logarithm = minimize_scalar(
        lambda logarithm: min(misfit(int(choice), logarithm), _NONE),
        bounds=(_LOGARITHMS[near] - _BETWEEN, _LOGARITHMS[near] + _BETWEEN),
        method="bounded",
        options={"xatol": _WITHIN},
    ).x
    best = balance_of(recorded, scaled(int(choice), float(logarithm)))
    return _possible(best) if abs(logarithm) > _NEAREST else None


def _unlike_rods(balance: Balance) -> float:
    """Return how far the inner rod is from swinging as one of the joints' distance does with its mass at its end."""
    A, _, _, _, G1, G2, *_ = balance.lumped.values
    return abs(float(np.log(A * G1 / G2)))


def _possible(balance: Balance | None) -> Balance | None:
    """Return a balance that is certain to be a double pendulum's, with the other zero where that scales nothing."""
    turned = ("", "both") if balance and balance.meaning.scale_from == "zero" else ("",)
    return balance if balance and balance.lumped.has_certain_signs and balance.lumped.turned in turned else None

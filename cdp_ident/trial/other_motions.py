# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a motion is that is not a free double pendulum's: of a joint that is still, one pendulum, or driven joints.

The balance of forces (`balance`) tells. In one pendulum, whatever stands in the other column, nothing is coupled: the
equation of an outer rod holds with nothing but zeros. Where motors drive the joints, their torques explain what
gravity, coupling and friction leave.
"""

import itertools
from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from cdp_ident.arrays import Array, Mask
from cdp_ident.model.effects.effect import JOINTS, Joint
from cdp_ident.trial.balance import Windows, largest_gravity
from cdp_ident.trial.lumped import DRIVEN, FREE, Lumped, explained
from cdp_ident.trial.meaning import GOOD, MUCH_BETTER, Balance, Recorded, balance_of, in_model_angles
from cdp_ident.trial.options import TrialOptions
from cdp_ident.trial.weak_form import Motion

_STILL = 0.01
"""A joint whose speed varies by less than this share of the other's does not swing."""
_FASTEST = 50.0
"""Beyond this speed [rad/s], readings are of another unit, and tell nothing of the other joint."""
_FAR_OFTEN = 0.1
"""Share of steps by more than a quarter of a turn that no swing has which is measured often enough."""
_COUPLED = 0.02
"""Least coupling A23 / A22 of two rods: those that are known have 0.1 and more."""
_SIGMAS = 3.0
_WEIGHTLESS = 0.1
"""Gravity's terms times the square of the motion's time scale; of rods, one of them is about 1."""
_FOLLOWS = 0.95
"""Correlation of the joints' speeds from which one column is said to follow the other."""
_DRIVES = 0.75
"""Torques drive a motion where at most this share of the squares is left with them that is left without: of geared
motors it is up to 0.6, as joints have dry friction, and of torques that are measured in a free swing nearly all."""
_TWICE = 0.05
"""Share of the inner angle that the outer one differs from it by at most, as one measured and simulated does."""


def still_joint(recorded: Recorded, options: TrialOptions) -> str:
    """Return that a joint does not turn while the other does, in words; empty where both turn or none."""
    if not any(map(np.any, recorded.moving)):
        return ""

    def speed(rates: Sequence[Array]) -> Array:
        return np.std(np.concatenate([of_motion - of_motion.mean(axis=0) for of_motion in rates]), axis=0)

    inner, outer = speed([motion.rates for motion in recorded.motions])
    # The outer rod may turn with the inner one.
    _, apart = speed(
        [np.diff(in_model_angles(motion, options).rates, axis=1, prepend=0.0) for motion in recorded.motions]
    )
    still = _STILL * np.minimum([outer, inner], _FASTEST)
    joint = "inner" if inner < still[0] else "outer" if min(outer, apart) < still[1] else ""
    return joint and f"the {joint} joint does not turn while the other does: one pendulum, or a column that is no angle"


def too_far(recorded: Recorded, options: TrialOptions) -> str:
    """Return that readings cannot be of their unit, as a joint turns too far by them, in words; empty if none does."""
    scales = options.inner_scale, options.outer_scale
    steps = [np.abs(np.diff(piece.samples.angles, axis=0)) / scales for piece in recorded.pieces]
    far = np.mean(np.concatenate([np.zeros((1, 2)), *steps]) > np.pi / 2, axis=0)
    for joint in np.array(JOINTS)[far > _FAR_OFTEN].tolist():
        how = (
            f"{joint}_scale to what it reads in a radian, and scale_from: zero" if options.all_settable else "its unit"
        )
        return (
            f"the {joint} joint turns by more than a quarter of a turn from sample to sample: its readings are no "
            f"{getattr(options, f'{joint}_unit')} (counts of an encoder?): set {how}"
        )
    return ""


def uncoupled(motions: Sequence[Motion], balances: Collection[Balance]) -> str:
    """Return what two columns look like that are not coupled as rods are, whatever they mean; empty where they may be.

    `balances` are those under the meanings that the outer angle can have.
    """
    fits = [balance.lumped for balance in balances]
    couplings = [(fit.values[0], np.sqrt(fit.covariance[0, 0])) for fit in fits]
    apart = [f"coupling {A:+.3f} ± {std:.1g}" for A, std in couplings if abs(A) + _SIGMAS * std < _COUPLED]
    inner, outer = np.concatenate([motion.angles - motion.angles.mean(axis=0) for motion in motions]).T
    is_twice = np.std(outer - inner) < _TWICE * np.std(inner)
    if not (apart or is_twice) or any(map(may_be_rods, fits)):
        return ""
    correlation = float(np.corrcoef(np.concatenate([motion.rates for motion in motions]).T)[0, 1])
    looks = (
        f"the outer column follows the inner one (correlation {correlation:.2f}): one angle twice, measured and "
        "simulated or filtered"
        if is_twice or abs(correlation) > _FOLLOWS
        else "one pendulum beside something else, such as a cart's position, or a measured and a simulated angle, or "
        "joints that motors drive"
    )
    return f"the two columns have nothing to do with each other as rods do ({apart[0]}): {looks}" if apart else looks


def weightless(recorded: Recorded, given: Balance) -> str:
    """Return that gravity acts on neither rod, in words; empty where it may, as it does on all that swings so fast."""
    gravity = np.abs(given.lumped.values[4:6]) + _SIGMAS * np.sqrt(np.diag(given.lumped.covariance)[4:6])
    if float(np.max(gravity)) * recorded.motions[0].scales.unit ** 2 > _WEIGHTLESS:
        return ""
    return "gravity acts on neither rod: a column that is no angle, such as a cart's position, or of an upright axis"


def may_be_rods(fit: Lumped) -> bool:
    """Return whether the numbers are certain to be a double pendulum's, zeros half a turn off included."""
    is_coupled = fit.is_mechanism or abs(fit.values[0]) > _COUPLED
    return fit.turned is not None and fit.has_certain_signs and is_coupled


def driven(recorded: Recorded, options: TrialOptions) -> tuple[list[Mask], list[Joint]]:
    """Return near which grid points (m,) of each motion motors drive the joints, and whose torques are reversed.

    Args:
        recorded: the motion of the recorded joints, with the torques that were measured or commanded, in any unit.
        options: what the angles mean, and from which share of gravity's torque on one acts on the motion.

    Nowhere, unless these torques explain most of what gravity, coupling and friction leave: what a motor measures in a
    joint that swings freely does not.
    """
    nowhere: list[Mask] = [np.zeros(len(motion.time), dtype=bool) for motion in recorded.motions]
    torques = [motion.torques for motion in recorded.motions if motion.torques is not None]
    balance = balance_of(recorded, replace(options, input="none")) if torques else None
    if balance is None:
        return nowhere, []
    (_, without), (values, left) = (explained(balance.trusted, columns) for columns in (FREE, DRIVEN))
    if without <= GOOD**2 or left > _DRIVES * without:
        return nowhere, []
    shares = [np.abs(torque * values[-2:]) / largest_gravity(values) for torque in torques]
    where = [np.asarray(np.any(share > options.hand_torque, axis=1)) for share in shares]
    return where, _reversed(balance.trusted, np.array([options.inner_sign, options.outer_sign]))


def _reversed(windows: Windows, signs: Array) -> list[Joint]:
    """Return the joints whose torques count against their angles, by far the best of what the motion may mean.

    Both joints' torques have the same gain, 1 / A22. One alone would be whatever a joint's friction looks like whose
    motor does little.

    Args:
        windows: the balance of forces.
        signs: (2,) of the angles, over those of the torques as they are taken.
    """

    def left(meant: Array) -> float:
        together = windows.terms.copy()
        together[..., -2] = together[..., -2:] @ meant
        return explained(replace(windows, terms=together), DRIVEN[:-1])[1]

    flips = [np.array(flip) for flip in itertools.product((1, -1), repeat=2)]
    best = min(flips, key=lambda flip: left(flip * signs))
    is_clear = left(best * signs) < MUCH_BETTER**2 * left(signs)
    return [joint for joint, flip in zip(JOINTS, best, strict=True) if is_clear and flip < 0]

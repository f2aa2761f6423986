"""What a motion is that is not a free double pendulum's: of a joint that is still, one pendulum, or driven joints.

The balance of forces (`balance`) tells. In one pendulum, whatever stands in the other column, nothing is coupled: the
equation of an outer rod holds with nothing but zeros. Where motors drive the joints, their torques explain what
gravity, coupling and friction leave.
"""

import itertools
from collections.abc import Sequence
from dataclasses import replace
from typing import get_args

import numpy as np
import numpy.typing as npt

from cdp_ident.trial import weak_form
from cdp_ident.trial.balance import WINDOW, Motion, joined
from cdp_ident.trial.lumped import Lumped
from cdp_ident.trial.meaning import Balance, balance_of
from cdp_ident.trial.options import OuterAngle, TrialOptions

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

_STILL = 0.01
"""A joint whose speed varies by less than this share of the other's does not swing."""
_COUPLED = 0.02
"""Least coupling A23 / A22 of two rods: those that are known have 0.1 and more."""
_SIGMAS = 3.0
_FOLLOWS = 0.95
"""Correlation of the joints' speeds from which one column is said to follow the other."""
_EXPLAINED = 0.02
"""Up to this unexplained share of the acceleration, no motor had a part in the motion."""
_FAR_BETTER = 0.5
"""Torques of motors must leave at most this share of the squared residual."""
_LUMPED = 8
"""The lumped numbers that torques are fitted beside: all but the geared rotor and errors of zeros."""


def still_joint(motions: Sequence[Motion], moving: Sequence[Mask]) -> str:
    """Return that a recorded joint does not turn while the other does, in words; empty where both turn or none.

    `moving` are, of each motion, the windows that show one.
    """
    if not any(map(np.any, moving)):
        return ""
    inner, outer = _speeds(motions)
    joint = "inner" if inner < _STILL * outer else "outer" if outer < _STILL * inner else ""
    return joint and f"the {joint} joint does not turn while the other does: one pendulum, or a column that is no angle"


def uncoupled(motions: Sequence[Motion], moving: Sequence[Mask], options: TrialOptions) -> str:
    """Return what two columns look like that are not coupled as rods are, whatever they mean; empty where they may be.

    `moving` are, of each motion of the recorded joints, the windows that show one.
    """
    meanings = itertools.product(get_args(OuterAngle), (1, -1))
    others = [replace(options, outer_angle=angle, outer_sign=sign) for angle, sign in meanings]
    fits = [balance.lumped for other in others if (balance := balance_of(motions, moving, other))]
    apart = [fit for fit in fits if abs(fit.values[0]) + _SIGMAS * np.sqrt(fit.covariance[0, 0]) < _COUPLED]
    if not apart or any(map(may_be_rods, fits)):
        return ""
    coupling, std = apart[0].values[0], np.sqrt(apart[0].covariance[0, 0])
    correlation = float(np.corrcoef(np.concatenate([motion.rates for motion in motions]).T)[0, 1])
    looks = (
        f"the outer column follows the inner one (correlation {correlation:.2f}): one angle twice, measured and "
        "simulated or filtered"
        if abs(correlation) > _FOLLOWS
        else "one pendulum beside something else, such as a cart's position, or a measured and a simulated angle"
    )
    return (
        f"the two columns have nothing to do with each other as rods do (coupling {coupling:+.3f} ± {std:.1g}): {looks}"
    )


def _speeds(motions: Sequence[Motion]) -> Array:
    """Return how much the speeds of both recorded joints vary (2,) [rad/s]."""
    return np.std(np.concatenate([motion.rates - motion.rates.mean(axis=0) for motion in motions]), axis=0)


def may_be_rods(fit: Lumped) -> bool:
    """Return whether the numbers are certain to be a double pendulum's, zeros half a turn off included."""
    is_coupled = fit.is_mechanism or abs(fit.values[0]) > _COUPLED
    return fit.turned is not None and fit.has_certain_signs and is_coupled


def driven(
    motions: Sequence[Motion], moving: Sequence[Mask], torques: Sequence[Array], options: TrialOptions
) -> list[Mask]:
    """Return near which grid points (m,) of each motion motors drive the joints.

    Args:
        motions: of the recorded joints.
        moving: of each motion, the windows that show one.
        torques: of each motion, the torque that was measured or commanded in both joints (m, 2), in any unit.
        options: what the angles mean, and from which share of gravity's torque on one acts on the motion.

    Nowhere, unless these torques explain most of what gravity, coupling and friction leave: what a motor measures in a
    joint that swings freely does not.
    """
    nowhere: list[Mask] = [np.zeros(len(motion.time), dtype=bool) for motion in motions]
    balance = balance_of(motions, moving, options)
    if balance is None:
        return nowhere
    acting = [_integrated(motion, torque) for motion, torque in zip(motions, torques, strict=True)]
    left, values = _left(balance, moving, acting)
    if values is None or left > _FAR_BETTER:
        return nowhere
    gravity = np.maximum(np.abs(values[4:6]), 0.1 * np.abs(values[4:6]).max())
    shares = [np.abs(torque * values[_LUMPED:]) / gravity for torque in torques]
    return [np.asarray(np.any(share > options.hand_torque, axis=1)) for share in shares]


def _integrated(motion: Motion, torque: Array) -> Array:
    """Return what the torques of both joints (m, 2) do to both rods in each window, (k, 2, 2)."""
    inner, outer = weak_form.Windows.of(WINDOW // 2, motion.scales.spacing).values_of(torque.T)
    # A torque between the rods acts on both.
    return np.stack([np.column_stack([inner, -outer]), np.column_stack([np.zeros_like(inner), outer])], axis=1)


def _left(balance: Balance, moving: Sequence[Mask], acting: Sequence[Array]) -> tuple[float, Array | None]:
    """Return which share of the squared residual torques leave, and the lumped numbers with theirs behind them.

    No numbers where the balance holds without torques.
    """
    windows = joined(list(balance.windows))[np.concatenate(moving)]
    torques = np.concatenate(acting)[np.concatenate(moving)]
    rows = np.concatenate([windows.coefficients[..., :_LUMPED], torques], axis=2).reshape(-1, _LUMPED + 2)
    target = windows.target.ravel()
    squares = []
    for count in (_LUMPED, _LUMPED + 2):
        values = np.linalg.lstsq(rows[:, :count], target, rcond=None)[0]
        squares.append(float(np.sum((rows[:, :count] @ values - target) ** 2)))
    if squares[0] <= _EXPLAINED**2 * float(target @ target):
        return 1.0, None
    return squares[1] / squares[0], values

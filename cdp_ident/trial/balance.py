# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The balance of forces of the recorded motion, without any parameter known beforehand.

It holds, in weak form (`weak_form`), in every window in which nothing but gravity, the joints' friction and the cart's
measured acceleration acts. A joint that stands still is held by any friction. Where the balance does not hold with the
numbers of the other windows, a hand acted on the rods, or the angles have another meaning than assumed.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cdp_ident.arrays import Array, Rows
from cdp_ident.model.parameters import NOMINAL
from cdp_ident.trial import weak_form
from cdp_ident.trial.kinematics import local_motion, off_smooth
from cdp_ident.trial.scales import Scales, sampling_step
from cdp_ident.trial.weak_form import WINDOW, Motion, integrated, window_weights

COLUMNS = weak_form.COLUMNS[1:]
"""The lumped numbers in their order, relative to A22."""
_STICKS = 0.5
"""A joint sticks where the direction of its friction is uncertain by more than this share."""
_LEAST_GRAVITY = 0.1
"""A rod has gravity's torque at least as this share of the other's."""


@dataclass(frozen=True)
class Windows(Rows):
    """The balance of forces in windows of a motion."""

    terms: Array
    """(k, 2, 15) what A22, which is one, and the lumped numbers are multiplied by, in the order of `COLUMNS`."""
    slack: Array
    """(k, 2) uncertainty of the direction of each joint's dry friction where the joint is slow: 0 to 1."""
    noise: Array
    """(k, 2) variance of the noise of the accelerations of both rods [(rad/s^2)^2]."""

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.terms)


def joined(parts: Sequence[Windows]) -> Windows:
    """Return the windows of several motions as one."""
    return Windows(*(np.concatenate([getattr(part, name) for part in parts]) for name in Windows.__dataclass_fields__))


def motion_on_grid(
    time: Array, angles: Array, cart: Array | None, scales: Scales | None = None, torques: Array | None = None
) -> Motion:
    """Estimate angles and velocities on a grid from samples.

    Args:
        time: (n,) of the samples [s].
        angles: (n, 2) [rad].
        cart: (n,) its position [m].
        scales: of the grid; else those of this motion.
        torques: (n, 2) of motors in the joints.
    """
    scales = scales or Scales.of(time, angles)
    at = np.arange(time[0], time[-1], scales.spacing)
    cart = np.zeros(len(time)) if cart is None else cart
    values, slopes = local_motion(time, np.column_stack([angles, cart]), at, scales.half_width)
    known = None if torques is None else np.column_stack([np.interp(at, time, of) for of in torques.T])
    noise = 1.4826 * np.median(off_smooth(time, angles, scales.half_width), axis=0)
    return Motion(
        at, values[:, :2], slopes[:, :2], values[:, 2], slopes[:, 2], scales, noise, _gain(time, scales), known
    )


def windows(motion: Motion) -> Windows:
    """Return the balance of each window of WINDOW grid points that fits into a motion given in theta1 and theta2."""
    balance, slack = integrated(motion, NOMINAL["g"], weak_form.COLUMNS)
    return Windows(balance, slack, np.tile(motion.noise, (len(balance), 1)))


def residual(balance: Windows, values: Array) -> Array:
    """Return what the lumped numbers leave unexplained in each window (k, 2) [rad/s^2]."""
    return np.asarray(balance.terms @ [1.0, *values])


def torques(balance: Windows, values: Array) -> Array:
    """Return the torque that is unexplained in each window (k,), as a share of gravity's largest on the same rod.

    Friction in a slow joint does not count: up to the joint's dry friction or, where both rods turn as one, of any
    size, as no hand acts from one rod on the other. A rod whose gravity torque is less than a tenth of the other's is
    measured against that.
    """
    on_inner, on_outer = residual(balance, values).T
    gravity = largest_gravity(values)
    held1, held2 = (balance.slack * np.abs(values[6:8])).T
    held2 = np.where(balance.slack[:, 1] > _STICKS, np.maximum(held2, gravity[1]), held2)
    by_outer_joint = np.clip(-on_outer, -held2, held2)
    on_outer, on_inner = on_outer + by_outer_joint, on_inner - by_outer_joint
    on_inner = on_inner + np.clip(-on_inner, -held1, held1)
    return np.asarray(np.maximum(np.abs(on_inner) / gravity[0], np.abs(on_outer) / gravity[1]))


def largest_gravity(values: Array) -> Array:
    """Return gravity's largest torque on each rod (2,), for a rod that hardly has any a tenth of the other's."""
    gravity = np.abs(values[4:6])
    return np.asarray(np.maximum(gravity, max(_LEAST_GRAVITY * gravity.max(), 1e-12)))


def _gain(time: Array, scales: Scales) -> float:
    """Return the variance of a window's acceleration where the angles have white noise of variance one [1/s^4]."""
    step = sampling_step(time)
    at = np.asarray(np.linspace(-0.5, 0.5, WINDOW) * (WINDOW - 1) * scales.spacing, dtype=float)
    beside = max(6, round((at[-1] + scales.half_width) / step) + 1)
    times = np.arange(-beside, beside + 1) * step
    _, slopes = local_motion(times, np.eye(len(times)), at, scales.half_width)
    _, slope = window_weights(scales.spacing)
    return float(np.sum((slope @ slopes) ** 2))

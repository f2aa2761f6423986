# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The balance of forces in weak form: linear in lumped numbers, without accelerations or anything known beforehand.

The equations of motion of both rods are rates of change of momenta p and torques q, each linear in lumped numbers over
A22: those of the paper's model, G1 = a1 g and G2 = m2 l2 g for gravity, the joints' dry friction k1, k2, motors'
torques times M1 and M2, and the constant coupling D of a rotor geared to the outer joint. With s, c the sine and cosine
of theta1 - theta2, w1, w2 the angular velocities, d1, d2 the directions in which the joints turn, and u the cart's
acceleration::

    w1' + A23 [(c w2)' + s w1 w2] + D w2' + c1 w1 + c2 (w1 - w2) + k1 d1 - k2 d2 = G1 (sin theta1 - cos theta1 u / g)
    A23 [(c w1)' - s w1 w2] + D w1' + A33 w2' + c2 (w2 - w1) + k2 d2             = G2 (sin theta2 - cos theta2 u / g)

Multiplied with a test function that vanishes at the ends of a short window and integrated by parts, p' becomes minus
the integral of the function's slope times p: no derivative of the data beyond the angular velocities is taken
(Messenger and Bortz, J. Comput. Phys. 443, 2021; modulating functions: Shinbrot, Trans. ASME 79, 1957). The measured
speed v of a cart enters as cos(theta) u = (cos(theta) v)' + sin(theta) w v. Errors e1, e2 of the angles' zeros add, to
first order, the derivatives of the terms with A23, G1 and G2 by the angles, times E12 = A23 (e1 - e2), E1 = G1 e1 and
E2 = G2 e2.

A joint that stands still is held by any friction. Where the balance does not hold with the numbers of the other
windows, a hand acted on the rods, or the angles have another meaning than assumed.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from scipy.special import erf

from cdp_ident.arrays import Array, Mask, Rows
from cdp_ident.model.parameters import NOMINAL
from cdp_ident.trial.kinematics import FEWEST, MEDIAN_OF_SIZE, local_motion, off_smooth
from cdp_ident.trial.scales import Scales

COLUMNS = ("A22", "A23", "A33", "c1", "c2", "G1", "G2", "k1", "k2", "D", "E12", "E1", "E2", "M1", "M2")
"""What the balance is linear in; A22 itself is one, and M1, M2 what motors' torques are multiplied by."""
WINDOW = 25
"""Grid points of a window: 1.2 units of the motion's time scale from its first to its last."""
_AT_ONCE = 1 << 14
"""Windows of which all is computed at once: more take more memory and no less time."""
_SOME, _MOST = 8, 100
"""Windows that show what noise does to them, and samples of each that are looked at."""
_ANY = 0.5
_STICKS = 0.5
"""A joint sticks where the direction of its friction is uncertain by more than this share."""
_LEAST_GRAVITY = 0.1
"""A rod has gravity's torque at least as this share of the other's."""


@dataclass(frozen=True)
class Motion:
    """The motion of one piece of a recording on a grid of times."""

    time: Array
    """(m,) times of the grid [s], spaced by `scales.spacing`."""
    angles: Array
    """(m, 2) theta1, theta2, or the positions of the inner and outer joint that they are made of [rad]."""
    rates: Array
    """(m, 2) their velocities [rad/s]."""
    cart: Array
    """(m,) position of the cart [m]."""
    cart_velocity: Array
    """(m,) velocity of the cart [m/s]."""
    scales: Scales
    angle_noise: Array
    """(2,) standard deviation of the angles' noise [rad]."""
    gain: float
    """Variance that it gives to the acceleration over a window, over its own [1/s^4]."""
    bridged: Mask
    """(m,) whether a point lies in a gap between samples that its neighbourhood cannot tell the motion in."""
    torques: Array | None = None
    """(m, 2) torques of motors in the joints [N m]; None where there are none, or they are no known input."""

    @property
    def is_whole(self) -> Mask:
        """(windows,) Whether a window has no gap in it."""
        return np.asarray(over_windows(self.bridged, np.ones(WINDOW)) < _ANY)

    def parted(self, windows: Mask) -> Iterator[tuple["Motion", Mask]]:
        """Yield parts that follow one another, and of each those of some windows that it has: all take little memory.

        `windows` tells of each of the motion's windows whether it is one of them.
        """
        rows = [field.name for field in fields(self) if np.shape(getattr(self, field.name))[:1] == self.time.shape]
        for begin in range(0, len(windows), _AT_ONCE):
            part = slice(begin, begin + _AT_ONCE + WINDOW - 1)
            values = {name: getattr(self, name)[part] for name in rows}
            yield replace(self, **values), windows[begin : begin + _AT_ONCE]

    @property
    def directions(self) -> Array:
        """(m, 2) directions in which joints slip, from -1 to 1; uncertain where dry friction may hold a joint.

        They are the means of the sign of speeds that are known to `scales.slow`, a standard deviation.
        """
        return np.asarray(erf(np.diff(self.rates, axis=1, prepend=0.0) / (math.sqrt(2.0) * self.scales.slow)))


def motion_on_grid(
    time: Array, angles: Array, cart: Array | None, scales: Scales | None = None, torques: Array | None = None
) -> Motion:
    """Estimate angles and velocities on a grid, of given scales or those of this motion, from samples.

    `time` and `cart` are (n,) [s, m], `angles` and `torques` of motors (n, 2) [rad, N m].
    """
    scales = scales or Scales.of(time, angles)
    at = np.arange(time[0], time[-1], scales.spacing)
    cart = np.zeros(len(time)) if cart is None else cart
    values, slopes = local_motion(time, np.column_stack([angles, cart]), at, scales.half_width)
    known = None if torques is None else np.column_stack([np.interp(at, time, of) for of in torques.T])
    noise = np.median(off_smooth(time, angles, scales.half_width), axis=0) / MEDIAN_OF_SIZE
    gaps = np.diff(time)[np.clip(np.searchsorted(time, at, side="right") - 1, 0, len(time) - 2)]
    gain, bridged = _gain(time, scales), gaps > scales.half_width
    return Motion(at, values[:, :2], slopes[:, :2], values[:, 2], slopes[:, 2], scales, noise, gain, bridged, known)


def _gain(time: Array, scales: Scales) -> float:
    """Return the variance of a window's acceleration where the angles have white noise of variance one [1/s^4].

    It is the median of some windows: samples that are missing here and there leave more than even ones as far apart.
    """
    at = (np.arange(WINDOW) - WINDOW // 2) * scales.spacing
    reach = at[-1] + scales.half_width
    _, slope = window_weights(scales.spacing)
    gains = []
    for centre in np.linspace(time[0] + reach, time[-1] - reach, _SOME):
        first, last = np.searchsorted(time, [centre - reach, centre + reach])
        times = time[max(0, first - FEWEST) : last + FEWEST]
        every = 1 + len(times) // _MOST
        _, slopes = local_motion(times[::every], np.eye(len(times[::every])), centre + at, scales.half_width)
        gains.append(float(np.sum((slope @ slopes) ** 2)) / every)
    return float(np.median(gains))


def window_weights(spacing: float, half: int = WINDOW // 2) -> tuple[Array, Array]:
    """Return the weights (2 half + 1,) that integrate a value, and those that integrate a derivative by parts [1/s].

    The test function is (1 - x^2)^3, which integrates to one, on a grid of a spacing [s].
    """
    x = np.linspace(-1.0, 1.0, 2 * half + 1)
    bump = (1.0 - x**2) ** 3
    slope = 6.0 * x * (1.0 - x**2) ** 2 / (half * spacing)
    return bump / bump.sum(), slope / bump.sum()


def over_windows(series: Array | Mask, weights: Array, stride: int = 1) -> Array:
    """Return the integral of a series (m,) with some weights over windows (windows,) a stride of grid points apart."""
    if len(series) < len(weights):
        return np.zeros(0)
    return np.asarray(np.correlate(np.asarray(series, dtype=float), weights, "valid")[::stride])


@dataclass(frozen=True)
class Windows(Rows):
    """The balance of forces in windows of a motion."""

    terms: Array
    """(k, 2, 15) what the lumped numbers are multiplied by in both equations, in the order of `COLUMNS`."""
    slack: Array
    """(k, 2) uncertainty of the direction of each joint's dry friction where the joint is slow: 0 to 1."""
    noise: Array
    """(k, 2) variance that the angles' noise gives to the accelerations of both rods [(rad/s^2)^2]."""

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.terms)


def windows(motion: Motion, gravity: float = NOMINAL["g"], stride: int = 1) -> Windows:
    """Return the balance in each window that fits into a motion of theta1 and theta2, a stride of grid points apart.

    Without a cart that moves, gravity g [m/s^2] does not matter.
    """
    value, slope = window_weights(motion.scales.spacing)
    slack = [over_windows(of_joint, value, stride) for of_joint in (1.0 - np.abs(motion.directions)).T]
    terms = np.zeros((len(slack[0]), 2, len(COLUMNS)))
    for name, rods in _terms(motion, gravity).items():
        for rod, (momentum, torque) in enumerate(rods):
            if momentum is not None:
                terms[:, rod, COLUMNS.index(name)] += over_windows(momentum, slope, stride)
            if torque is not None:
                terms[:, rod, COLUMNS.index(name)] += over_windows(torque, value, stride)
    noise = np.tile(motion.gain * motion.angle_noise**2, (len(terms), 1))
    return Windows(terms, np.column_stack(slack), noise)


_Term = tuple[Array | None, Array | None]
"""Momentum and torque (m,) of a rod over a lumped number."""


def _terms(motion: Motion, gravity: float) -> Mapping[str, tuple[_Term, _Term]]:
    """Return momentum and torque of the inner rod and of the outer one over each lumped number that has any."""
    (theta1, theta2), (w1, w2), (d1, d2) = motion.angles.T, motion.rates.T, motion.directions.T
    s, c, cart = np.sin(theta1 - theta2), np.cos(theta1 - theta2), motion.cart_velocity
    none = None, None

    def gravity_of(theta: Array, w: Array) -> _Term:
        falls = -np.sin(theta)
        if not np.any(cart):
            return None, falls
        return np.cos(theta) * cart / gravity, falls + np.sin(theta) * w * cart / gravity

    def outer_joint(torque: Array) -> tuple[_Term, _Term]:
        # A torque between the rods acts on both.
        return (None, -torque), (None, torque)

    terms: dict[str, tuple[_Term, _Term]] = {
        "A22": ((w1, None), none),
        "A23": ((c * w2, s * w1 * w2), (c * w1, -s * w1 * w2)),
        "A33": (none, (w2, None)),
        "D": ((w2, None), (w1, None)),
        "G1": (gravity_of(theta1, w1), none),
        "G2": (none, gravity_of(theta2, w2)),
        "c1": ((None, w1), none),
        "c2": outer_joint(w2 - w1),
        "k1": ((None, d1), none),
        "k2": outer_joint(d2),
        "E12": ((-s * w2, c * w1 * w2), (-s * w1, -c * w1 * w2)),
        "E1": ((None, -np.cos(theta1)), none),
        "E2": (none, (None, -np.cos(theta2))),
    }
    if motion.torques is not None:
        terms["M1"] = (None, -motion.torques[:, 0]), none
        terms["M2"] = outer_joint(-motion.torques[:, 1])
    return terms


def joined(parts: Sequence[Windows]) -> Windows:
    """Return the windows of several motions as one."""
    return Windows(*(np.concatenate([getattr(part, name) for part in parts]) for name in Windows.__dataclass_fields__))


def residual(balance: Windows, values: Array) -> Array:
    """Return what the lumped numbers (14,), relative to A22, leave unexplained in each window (k, 2) [rad/s^2]."""
    rows = balance.terms.reshape(-1, len(COLUMNS))
    return np.asarray(rows @ np.array([1.0, *values])).reshape(-1, 2)


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


def energy(motion: Motion, values: Array, gravity: float = NOMINAL["g"]) -> Array:
    """Return the energy (m,) of a motion of theta1 and theta2 above that of hanging rods, over A22 [1/s^2].

    It is without what a measured cart has done to the rods.
    """
    (theta1, theta2), (w1, w2) = motion.angles.T, motion.rates.T
    A, B, _, _, G1, G2, _, _, D, *_ = values
    kinetic = (w1**2 + B * w2**2) / 2.0 + (A * np.cos(theta1 - theta2) + D) * w1 * w2
    pushed = np.gradient(motion.cart_velocity) * (G1 * np.cos(theta1) * w1 + G2 * np.cos(theta2) * w2) / gravity
    potential = G1 * np.cos(theta1) + G2 * np.cos(theta2) + abs(G1) + abs(G2)
    return np.asarray(kinetic + potential + np.cumsum(pushed))

"""The balance of forces in weak form: linear in base parameters and most effects, without accelerations.

The equations of motion, over A22, are rates of change of momenta p and torques q, each linear in what is sought:
sum_j beta_j (p_j' + q_j) = -p_0'. Multiplied with a test function phi that vanishes at the ends of a short window and
integrated by parts, p' becomes minus the integral of phi' p: no derivative of the data beyond the angular velocities is
taken (Messenger and Bortz, J. Comput. Phys. 443, 2021; modulating functions: Shinbrot, Trans. ASME 79, 1957).

Of the two rods' equations, their sum and the outer rod's are used. The torque of the outer joint acts on one rod and,
reversed, on the other, so the sum is free of it, and holds while that joint sticks; the outer rod's holds while the
inner joint does. With s, c of theta1 - theta2 and no cart::

    (w1 + A23 c (w1 + w2) + A33 w2)' + c1 w1           = g (a1 sin theta1 + m2 l2 sin theta2)
    (A23 c w1 + A33 w2)' - A23 s w1 w2 + c2 (w2 - w1)  = g m2 l2 sin theta2

The measured speed v of a cart enters as cos(theta) u = (cos(theta) v)' + sin(theta) w v.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.special import erf

from cdp_ident.fit import rest
from cdp_ident.fit.smoothing import SmoothMotion

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

STEPS_BETWEEN = 4
"""Test functions in a half width: neighbouring ones begin a quarter of it apart."""
_REST_NOISE = 5.0
"""Smoothed noise, in standard deviations, that a joint's range must exceed or it counts as at rest."""
_REST_SHARE = 3e-3
"""The same as a share of the joint's range while it moves fast: elastic motion of a joint that sticks."""
_SLOWEST_SHARE = 1e-3
"""Speed, as a share of the joint's speed while it moves fast, below which the direction of slip is uncertain."""

_MEDIAN_OF_SIZE = 0.6745
"""Median size of a standard normal number."""


@dataclass(frozen=True)
class Kinematics:
    """Angles and speeds, as measured first and then as if measured again; each array is (1 + copies, m)."""

    theta1: Array
    theta2: Array
    w1: Array
    w2: Array
    v: Array
    """Speed of the cart [m/s]."""

    @classmethod
    def of(cls, motion: SmoothMotion) -> "Kinematics":
        """Take theta1, theta2 and, where there is one, the cart from a smooth motion."""
        theta1, theta2 = motion.values[..., 0], motion.values[..., 1]
        v = motion.rates[..., 2] if motion.rates.shape[-1] > 2 else np.zeros_like(theta1)
        return cls(theta1, theta2, motion.rates[..., 0], motion.rates[..., 1], v)

    @property
    def joint_angles(self) -> tuple[Array, Array]:
        """Angle of the inner and of the outer joint [rad]."""
        return self.theta1, self.theta2 - self.theta1

    @property
    def joint_speeds(self) -> tuple[Array, Array]:
        """Their speeds [rad/s]."""
        return self.w1, self.w2 - self.w1


@dataclass(frozen=True)
class Term:
    """What one unknown is multiplied by: momenta and torques in the sum of both rods' equations and the outer rod's."""

    momentum: tuple[Array | float, Array | float] = (0.0, 0.0)
    torque: tuple[Array | float, Array | float] = (0.0, 0.0)

    def plus(self, other: "Term", factor: float) -> "Term":
        """Return this term and so many times another together."""
        (p1, p2), (q1, q2) = self.momentum, self.torque
        (r1, r2), (s1, s2) = other.momentum, other.torque
        return Term((p1 + factor * r1, p2 + factor * r2), (q1 + factor * s1, q2 + factor * s2))


def weighted_sum(terms: Sequence[Term], factors: Array) -> Term:
    """Return terms, each times its factor, together."""
    total = Term()
    for term, factor in zip(terms, factors, strict=True):
        total = total.plus(term, float(factor))
    return total


def inertia_of_inner_rod(k: Kinematics) -> Term:
    """A22 itself, whose factor is one."""
    return Term(momentum=(k.w1, 0.0))


def coupling(k: Kinematics) -> Term:
    """A23, without the moment of the outer rod that comes with it."""
    s, c = np.sin(k.theta1 - k.theta2), np.cos(k.theta1 - k.theta2)
    return Term((c * (k.w1 + k.w2), c * k.w1), (0.0, -s * k.w1 * k.w2))


def inertia_of_outer_rod(k: Kinematics) -> Term:
    """A33."""
    return Term(momentum=(k.w2, k.w2))


def moment_of_inner_rod(k: Kinematics, gravity: float) -> Term:
    """a1, which gravity [m/s^2] and the cart act on."""
    momentum, torque = _moment(k.theta1, k.w1, k.v, gravity)
    return Term((momentum, 0.0), (torque, 0.0))


def moment_of_outer_rod(k: Kinematics, gravity: float) -> Term:
    """m2 l2."""
    momentum, torque = _moment(k.theta2, k.w2, k.v, gravity)
    return Term((momentum, momentum), (torque, torque))


def _moment(theta: Array, w: Array, v: Array, gravity: float) -> tuple[Array, Array]:
    return np.cos(theta) * v, np.sin(theta) * (w * v - gravity)


def joint_torques(inner: Array | float, outer: Array | float) -> Term:
    """Torques by which friction in the joints holds them back."""
    return Term(torque=(inner, outer))


def rod_torques(on_theta1: Array, on_theta2: Array) -> Term:
    """Generalised torques on theta1 and theta2 that drive them."""
    return Term(torque=(-(on_theta1 + on_theta2), -on_theta2))


def constant_coupling(k: Kinematics) -> Term:
    """A constant beside A23 cos(theta1 - theta2), as geared rotors and belts add (Spong, J. Dyn. Sys. 109, 1987)."""
    return Term(momentum=(k.w1 + k.w2, k.w1))


def slip_direction(k: Kinematics, joint: int) -> Array:
    """Return the direction in which a joint slips (1 + copies, m), from -1 to 1: near 0 where speed is within noise.

    It is the mean of the sign of a speed of which the noise is known.
    """
    speed = k.joint_speeds[joint]
    lively = _while_moving(np.abs(speed[0]))
    noise = _spread(speed)
    width = max(noise, _SLOWEST_SHARE * lively)
    return np.asarray(erf(speed / (np.sqrt(2.0) * width))) if width > 0 else np.zeros_like(speed)


def at_rest(k: Kinematics, joint: int, points: int, step: float = 0.0) -> Mask:
    """Return where (m,) a joint, whose encoder has a step [rad], hardly moves over so many grid points."""
    angle = k.joint_angles[joint]
    ranges = rest.range_over(angle[0], points)
    limit = max(_REST_NOISE * _spread(angle), _REST_SHARE * _while_moving(ranges), rest.AT_REST * step)
    return rest.at_rest(ranges, points, limit)


def _while_moving(sizes: Array) -> float:
    """Return the mean of sizes, each weighted by itself: how large they are in motion, however long the rest is."""
    total = float(np.sum(sizes))
    return float(np.sum(sizes**2)) / total if total > 0.0 else 0.0


def _spread(values: Array) -> float:
    """Return the robust standard deviation of what was measured again (1 + copies, m) about what was measured."""
    return float(np.median(np.abs(values[1:] - values[0]))) / _MEDIAN_OF_SIZE if len(values) > 1 else 0.0


@dataclass(frozen=True)
class Windows:
    """Test functions of one width, all over a motion."""

    value: Array
    """(2 half + 1,) weights that integrate a value against the test function, which integrates to one."""
    slope: Array
    """(2 half + 1,) weights that integrate a derivative against it, by parts [1/s]."""
    stride: int
    """Grid points between the centres of neighbouring windows."""

    @classmethod
    def of(cls, half_width: float, spacing: float) -> "Windows":
        """Lay out windows of a half width [s] on a grid of a spacing [s]."""
        half = max(STEPS_BETWEEN, round(half_width / spacing))
        x = np.linspace(-1.0, 1.0, 2 * half + 1)
        bump = (1.0 - x**2) ** 3
        slope = 6.0 * x * (1.0 - x**2) ** 2 / (half * spacing)
        return cls(bump / bump.sum(), slope / bump.sum(), half // STEPS_BETWEEN)

    def integrate(self, terms: Sequence[Term], shape: tuple[int, int]) -> Array:
        """Return terms (copies, windows, 2, terms) integrated over each window of a motion (copies, m)."""
        integrated = np.zeros((shape[0], self.count(shape[1]), 2, len(terms)))
        for weights, parts in (
            (self.slope, [term.momentum for term in terms]),
            (self.value, [term.torque for term in terms]),
        ):
            # Both equations have many a part in common.
            places: dict[int, list[tuple[int, int]]] = {}
            series = dict[int, Array]()
            for place, both in enumerate(parts):
                for equation, values in enumerate(both):
                    if isinstance(values, np.ndarray):
                        series[id(values)] = values
                        places.setdefault(id(values), []).append((equation, place))
            if not series:
                continue
            of_series = self._apply(np.stack([np.broadcast_to(values, shape) for values in series.values()]), weights)
            for of_one, wanted in zip(of_series, places.values(), strict=True):
                for equation, place in wanted:
                    integrated[:, :, equation, place] += of_one
        return integrated

    def _apply(self, values: Array, weights: Array) -> Array:
        """Return weighted sums (…, windows) of values (…, m) over each window."""
        # What a window has in common with its neighbours is gone through once: stretches from centre to centre.
        stretches, count = -(-len(weights) // self.stride), self.count(values.shape[-1])
        if not count:
            return np.zeros((*values.shape[:-1], 0))
        by_stretch = np.zeros((stretches, self.stride))
        by_stretch.ravel()[: len(weights)] = weights
        points = (count - 1 + stretches) * self.stride
        cut = np.zeros((*values.shape[:-1], points))
        kept = min(points, values.shape[-1])
        cut[..., :kept] = values[..., :kept]
        sums = cut.reshape(*values.shape[:-1], -1, self.stride) @ by_stretch.T
        return np.asarray(sum(sums[..., k : k + count, k] for k in range(stretches)))

    def count(self, points: int) -> int:
        """Return how many windows there are on so many grid points."""
        return max(0, -(-(points - len(self.value) + 1) // self.stride))

    def within(self, flags: Mask) -> Mask:
        """Return which windows have every grid point flagged."""
        view = np.lib.stride_tricks.sliding_window_view(flags, len(self.value))
        return np.asarray(view[:: self.stride].all(axis=-1))


@dataclass(frozen=True)
class Rows:
    """The balance in each window: columns @ unknowns = target."""

    columns: Array
    """(1 + copies, windows, 2, unknowns)."""
    target: Array
    """(1 + copies, windows, 2) [rad/s^2]."""
    holds: Mask
    """(windows, 2) where the sum's and where the outer rod's equation hold."""

    def noise(self, values: Array) -> Array:
        """Return the standard deviation (2,) of what noise alone leaves in either balance [rad/s^2].

        It is zero without copies.
        """
        if len(self.columns) == 1:
            return np.zeros(2)
        left = self.columns @ values - self.target
        change = left[1:] - left[0]
        return np.array([np.std(change[:, self.holds[:, k], k]) if self.holds[:, k].any() else 0.0 for k in range(2)])


def rows(windows: Windows, known: Mask, terms: Sequence[Term], fixed: Term, resting: tuple[Mask, Mask]) -> Rows:
    """Integrate terms over windows.

    Args:
        windows: where.
        known: (m,) where the motion is known.
        terms: one for each unknown.
        fixed: the one whose factor is one.
        resting: where (m,) the inner and the outer joint rest; static friction has any size there.
    """
    copies, points = next(np.shape(part) for part in (*fixed.momentum, *fixed.torque) if np.ndim(part))
    shape = (copies, points)
    integrated = windows.integrate([*terms, fixed], shape)
    columns, target = integrated[..., :-1], -integrated[..., -1]
    holds = np.stack([windows.within(known & ~still) for still in resting], axis=-1)
    return Rows(columns, target, holds)


def joined(parts: Sequence[Rows], unknowns: int) -> Rows:
    """Return the rows of several motions in one."""
    if not parts:
        return Rows(np.zeros((1, 0, 2, unknowns)), np.zeros((1, 0, 2)), np.zeros((0, 2), dtype=bool))
    copies = min(len(part.target) for part in parts)
    return Rows(
        np.concatenate([part.columns[:copies] for part in parts], axis=1),
        np.concatenate([part.target[:copies] for part in parts], axis=1),
        np.concatenate([part.holds for part in parts]),
    )

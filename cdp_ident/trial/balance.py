"""The balance of forces of the recorded motion, without any parameter known beforehand.

The equations of motion of a zero-input double pendulum are linear in lumped numbers (all relative to A22): A = A23,
B = A33, c1, c2, the gravity terms G1 = a1 g, G2 = m2 l2 g, the joints' dry friction k1, k2, and the constant coupling D
of a geared rotor that turns with the outer joint. Multiplied with a test function that vanishes at the ends of a short
window and integrated by parts they need no accelerations (the weak form: Messenger and Bortz, J. Comput. Phys. 443,
2021). With s, c the sine and cosine of theta1 - theta2, w1, w2 the angular velocities, and d1, d2 the directions in
which the joints turn, the signs of w1 and w2 - w1,

    w1' + A [(c w2)' + s w1 w2] + D w2' + c1 w1 + c2 (w1 - w2) + k1 d1 - k2 d2 = G1 (sin theta1 - cos theta1 u / g)
    A [(c w1)' - s w1 w2] + D w1' + B w2' + c2 (w2 - w1) + k2 d2               = G2 (sin theta2 - cos theta2 u / g)

holds in every window in which nothing but gravity, the joints' friction and the cart's measured acceleration u acts.
Errors e1, e2 of the angles' zeros add, to first order, the derivatives of the terms with A, G1 and G2 by the angles,
times E12 = A (e1 - e2), E1 = G1 e1 and E2 = G2 e2. A joint that stands still is held by any friction. Where the balance
does not hold with the numbers of the other windows, a hand acted on the rods, or the angles have another meaning than
assumed.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.model.parameters import NOMINAL
from cdp_ident.trial.kinematics import local_motion
from cdp_ident.trial.scales import Scales, sampling_step

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

WINDOW = 25
"""Grid points of a window: 1.2 units of the motion's time scale from its first to its last."""
COLUMNS = ("A", "B", "c1", "c2", "G1", "G2", "k1", "k2", "D", "E12", "E1", "E2")
"""The lumped numbers in their order."""
_STICKS = 0.5
"""A joint sticks where the direction of its friction is uncertain by more than this share."""
_NOISE_SAMPLES = 2000
_CUBIC_AT_CENTRE = 2.25
"""A cubic fitted to N samples follows the noise of the one in the middle by this over N."""


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
    noise: Array
    """(2,) variance that it gives to the acceleration over a window [(rad/s^2)^2]."""


@dataclass(frozen=True)
class Windows:
    """The balance of forces in windows of a motion."""

    coefficients: Array
    """(k, 2, 12) of the lumped numbers, in the order of `COLUMNS`."""
    target: Array
    """(k, 2) right-hand side [rad/s^2]."""
    slack: Array
    """(k, 2) uncertainty of the direction of each joint's dry friction where the joint is slow: 0 to 1."""
    noise: Array
    """(k, 2) variance of the noise of the accelerations of both rods [(rad/s^2)^2]."""

    def __getitem__(self, chosen: Mask | npt.NDArray[np.int64]) -> "Windows":
        """Return some of the windows."""
        return Windows(self.coefficients[chosen], self.target[chosen], self.slack[chosen], self.noise[chosen])

    def __len__(self) -> int:
        """Return how many there are."""
        return len(self.target)


def joined(parts: list[Windows]) -> Windows:
    """Return the windows of several motions as one."""
    return Windows(*(np.concatenate([getattr(part, name) for part in parts]) for name in Windows.__dataclass_fields__))


def motion_on_grid(time: Array, angles: Array, cart: Array | None, scales: Scales | None = None) -> Motion:
    """Estimate angles and velocities on a grid from samples: time (n,) [s], angles (n, 2) [rad], cart (n,) [m].

    Without `scales` they are those of this motion.
    """
    scales = scales or Scales.of(time, angles)
    at = np.arange(time[0], time[-1], scales.spacing)
    cart = np.zeros(len(time)) if cart is None else cart
    values, slopes = local_motion(time, np.column_stack([angles, cart]), at, scales.half_width)
    noise = _noise(time, angles, scales)
    of_acceleration = noise**2 * _gain(time, scales)
    return Motion(at, values[:, :2], slopes[:, :2], values[:, 2], slopes[:, 2], scales, noise, of_acceleration)


def windows(motion: Motion) -> Windows:
    """Return the balance of each window of WINDOW grid points that fits into a motion given in theta1 and theta2."""
    theta1, theta2 = motion.angles.T
    w1, w2 = motion.rates.T
    v, g = motion.cart_velocity, NOMINAL["g"]
    s, c = np.sin(theta1 - theta2), np.cos(theta1 - theta2)
    direction1, direction2 = np.tanh(w1 / motion.scales.slow), np.tanh((w2 - w1) / motion.scales.slow)
    value, slope = _test_function(motion.scales.spacing)

    def integral(values: Array) -> Array:
        return np.asarray(np.convolve(values, value, mode="valid"), dtype=float)

    def derivative(values: Array) -> Array:
        """Integrate the time derivative of values against the test function, by parts."""
        return np.asarray(np.convolve(values, slope, mode="valid"), dtype=float)

    def gravity(theta: Array, w: Array) -> Array:
        falls = -integral(np.sin(theta))
        # cos(theta) u = (cos(theta) v)' + sin(theta) w v
        return falls + (derivative(np.cos(theta) * v) + integral(np.sin(theta) * w * v)) / g if np.any(v) else falls

    count = max(0, len(motion.time) - WINDOW + 1)
    coefficients, target, slack = np.zeros((count, 2, len(COLUMNS))), np.zeros((count, 2)), np.empty((count, 2))
    noise = np.tile(motion.noise, (count, 1))
    if not count:
        return Windows(coefficients, target, slack, noise)
    of_w1, of_w2, friction = derivative(w1), derivative(w2), integral(direction2)
    coupled, turned, between = integral(s * w1 * w2), integral(c * w1 * w2), integral(w1 - w2)
    inner, outer = np.moveaxis(coefficients, 0, -1)
    A, B, c1, c2, G1, G2, k1, k2, D, E12, E1, E2 = range(len(COLUMNS))
    inner[A], outer[A] = derivative(c * w2) + coupled, derivative(c * w1) - coupled
    outer[B] = of_w2
    inner[c1] = integral(w1)
    inner[c2], outer[c2] = between, -between
    inner[G1], outer[G2] = gravity(theta1, w1), gravity(theta2, w2)
    inner[k1] = integral(direction1)
    inner[k2], outer[k2] = -friction, friction
    inner[D], outer[D] = of_w2, of_w1
    inner[E12], outer[E12] = turned - derivative(s * w2), -turned - derivative(s * w1)
    inner[E1], outer[E2] = -integral(np.cos(theta1)), -integral(np.cos(theta2))
    target[:, 0] = -of_w1
    slack[:, 0], slack[:, 1] = (integral(1 - np.abs(direction)) for direction in (direction1, direction2))
    return Windows(coefficients, target, slack, noise)


def residual(balance: Windows, values: Array) -> Array:
    """Return what the lumped numbers leave unexplained in each window (k, 2) [rad/s^2]."""
    return np.asarray((balance.coefficients.reshape(-1, len(COLUMNS)) @ values).reshape(-1, 2) - balance.target)


def torques(balance: Windows, values: Array, smallest_gravity: float = 0.1) -> Array:
    """Return the torque that is unexplained in each window (k,), as a share of gravity's largest on the same rod.

    Friction in a slow joint does not count: up to the joint's dry friction or, where both rods turn as one, of any
    size, as no hand acts from one rod on the other. A rod whose gravity torque is less than `smallest_gravity` times
    the other's is measured against that.
    """
    on_inner, on_outer = residual(balance, values).T
    gravity = np.abs(values[4:6])
    gravity = np.maximum(gravity, max(smallest_gravity * gravity.max(), 1e-12))
    held1, held2 = (balance.slack * np.abs(values[6:8])).T
    held2 = np.where(balance.slack[:, 1] > _STICKS, np.maximum(held2, gravity[1]), held2)
    by_outer_joint = np.clip(-on_outer, -held2, held2)
    on_outer, on_inner = on_outer + by_outer_joint, on_inner - by_outer_joint
    on_inner = on_inner + np.clip(-on_inner, -held1, held1)
    return np.asarray(np.maximum(np.abs(on_inner) / gravity[0], np.abs(on_outer) / gravity[1]))


def _test_function(spacing: float) -> tuple[Array, Array]:
    """Return weights that integrate a value, and its derivative by parts, against (1 - x^2)^3 scaled to one."""
    x = np.linspace(-1, 1, WINDOW)
    bump = (1 - x**2) ** 3
    slope = -6 * x * (1 - x**2) ** 2 / (spacing * (WINDOW - 1) / 2)
    # By parts, a derivative is minus the value against the slope; np.convolve reverses the odd slope: minus once more.
    return bump / bump.sum(), slope / bump.sum()


def _noise(time: Array, angles: Array, scales: Scales) -> Array:
    """Return the standard deviation of each angle about smooth motion (k,) [rad], by its median."""
    every = max(1, len(time) // _NOISE_SAMPLES)
    values, _ = local_motion(time, angles, time[::every], scales.half_width)
    together = max(6.0, 2 * scales.half_width / sampling_step(time))
    median = np.median(np.abs(angles[::every] - values), axis=0)
    return np.asarray(1.4826 * median / np.sqrt(1 - _CUBIC_AT_CENTRE / together))


def _gain(time: Array, scales: Scales) -> float:
    """Return the variance of a window's acceleration where the angles have white noise of variance one [1/s^4]."""
    step = sampling_step(time)
    at = np.asarray(np.linspace(-0.5, 0.5, WINDOW) * (WINDOW - 1) * scales.spacing, dtype=float)
    beside = max(6, round((at[-1] + scales.half_width) / step) + 1)
    times = np.arange(-beside, beside + 1) * step
    _, slopes = local_motion(times, np.eye(len(times)), at, scales.half_width)
    return float(np.sum((_test_function(scales.spacing)[1] @ slopes) ** 2))

"""The balance of forces of the recorded motion, without any parameter known beforehand.

The equations of motion of a zero-input double pendulum are linear in six lumped numbers (all relative to A22):
A = A23, B = A33, c1, c2 and the gravity terms G1 = a1 g, G2 = m2 l2 g. Multiplied with a test function that vanishes at
the ends of a short window and integrated by parts they need no accelerations (the weak form: Messenger and Bortz,
J. Comput. Phys. 443, 2021). With s, c the sine and cosine of theta1 - theta2, and w1, w2 the angular velocities,

    w1' + A [(c w2)' + s w1 w2] + c1 w1 + c2 (w1 - w2) = G1 (sin theta1 - cos theta1 u / g)
    A [(c w1)' - s w1 w2] + B w2' + c2 (w2 - w1)       = G2 (sin theta2 - cos theta2 u / g)

holds in every window in which nothing but gravity, the joints' friction and the cart's measured acceleration u acts.
Where it does not hold with the numbers of the other windows, a hand was at work, or the angles do not mean what they
are taken to mean.
"""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cdp_ident.model.parameters import NOMINAL
from cdp_ident.trial.kinematics import local_motion

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

SPACING = 0.01
"""Time between the centres of neighbouring windows [s]."""
WINDOW = 25
"""Grid points of a window: 0.24 s from its first to its last."""

_TRIMMED_ROUNDS = 12
_STRETCH = 100
"""Windows of a stretch that the fit may begin with: 1 s of motion."""
_MOST_STRETCHES = 24
_AGREEMENT = 0.05
"""Unexplained torque, as a share of gravity's, with which a window agrees with a fit."""
_SMALLEST_GRAVITY = 0.1
"""A rod whose gravity torque is less than this share of the other's is measured against that share."""


@dataclass(frozen=True)
class Motion:
    """The motion of one piece of a recording on a grid of times."""

    time: Array
    """(m,) times of the grid [s], spaced by SPACING."""
    angles: Array
    """(m, 2) theta1, theta2, or the positions of the inner and outer joint that they are made of [rad]."""
    rates: Array
    """(m, 2) their velocities [rad/s]."""
    cart: Array
    """(m,) position of the cart [m]."""
    cart_velocity: Array
    """(m,) velocity of the cart [m/s]."""


@dataclass(frozen=True)
class Lumped:
    """Lumped numbers fitted to windows of motion."""

    values: Array
    """(6,) A, B, c1, c2, G1, G2, relative to A22 [1, 1, 1/s, 1/s, 1/s^2, 1/s^2]."""
    unexplained: float
    """Share of the inner rod's acceleration that is unexplained in the windows fitted to (rms over rms)."""
    spread: float
    """Median of the unexplained `torques` of those windows."""

    @property
    def is_mechanism(self) -> bool:
        """Whether there is a double pendulum with these numbers: positive inertias, and gravity that pulls down."""
        A, B, *_, G1, G2 = self.values
        return bool(A > 0 and A**2 < B and G1 > 0 and G2 > 0)

    @property
    def is_mechanism_upside_down(self) -> bool:
        """Whether there is one if gravity pulls up: half a turn of both rods changes the sign of its terms alone."""
        return replace(self, values=self.values * (1, 1, 1, 1, -1, -1)).is_mechanism

    @property
    def is_mechanism_with_outer_rod_turned(self) -> bool:
        """Whether there is one if the outer rod alone is half a turn on: that changes the signs of A and G2."""
        return replace(self, values=self.values * (-1, 1, 1, 1, 1, -1)).is_mechanism


def motion_on_grid(time: Array, angles: Array, cart: Array | None) -> Motion:
    """Estimate angles and velocities on a grid from samples: time (n,) [s], angles (n, 2) [rad], cart (n,) [m]."""
    at = np.arange(time[0], time[-1], SPACING)
    cart = np.zeros(len(time)) if cart is None else cart
    values, slopes = local_motion(time, np.column_stack([angles, cart]), at)
    return Motion(at, values[:, :2], slopes[:, :2], values[:, 2], slopes[:, 2])


def windows(motion: Motion) -> tuple[Array, Array]:
    """Return the balance of each window of a motion that is given in theta1 and theta2.

    Returns:
        Coefficients (k, 2, 6) of the lumped numbers and what they must add up to (k, 2) [rad/s^2], for the k windows
        of WINDOW grid points that fit into the motion.
    """
    theta1, theta2 = motion.angles.T
    w1, w2 = motion.rates.T
    v, g = motion.cart_velocity, NOMINAL["g"]
    s, c = np.sin(theta1 - theta2), np.cos(theta1 - theta2)
    value, slope = _test_function()

    def integral(values: Array) -> Array:
        return np.asarray(np.convolve(values, value, mode="valid"), dtype=float)

    def derivative(values: Array) -> Array:
        """Integrate the time derivative of values against the test function, by parts."""
        return np.asarray(np.convolve(values, slope, mode="valid"), dtype=float)

    def gravity(theta: Array, w: Array) -> Array:
        # cos(theta) u = (cos(theta) v)' + sin(theta) w v
        return -integral(np.sin(theta)) + (derivative(np.cos(theta) * v) + integral(np.sin(theta) * w * v)) / g

    zero = np.zeros(len(motion.time) - len(value) + 1)
    inner = [
        derivative(c * w2) + integral(s * w1 * w2),
        zero,
        integral(w1),
        integral(w1 - w2),
        gravity(theta1, w1),
        zero,
    ]
    outer = [
        derivative(c * w1) - integral(s * w1 * w2),
        derivative(w2),
        zero,
        integral(w2 - w1),
        zero,
        gravity(theta2, w2),
    ]
    coefficients = np.stack([np.stack(inner, axis=-1), np.stack(outer, axis=-1)], axis=1)
    return coefficients, np.stack([-derivative(w1), zero], axis=-1)


def fit_lumped(coefficients: Array, target: Array, trusted: Mask) -> Lumped:
    """Fit the lumped numbers to the windows of which most agree, whatever the others say.

    Of the windows `trusted` (k,) to show motion, the half that fits worst is left out (least trimmed squares with
    concentration steps: Rousseeuw and Van Driessen, 2006). The fit begins with that of the short stretch with which
    most windows of the recording agree, so that a hand cannot draw it to its own motion.
    """
    coefficients, target = coefficients[trusted], target[trusted]
    stretches = np.array_split(np.arange(len(target)), max(1, min(_MOST_STRETCHES, len(target) // _STRETCH)))
    fits = [_least_squares(coefficients[stretch], target[stretch]) for stretch in stretches]
    values = max(fits, key=lambda fit: np.count_nonzero(torques(coefficients, target, fit) < _AGREEMENT))
    keep = (len(target) + 1) // 2
    chosen: npt.NDArray[np.int64] = np.empty(0, dtype=np.int64)
    for _ in range(_TRIMMED_ROUNDS):
        error = np.linalg.norm(residual(coefficients, target, values), axis=1)
        best = np.asarray(np.sort(np.argsort(error, kind="stable")[:keep]))
        if np.array_equal(best, chosen):
            break
        chosen = best
        values = _least_squares(coefficients[chosen], target[chosen])
    left = residual(coefficients[chosen], target[chosen], values)
    whole = float(np.linalg.norm(target[chosen]))
    spread = float(np.median(torques(coefficients[chosen], target[chosen], values)))
    return Lumped(values, float(np.linalg.norm(left)) / whole if whole > 0 else np.inf, spread)


def torques(coefficients: Array, target: Array, values: Array) -> Array:
    """Return the torque that is unexplained in each window (k,), as a share of gravity's largest on the same rod."""
    gravity = np.abs(values[4:])
    gravity = np.maximum(gravity, max(_SMALLEST_GRAVITY * gravity.max(), 1e-12))
    return np.asarray(np.max(np.abs(residual(coefficients, target, values)) / gravity, axis=1))


def residual(coefficients: Array, target: Array, values: Array) -> Array:
    """Return what the lumped numbers leave unexplained in each window (k, 2) [rad/s^2]."""
    return np.asarray(coefficients @ values - target)


def _least_squares(coefficients: Array, target: Array) -> Array:
    # Columns are scaled so that a joint that hardly moves does not decide about the others through rounding.
    columns = coefficients.reshape(-1, 6)
    scale = np.linalg.norm(columns, axis=0)
    scale[scale == 0] = 1.0
    return np.asarray(np.linalg.lstsq(columns / scale, target.ravel(), rcond=1e-9)[0] / scale)


def _test_function() -> tuple[Array, Array]:
    """Return weights that integrate a value, and its derivative by parts, against (1 - x^2)^3 scaled to one."""
    x = np.linspace(-1, 1, WINDOW)
    bump = (1 - x**2) ** 3
    slope = -6 * x * (1 - x**2) ** 2 / (SPACING * (WINDOW - 1) / 2)
    # By parts, a derivative is minus the value against the slope; np.convolve reverses the odd slope: minus once more.
    return bump / bump.sum(), slope / bump.sum()

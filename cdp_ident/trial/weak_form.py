"""The balance of forces in weak form: linear in lumped numbers, without accelerations.

The equations of motion of both rods are rates of change of momenta p and torques q, each linear in lumped numbers over
A22: those of the paper's model, G1 = a1 g and G2 = m2 l2 g for gravity, the joints' dry friction k1, k2, springs
(stiffness s, torque t), motors' torques times M, and the constant coupling D of a rotor geared to the outer joint. With
s, c the sine and cosine of theta1 - theta2, w1, w2 the angular velocities, d1, d2 the directions in which the joints
turn, and u the cart's acceleration::

    w1' + A23 [(c w2)' + s w1 w2] + D w2' + c1 w1 + c2 (w1 - w2) + k1 d1 - k2 d2 = G1 (sin theta1 - cos theta1 u / g)
    A23 [(c w1)' - s w1 w2] + D w1' + A33 w2' + c2 (w2 - w1) + k2 d2             = G2 (sin theta2 - cos theta2 u / g)

Multiplied with a test function that vanishes at the ends of a short window and integrated by parts, p' becomes minus
the integral of the function's slope times p: no derivative of the data beyond the angular velocities is taken
(Messenger and Bortz, J. Comput. Phys. 443, 2021; modulating functions: Shinbrot, Trans. ASME 79, 1957). The measured
speed v of a cart enters as cos(theta) u = (cos(theta) v)' + sin(theta) w v. Errors e1, e2 of the angles' zeros add, to
first order, the derivatives of the terms with A23, G1 and G2 by the angles, times E12 = A23 (e1 - e2), E1 = G1 e1 and
E2 = G2 e2.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.special import erf

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

COLUMNS = (
    *("A22", "A23", "A33", "c1", "c2", "G1", "G2", "k1", "k2", "D", "s1", "t1", "s2", "t2", "E12", "E1", "E2", "M"),
)
"""What the balance is linear in; A22 itself is one, and M what motors' torques are multiplied by."""


@dataclass(frozen=True)
class Kinematics:
    """A motion on an even grid of times, as measured first and then, if at all, as if measured again."""

    spacing: float
    """Of the grid [s]."""
    theta: Array
    """(1 + copies, m, 2) theta1, theta2 [rad]."""
    rates: Array
    """(1 + copies, m, 2) omega1, omega2 [rad/s]."""
    cart: Array
    """(1 + copies, m) speed of the cart [m/s]."""
    torques: Array | None = None
    """(m, 2) torques of motors in the joints [N m]; None where there are none."""

    @property
    def joint_angles(self) -> Array:
        """(…, m, 2) angles of the joints from where the rods hang [rad]."""
        return np.diff(self.theta, axis=-1, prepend=0.0) - [math.pi, 0.0]

    @property
    def joint_speeds(self) -> Array:
        """(…, m, 2) speeds of the joints [rad/s]."""
        return np.diff(self.rates, axis=-1, prepend=0.0)

    def directions(self, widths: Sequence[float] | Array) -> Array:
        """Return the directions (…, m, 2) in which joints slip, from -1 to 1.

        They are the means of the sign of speeds whose noise has standard deviations `widths` [rad/s].
        """
        scale = math.sqrt(2.0) * np.maximum(widths, np.finfo(float).tiny)
        return np.asarray(erf(self.joint_speeds / scale))


@dataclass(frozen=True)
class Windows:
    """Test functions (1 - x^2)^3 of one width, all over a motion."""

    value: Array
    """(2 half + 1,) weights that integrate a value against the test function, which integrates to one."""
    slope: Array
    """(2 half + 1,) weights that integrate a derivative against it, by parts [1/s]."""
    stride: int = 1
    """Grid points between the centres of neighbouring windows."""

    @classmethod
    def of(cls, half: int, spacing: float, stride: int = 1) -> "Windows":
        """Lay out windows of so many grid points on either side of their centre, on a grid of a spacing [s]."""
        x = np.linspace(-1.0, 1.0, 2 * half + 1)
        bump = (1.0 - x**2) ** 3
        slope = 6.0 * x * (1.0 - x**2) ** 2 / (half * spacing)
        return cls(bump / bump.sum(), slope / bump.sum(), stride)

    def count(self, points: int) -> int:
        """Return how many windows there are on so many grid points."""
        return max(0, -(-(points - len(self.value) + 1) // self.stride))

    def values_of(self, series: Array) -> Array:
        """Return series (…, m) integrated over each window (…, windows)."""
        return self._apply(series, self.value)

    def slopes_of(self, series: Array) -> Array:
        """Return the derivatives of series (…, m) integrated over each window (…, windows) [1/s]."""
        return self._apply(series, self.slope)

    def _apply(self, series: Array, weights: Array) -> Array:
        # What a window has in common with its neighbours is gone through once: stretches from centre to centre.
        stretches, count = -(-len(weights) // self.stride), self.count(series.shape[-1])
        if not count:
            return np.zeros((*series.shape[:-1], 0))
        by_stretch = np.zeros((stretches, self.stride))
        by_stretch.ravel()[: len(weights)] = weights
        points = (count - 1 + stretches) * self.stride
        cut = np.zeros((*series.shape[:-1], points))
        kept = min(points, series.shape[-1])
        cut[..., :kept] = series[..., :kept]
        sums = cut.reshape(*series.shape[:-1], -1, self.stride) @ by_stretch.T
        return np.asarray(sum(sums[..., k : k + count, k] for k in range(stretches)))

    def within(self, flags: Mask) -> Mask:
        """Return which windows have every grid point flagged (m,)."""
        view = np.lib.stride_tricks.sliding_window_view(flags, len(self.value))
        return np.asarray(view[:: self.stride].all(axis=-1))


def pushes_of(windows: Windows, torques: Array) -> Array:
    """Return what torques in both joints (m, 2) do to both rods in each window, (windows, rods, joints)."""
    inner, outer = windows.values_of(torques.T)
    # A torque between the rods acts on both.
    return np.stack([np.column_stack([inner, -outer]), np.column_stack([np.zeros_like(inner), outer])], axis=1)


def integrated(k: Kinematics, windows: Windows, directions: Array, gravity: float, columns: Sequence[str]) -> Array:
    """Return what lumped numbers are multiplied by in each window, (…, windows, 2, columns), of both equations.

    Args:
        k: the motion.
        windows: where.
        directions: (…, m, 2) in which the joints slip.
        gravity: g [m/s^2]; without a cart that moves it does not matter.
        columns: which of `COLUMNS`.
    """
    (theta1, theta2), (w1, w2) = np.moveaxis(k.theta, -1, 0), np.moveaxis(k.rates, -1, 0)
    (angle1, angle2), (d1, d2) = np.moveaxis(k.joint_angles, -1, 0), np.moveaxis(directions, -1, 0)
    s, c, one = np.sin(theta1 - theta2), np.cos(theta1 - theta2), np.ones_like(theta1)
    product, drives = w1 * w2, bool(np.any(k.cart))
    p, q = windows.slopes_of, windows.values_of

    def moment(sine: Array, cosine: Array, w: Array) -> Array:
        falls = -q(sine)
        return falls + (p(cosine * k.cart) + q(sine * w * k.cart)) / gravity if drives else falls

    found = np.zeros((*theta1.shape[:-1], windows.count(theta1.shape[-1]), 2, len(columns)))
    for place, name in enumerate(columns):
        first, second = found[..., 0, place], found[..., 1, place]
        if name == "A22":
            first[:] = p(w1)
        elif name == "A23":
            turned = q(s * product)
            first[:], second[:] = p(c * w2) + turned, p(c * w1) - turned
        elif name == "A33":
            second[:] = p(w2)
        elif name == "D":
            first[:], second[:] = p(w2), p(w1)
        elif name == "G1":
            first[:] = moment(np.sin(theta1), np.cos(theta1), w1)
        elif name == "G2":
            second[:] = moment(np.sin(theta2), np.cos(theta2), w2)
        elif name == "E12":
            turned = q(c * product)
            first[:], second[:] = turned - p(s * w2), -turned - p(s * w1)
        elif name == "M":
            if k.torques is not None:
                found[..., place] = -pushes_of(windows, k.torques).sum(axis=-1)
        elif name == "E1":
            first[:] = -q(np.cos(theta1))
        elif name == "E2":
            second[:] = -q(np.cos(theta2))
        else:
            inner, outer = {"c": (w1, w2 - w1), "k": (d1, d2), "s": (angle1, angle2), "t": (-one, -one)}[name[0]]
            # A torque between the rods acts on both.
            held = q(inner if name.endswith("1") else outer)
            first[:], second[:] = (held, 0.0) if name.endswith("1") else (-held, held)
    return found

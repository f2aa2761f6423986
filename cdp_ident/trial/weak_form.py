# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The balance of forces in weak form: linear in lumped numbers, without accelerations.

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
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import erf

from cdp_ident.arrays import Array
from cdp_ident.trial.scales import Scales

COLUMNS = ("A22", "A23", "A33", "c1", "c2", "G1", "G2", "k1", "k2", "D", "E12", "E1", "E2", "M1", "M2")
"""What the balance is linear in; A22 itself is one, and M1, M2 what motors' torques are multiplied by."""
WINDOW = 25
"""Grid points of a window: 1.2 units of the motion's time scale from its first to its last."""


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
    torques: Array | None = None
    """(m, 2) torques of motors in the joints [N m]; None where there are none, or they are no known input."""

    @property
    def noise(self) -> Array:
        """(2,) variance that the angles' noise gives to the acceleration over a window [(rad/s^2)^2]."""
        return self.gain * self.angle_noise**2

    @property
    def directions(self) -> Array:
        """(m, 2) directions in which joints slip, from -1 to 1; uncertain where dry friction may hold a joint.

        They are the means of the sign of speeds that are known to `scales.slow`, a standard deviation.
        """
        return np.asarray(erf(np.diff(self.rates, axis=1, prepend=0.0) / (math.sqrt(2.0) * self.scales.slow)))


def window_weights(spacing: float, half: int = WINDOW // 2) -> tuple[Array, Array]:
    """Return the weights (2 half + 1,) that integrate a value, and those that integrate a derivative by parts [1/s].

    The test function is (1 - x^2)^3, which integrates to one, on a grid of a spacing [s].
    """
    x = np.linspace(-1.0, 1.0, 2 * half + 1)
    bump = (1.0 - x**2) ** 3
    slope = 6.0 * x * (1.0 - x**2) ** 2 / (half * spacing)
    return bump / bump.sum(), slope / bump.sum()


def over_windows(series: Array, weights: Array, stride: int = 1) -> Array:
    """Return the integral of a series (m,) with some weights over windows (windows,) a stride of grid points apart."""
    if len(series) < len(weights):
        return np.zeros(0)
    return np.asarray(np.lib.stride_tricks.sliding_window_view(series, len(weights))[::stride] @ weights)


def integrated(motion: Motion, gravity: float, columns: Sequence[str], stride: int = 1) -> tuple[Array, Array]:
    """Return both equations in each window, and how uncertain the directions are in which the joints slip.

    Args:
        motion: of theta1 and theta2.
        gravity: g [m/s^2]; without a cart that moves it does not matter.
        columns: which of `COLUMNS`.
        stride: grid points between neighbouring windows.

    Returns:
        What the lumped numbers are multiplied by (windows, 2, columns), and the uncertainty, 0 to 1, (windows, 2).
    """
    value, slope = window_weights(motion.scales.spacing)
    terms, slack = _terms(motion, gravity), 1.0 - np.abs(motion.directions)
    uncertain = np.column_stack([over_windows(of_joint, value, stride) for of_joint in slack.T])
    found = np.zeros((len(uncertain), 2, len(columns)))
    for place, name in enumerate(columns):
        for rod, (momentum, torque) in enumerate(terms.get(name, ())):
            if momentum is not None:
                found[:, rod, place] += over_windows(momentum, slope, stride)
            if torque is not None:
                found[:, rod, place] += over_windows(torque, value, stride)
    return found, uncertain


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

    motors = (
        {}
        if motion.torques is None
        else {
            "M1": ((None, -motion.torques[:, 0]), none),
            "M2": outer_joint(-motion.torques[:, 1]),
        }
    )
    return motors | {
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

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The cart double pendulum as rigid bodies: inertia, forces, what each bearing carries, and joints that are stuck.

Written down body by body (Newton and Euler), so that the constraint forces are there; `reference.pendulum`, which
derives the same motion from the Lagrangian, is what it is tested against. Joint torques act between the two bodies of
a joint: t1 on theta1, and t2 on theta2 with its reaction on theta1.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from reference.compilation import compiled
from reference.pendulum import SYMBOLS

Array = npt.NDArray[np.float64]

M1, M2, M0, L1, L2, J1, J2, C1, C2, L, G, ROTOR, TILT, CART_MASS, CART_STIFFNESS, CART_DAMPING = range(16)
"""Places in the array that compiled code takes a rig as."""
STUCK, FORWARD, BACKWARD = 0, 1, -1
"""What a joint does: it stands still, or slips with a positive or negative rate."""


@dataclass(frozen=True)
class Cart:
    """A cart that is free on its rail but for a spring and a damper."""

    mass: float
    """[kg]"""
    stiffness: float
    """Of the spring that holds it [N/m]."""
    damping: float
    """[N s/m]"""


@dataclass(frozen=True)
class Rig:
    """A pendulum and what it stands on."""

    values: Mapping[str, float]
    """Physical values of all `SYMBOLS`."""
    rotor: float = 0.0
    """Inertia that turns with the outer joint's relative rate, as a motor's rotor behind a gear does [kg m^2]."""
    tilt: float = 0.0
    """Angle by which gravity pulls askew: at rest the rods hang along pi + tilt [rad]."""
    cart: Cart | None = None
    """The cart, or None where it is held fast."""

    @property
    def array(self) -> Array:
        """(16,) all of it, as compiled code takes it."""
        cart = (self.cart.mass, self.cart.stiffness, self.cart.damping) if self.cart else (0.0, 0.0, 0.0)
        return np.array([*(self.values[symbol] for symbol in SYMBOLS), self.rotor, self.tilt, *cart])


@compiled
def balance(rig: Array, state: Array, torque1: float, torque2: float) -> tuple[float, ...]:
    """Return M11, M12, M22, f1, f2 of M alpha = f, and c1, c2, c0 of the cart's u = c0 - c1 alpha1 - c2 alpha2.

    Args:
        rig: see `Rig.array`.
        state: theta1, theta2, omega1, omega2 [rad, rad/s], cart position and speed [m, m/s].
        torque1: what acts on theta1 beside gravity and viscous friction [N m].
        torque2: what acts on theta2 [N m].
    """
    theta1, theta2, omega1, omega2 = state[0], state[1], state[2], state[3]
    s1, k1, s2, k2 = math.sin(theta1), math.cos(theta1), math.sin(theta2), math.cos(theta2)
    pull_x, pull_z = -rig[G] * math.sin(rig[TILT]), -rig[G] * math.cos(rig[TILT])
    first = rig[M1] * rig[L1] + (rig[M0] + rig[M2]) * rig[L]
    second = rig[M2] * rig[L2]
    inward1, inward2 = omega1 * omega1, omega2 * omega2
    M11 = rig[J1] + rig[M1] * rig[L1] ** 2 + (rig[M0] + rig[M2]) * rig[L] ** 2 + rig[ROTOR]
    M22 = rig[J2] + rig[M2] * rig[L2] ** 2 + rig[ROTOR]
    M12 = second * rig[L] * (k1 * k2 + s1 * s2) - rig[ROTOR]
    across = second * rig[L] * (s1 * k2 - k1 * s2)
    viscous = -rig[C2] * (omega2 - omega1)
    f1 = first * (pull_x * k1 - pull_z * s1) - across * inward2 - rig[C1] * omega1 - viscous + torque1
    f2 = second * (pull_x * k2 - pull_z * s2) + across * inward1 + viscous + torque2
    if rig[CART_MASS] == 0.0:
        return M11, M12, M22, f1, f2, 0.0, 0.0, 0.0
    mass = rig[CART_MASS] + rig[M1] + rig[M2] + rig[M0]
    c1, c2 = first * k1 / mass, second * k2 / mass
    force = first * s1 * inward1 + second * s2 * inward2 + mass * pull_x
    c0 = (force - rig[CART_STIFFNESS] * state[4] - rig[CART_DAMPING] * state[5]) / mass
    return (
        M11 - mass * c1 * c1, M12 - mass * c1 * c2, M22 - mass * c2 * c2,
        f1 - mass * c1 * c0, f2 - mass * c2 * c0, c1, c2, c0,
    )  # fmt: skip


@compiled
def constrained(
    M11: float, M12: float, M22: float, f1: float, f2: float, mode1: int, mode2: int, size1: float, size2: float
) -> tuple[float, float, float, float]:
    """Return alpha1, alpha2 [rad/s^2] and both joints' dry torques [N m], from what the joints do.

    A joint that slips has the torque of its `size` against its motion; one that is stuck has what keeps it so.
    """
    t1, t2 = -mode1 * size1, -mode2 * size2
    if mode1 == STUCK and mode2 == STUCK:
        return 0.0, 0.0, -f1 - f2, -f2
    if mode1 == STUCK:
        alpha2 = (f2 + t2) / M22
        return 0.0, alpha2, M12 * alpha2 - f1 + t2, t2
    if mode2 == STUCK:
        alpha = (f1 + f2 + t1) / (M11 + 2.0 * M12 + M22)
        return alpha, alpha, t1, (M12 + M22) * alpha - f2
    g1, g2 = f1 + t1 - t2, f2 + t2
    determinant = M11 * M22 - M12 * M12
    return (M22 * g1 - M12 * g2) / determinant, (M11 * g2 - M12 * g1) / determinant, t1, t2


@compiled
def bearing_loads(rig: Array, state: Array, alpha1: float, alpha2: float, u: float) -> tuple[float, float]:
    """Return the forces that the inner and the outer bearing carry [N], for a cart's acceleration u [m/s^2]."""
    s1, k1, s2, k2 = math.sin(state[0]), math.cos(state[0]), math.sin(state[1]), math.cos(state[1])
    inward1, inward2 = state[2] * state[2], state[3] * state[3]
    # Acceleration less gravity of a point at unit distance along each rod, and of the cart.
    x1, z1 = alpha1 * k1 - inward1 * s1, -alpha1 * s1 - inward1 * k1
    x2, z2 = alpha2 * k2 - inward2 * s2, -alpha2 * s2 - inward2 * k2
    x0, z0 = u + rig[G] * math.sin(rig[TILT]), rig[G] * math.cos(rig[TILT])
    outer_x = rig[M2] * (x0 + rig[L] * x1 + rig[L2] * x2)
    outer_z = rig[M2] * (z0 + rig[L] * z1 + rig[L2] * z2)
    inner_x = outer_x + rig[M1] * (x0 + rig[L1] * x1) + rig[M0] * (x0 + rig[L] * x1)
    inner_z = outer_z + rig[M1] * (z0 + rig[L1] * z1) + rig[M0] * (z0 + rig[L] * z1)
    return math.hypot(inner_x, inner_z), math.hypot(outer_x, outer_z)

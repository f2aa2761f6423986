# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Torques beyond the paper's model that are smooth: springs, magnets, the air, knocks, presliding, eddy currents.

Each is one row for compiled code: its kind, where it acts, and up to six numbers. A joint's angle is counted from
hanging (inner) and from straight (outer).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import numpy.typing as npt

from reference.compilation import compiled
from reference.dry_friction import wrapped
from reference.mechanics import L

Array = npt.NDArray[np.float64]
Joint = Literal["inner", "outer"]

QUADRATIC, SPRING, COGGING, MAGNET, DRAG, KNOCK, DAHL, CONSTANT, EDDY, STOP, COOLING, WIND, BOB, BRAKE = range(14)
_WIDTH = 8


@dataclass(frozen=True)
class Torque:
    """One torque."""

    kind: int
    joint: Joint
    """The joint that it acts in; for drag and knocks the rod that it acts on."""
    numbers: tuple[float, ...]

    @property
    def row(self) -> list[float]:
        """All of it, as compiled code takes it."""
        row = [float(self.kind), float(self.joint == "outer"), *self.numbers]
        return row + [0.0] * (_WIDTH - len(row))


def quadratic(joint: Joint, coefficient: float) -> Torque:
    """Return friction with the square of the joint's rate [N m s^2]."""
    return Torque(QUADRATIC, joint, (coefficient,))


def spring(joint: Joint, stiffness: float, at_ease: float) -> Torque:
    """Return a spring [N m/rad] that is at ease at an angle [rad]."""
    return Torque(SPRING, joint, (stiffness, at_ease))


def cogging(joint: Joint, size: float, periods: int, phase: float) -> Torque:
    """Return detents: `size` sin(`periods` angle + `phase`) [N m]."""
    return Torque(COGGING, joint, (size, float(periods), phase))


def magnet(joint: Joint, size: float, at: float, reach: float) -> Torque:
    """Return a magnet's pull towards an angle `at` [rad], largest (`size` [N m]) at a distance of `reach` [rad]."""
    return Torque(MAGNET, joint, (size, at, reach))


def drag(joint: Joint, coefficient: float, length: float = 0.0) -> Torque:
    """Return air drag on a rod, in [N m s^2] of the rod's own rotation.

    Args:
        joint: the rod.
        coefficient: the torque is coefficient omega |omega| where the rod's joint is at rest.
        length: for the outer rod, the length from its joint on that the air acts on [m], strip by strip, each with
            its own absolute speed; 0 for its rotation alone.
    """
    return Torque(DRAG, joint, (coefficient, length))


def bob(coefficient: float, length: float) -> Torque:
    """Return air drag on a body on the outer rod, so far from its joint [m], in [N m s^2] of the rod's rotation."""
    return Torque(BOB, "outer", (coefficient, length))


def knock(joint: Joint, impulse: float, at: float, duration: float) -> Torque:
    """Return a push on a rod [N m s] that begins at a time and lasts for a duration [s], as 1 - cos of its phase."""
    return Torque(KNOCK, joint, (impulse, at, duration))


def dahl(joint: Joint, torque: float, stiffness: float) -> Torque:
    """Return dry friction that is elastic before it slips (Dahl, 1968): its full size [N m] and stiffness [N m/rad]."""
    return Torque(DAHL, joint, (torque, stiffness))


def constant(joint: Joint, torque: float) -> Torque:
    """Return a torque [N m] that is always the same."""
    return Torque(CONSTANT, joint, (torque,))


def eddy_currents(joint: Joint, size: float, periods: int, phase: float) -> Torque:
    """Return viscous friction [N m s] that varies over the turn, from `size` to minus it, beside what is there."""
    return Torque(EDDY, joint, (size, float(periods), phase))


def stop(joint: Joint, stiffness: float, place: float, loss: float) -> Torque:
    """Return an elastic stop [N m/rad] beyond an angle [rad], away from zero, that takes energy (Hunt and Crossley).

    It does not pull where the joint leaves it fast.
    """
    return Torque(STOP, joint, (stiffness, place, loss))


def eddy_brake(joint: Joint, coefficient: float, at: float, half: float) -> Torque:
    """Return viscous friction [N m s] that is largest at an angle and falls to nothing `half` to either side [rad]."""
    return Torque(BRAKE, joint, (coefficient, at, half))


def cooling(joint: Joint, size: float, time_constant: float) -> Torque:
    """Return viscous friction [N m s] that a trial begins with and that dies away within a time [s]."""
    return Torque(COOLING, joint, (size, time_constant))


def wind(inner: float, outer: float) -> Torque:
    """Return a steady force from the side, by its moments about both rods' joints where they hang [N m]."""
    return Torque(WIND, "inner", (-inner, -outer))


def table(torques: Sequence[Torque]) -> Array:
    """Return the rows (k, 8) of torques."""
    return np.array([torque.row for torque in torques]).reshape(-1, _WIDTH)


@compiled
def _strip_sums(a: float, b: float, end: float) -> tuple[float, float]:
    """Return the integrals over s from 0 to `end` of u |u| and s u |u|, u = a + b s; u does not change sign there."""
    direction = 1.0 if a + 0.5 * b * end > 0.0 else -1.0
    force = a * a * end + a * b * end**2 + b * b * end**3 / 3.0
    moment = a * a * end**2 / 2.0 + 2.0 * a * b * end**3 / 3.0 + b * b * end**4 / 4.0
    return direction * force, direction * moment


@compiled
def _strips(a: float, b: float, end: float) -> tuple[float, float]:
    """Return the same where u may change its sign on the way: there the rest is the whole less the part before."""
    if a * (a + b * end) >= 0.0:
        return _strip_sums(a, b, end)
    turn = -a / b
    force, moment = _strip_sums(a, b, turn)
    # Beyond the turn, u = b s' with s' from the turn on.
    rest = end - turn
    beyond_force = b * abs(b) * rest**3 / 3.0
    beyond_moment = b * abs(b) * rest**4 / 4.0 + turn * beyond_force
    return force + beyond_force, moment + beyond_moment


@compiled
def add_torques(torques: Array, rig: Array, time: float, state: Array, rates: Array) -> tuple[float, float]:
    """Return the generalised torques on theta1 and theta2 [N m], and set the rates of Dahl's deflections.

    Args:
        torques: (k, 8) see `table`.
        rig: see `Rig.array`.
        time: in the trial [s].
        state: (8,) theta1, theta2, omega1, omega2, cart position and speed, the joints' deflections [rad].
        rates: (8,) of which the last two are set.
    """
    on1, on2 = 0.0, 0.0
    theta1, theta2, omega1, omega2 = state[0], state[1], state[2], state[3]
    for k in range(torques.shape[0]):
        kind, outer = int(torques[k, 0]), torques[k, 1] > 0.5
        a, b, c = torques[k, 2], torques[k, 3], torques[k, 4]
        angle, rate = (theta2 - theta1, omega2 - omega1) if outer else (theta1 - math.pi, omega1)
        in_joint = 0.0
        if kind == QUADRATIC:
            in_joint = -a * rate * abs(rate)
        elif kind == SPRING:
            in_joint = -a * (angle - b)
        elif kind == COGGING:
            in_joint = a * math.sin(b * angle + c)
        elif kind == MAGNET:
            away = wrapped(angle - b) / c
            in_joint = -a * away * math.exp(0.5 * (1.0 - away * away))
        elif kind == CONSTANT:
            in_joint = a
        elif kind == EDDY:
            in_joint = -a * rate * math.sin(b * angle + c)
        elif kind == BRAKE:
            away = wrapped(angle - b) / c
            in_joint = -0.5 * a * rate * (1.0 + math.cos(math.pi * away)) if abs(away) < 1.0 else 0.0
        elif kind == COOLING:
            in_joint = -a * rate * math.exp(-time / b)
        elif kind == WIND:
            on1 += a * math.cos(theta1)
            on2 += b * math.cos(theta2)
        elif kind == STOP:
            depth = (angle - b) if b > 0.0 else (b - angle)
            inwards = rate if b > 0.0 else -rate
            if depth > 0.0:
                in_joint = -math.copysign(a * depth * max(1.0 + c * inwards, 0.0), b)
        elif kind == DAHL:
            deflection = state[7 if outer else 6]
            in_joint = -b * deflection
            rates[7 if outer else 6] = rate - abs(rate) * deflection * b / a
        elif kind == DRAG and not outer:
            on1 -= a * omega1 * abs(omega1)
        elif kind == DRAG and b == 0.0:
            on2 -= a * omega2 * abs(omega2)
        elif kind == DRAG:
            lever = rig[L] * math.cos(theta1 - theta2)
            force, moment = _strips(lever * omega1, omega2, b)
            on1 -= 4.0 * a / b**4 * lever * force
            on2 -= 4.0 * a / b**4 * moment
        elif kind == BOB:
            x = rig[L] * math.cos(theta1) * omega1 + b * math.cos(theta2) * omega2
            y = rig[L] * math.sin(theta1) * omega1 + b * math.sin(theta2) * omega2
            force = a / b**3 * math.hypot(x, y)
            on1 -= force * rig[L] * (math.cos(theta1) * x + math.sin(theta1) * y)
            on2 -= force * b * (math.cos(theta2) * x + math.sin(theta2) * y)
        elif kind == KNOCK:
            phase = (time - b) / c
            push = a / c * (1.0 - math.cos(2.0 * math.pi * phase)) if 0.0 < phase < 1.0 else 0.0
            if outer:
                on2 += push
            else:
                on1 += push
        if outer:
            on1 -= in_joint
            on2 += in_joint
        else:
            on1 += in_joint
    return on1, on2

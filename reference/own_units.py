# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A double pendulum of any size whose joints stick, its friction set-valued and every event located.

Everything is in the rig's own units: lengths of L, times of sqrt(L / g), inertias of A22. One motion so serves rigs of
every size: only the clock differs. Nothing here comes from `cdp_ident`.
"""

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp

Array = npt.NDArray[np.float64]
Mode = tuple[int, int]


@dataclass(frozen=True)
class Rig:
    """The numbers of a pendulum, over A22, in units of L and sqrt(L / g)."""

    A23: float
    A33: float
    a1: float
    """a1 L over A22."""
    c1: float = 0.0
    c2: float = 0.0
    dry1: float = 0.0
    """Torque of the inner joint's dry friction."""
    dry2: float = 0.0
    coupling: float = 0.0
    """Constant element beside the diagonal of the matrix of inertia, as of a geared rotor."""
    tilt: float = 0.0
    """Direction from which gravity acts [rad]."""
    square2: float = 0.0
    """Friction of the outer joint that grows with the square of its speed."""

    def accelerations(self, state: Array, mode: Mode) -> tuple[Array, Array]:
        """Return the rods' accelerations (2,), and the torque of dry friction (2,) in each joint.

        A joint of mode 0 sticks; of mode 1 or -1 it slips in that direction.
        """
        theta1, theta2, w1, w2 = (float(value) for value in state)
        s, c = math.sin(theta1 - theta2), math.cos(theta1 - theta2)
        beside = self.A23 * c + self.coupling
        # The inverse of the matrix of inertia, of the rods and, for torques in the joints, of the joints.
        determinant = self.A33 - beside**2
        i11, i12, i22 = self.A33 / determinant, -beside / determinant, 1.0 / determinant
        j11, j12, j22 = i11, i12 - i11, i11 - 2.0 * i12 + i22
        relative = w2 - w1
        between = self.c2 * relative + self.square2 * relative * abs(relative)
        free1 = self.a1 * math.sin(theta1 - self.tilt) - self.A23 * s * w2**2 - self.c1 * w1 + between
        free2 = self.A23 * math.sin(theta2 - self.tilt) + self.A23 * s * w1**2 - between
        # Accelerations of the joints without any torque of theirs that is not known.
        dry1, dry2 = -self.dry1 * mode[0], -self.dry2 * mode[1]
        onto1, onto2 = free1 + dry1 - dry2, free2 + dry2
        joint1 = i11 * onto1 + i12 * onto2
        joint2 = i12 * onto1 + i22 * onto2 - joint1
        if mode == (0, 0):
            both = j11 * j22 - j12 * j12
            dry1, dry2 = (j12 * joint2 - j22 * joint1) / both, (j12 * joint1 - j11 * joint2) / both
        elif mode[0] == 0:
            dry1 = -joint1 / j11
        elif mode[1] == 0:
            dry2 = -joint2 / j22
        onto1, onto2 = free1 + dry1 - dry2, free2 + dry2
        return np.array([i11 * onto1 + i12 * onto2, i12 * onto1 + i22 * onto2]), np.array([dry1, dry2])

    def mode(self, state: Array, still: tuple[bool, bool]) -> Mode:
        """Return how the joints go on from a state in which those marked stand still."""
        speeds = _JOINTS.T @ state[2:]
        limits = (self.dry1, self.dry2)
        choices = [
            ((0, 1, -1) if limits[k] > 0 else (1,)) if still[k] else (int(np.sign(speeds[k])) or 1,) for k in range(2)
        ]
        for inner, outer in itertools.product(*choices):
            mode = (inner, outer)
            acceleration, torque = self.accelerations(state, mode)
            onward = _JOINTS.T @ acceleration
            if all(
                not still[k]
                or limits[k] == 0
                or (abs(torque[k]) < (1 - _EDGE) * limits[k] if m == 0 else m * onward[k] > -_EDGE)
                for k, m in enumerate(mode)
            ):
                return mode
        raise ArithmeticError(f"no way on from {state}")


_EDGE = 1e-7
"""Relative torque within which a joint is on the edge of slipping, and time within which it comes back from that."""
_JOINTS = np.array([[1.0, -1.0], [0.0, 1.0]])
"""Torques in the joints act on the rods as this does; joints turn against the rods as its transpose."""


def motion(rig: Rig, start: Array, times: Array, tolerance: float = 1e-9) -> Array:
    """Return the states (n, 4) at ascending times (n,) from 0 on: theta1, theta2 and their derivatives."""
    state, now, end = np.array(start, dtype=float), 0.0, float(times[-1])
    states = np.empty((len(times), 4))
    limits = (rig.dry1, rig.dry2)
    speeds = _JOINTS.T @ state[2:]
    mode = rig.mode(state, (bool(speeds[0] == 0.0), bool(speeds[1] == 0.0)))
    while now < end:
        if mode == (0, 0):
            states[times >= now] = state
            break

        def rate(_: float, at: Array, mode: Mode = mode) -> Array:
            return np.concatenate([at[2:], rig.accelerations(at, mode)[0]])

        events = [_event(rig, mode, k) for k in range(2) if limits[k] > 0]
        solution = solve_ivp(
            rate, (now, end), state, "DOP853", rtol=tolerance, atol=tolerance, max_step=1.0, events=events,
            dense_output=True,
        )  # fmt: skip
        if not solution.success:
            raise ArithmeticError(solution.message)
        inside = slice(np.searchsorted(times, now), np.searchsorted(times, solution.t[-1], side="right"))
        if inside.stop > inside.start:
            states[inside] = solution.sol(times[inside]).T
        grazes = float(solution.t[-1]) - now < _EDGE
        now, state = float(solution.t[-1]), solution.y[:, -1].copy()
        if now >= end:
            break
        speeds = _JOINTS.T @ state[2:]
        turned = [bool(m == 0 or abs(v) < 1e-7) and f > 0 for m, v, f in zip(mode, speeds, limits, strict=True)]
        speeds[turned] = 0.0
        state[2:] = np.linalg.solve(_JOINTS.T, speeds)
        if grazes:  # at the very edge of slipping, with ever less to make it slip
            mode = (0 if turned[0] else mode[0], 0 if turned[1] else mode[1])
        else:
            mode = rig.mode(state, (turned[0], turned[1]))
    return states


def _event(rig: Rig, mode: Mode, joint: int) -> Callable[[float, Array], float]:
    """Return what is zero where a joint comes to stand still, or breaks loose."""

    def comes_to_rest(_: float, state: Array) -> float:
        return float(mode[joint] * (_JOINTS.T @ state[2:])[joint])

    def breaks_loose(_: float, state: Array) -> float:
        return float((rig.dry1, rig.dry2)[joint] - abs(rig.accelerations(state, mode)[1][joint]))

    event = comes_to_rest if mode[joint] else breaks_loose
    event.terminal, event.direction = True, -1.0  # type: ignore[attr-defined]
    return event

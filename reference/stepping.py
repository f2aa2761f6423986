# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Moves a pendulum while its joints go on doing what they do: then everything is smooth.

By Dormand and Prince's method of order 8 (Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I,
1993), with the coefficients and the error estimate that scipy has.
"""

import math

import numpy as np
import numpy.typing as npt
from scipy.integrate import DOP853

from reference.compilation import compiled
from reference.dry_friction import LEVER, friction_size
from reference.mechanics import CART_MASS, STUCK, balance, bearing_loads, constrained
from reference.torques import add_torques

Array = npt.NDArray[np.float64]
System = tuple[Array, Array, Array, npt.NDArray[np.bool_]]
"""The rig (see `Rig.array`), torques (see `torques.table`), dry frictions (2, 9) of both joints (see
`DryFriction.array`), and (2,) whether there is any in them."""

STATES = 8
"""theta1, theta2, omega1, omega2, the cart's position and speed, the deflections of both joints' presliding."""
STAGES = len(DOP853.B)
# Tuples, for numba keeps no compiled code on disk that has larger arrays in it.
_A = tuple(tuple(float(a) for a in row) for row in DOP853.A)
_B, _C, _E3, _E5 = (tuple(float(a) for a in row) for row in (DOP853.B, DOP853.C, DOP853.E3, DOP853.E5))
_SWEEPS = 60
"""At most so many until dry friction agrees with the load that it changes itself."""


@compiled
def joint_rate(state: Array, joint: int) -> float:
    """Return a joint's rate, or its acceleration where the rates (8,) are given [rad/s, rad/s^2]."""
    return state[2] if joint == 0 else state[3] - state[2]


@compiled
def find_rates(system: System, modes: Array, time: float, state: Array, rates: Array, held: Array) -> None:
    """Set the state's rates, and what holds the joints back.

    Args:
        system: what moves.
        modes: (2,) what the joints do.
        time: in the trial [s].
        state: (8,)
        rates: (8,) is set.
        held: (2, 2) is set: the dry torque of each joint, and how large it may be [N m].
    """
    rig, torques, frictions, dry = system
    rates[6], rates[7] = 0.0, 0.0
    on1, on2 = add_torques(torques, rig, time, state, rates)
    M11, M12, M22, f1, f2, c1, c2, c0 = balance(rig, state, on1, on2)
    rate1 = 0.0 if modes[0] == STUCK else state[2]
    rate2 = 0.0 if modes[1] == STUCK else state[3] - state[2]
    load1, load2, last = 0.0, 0.0, 0.0
    alpha1, alpha2 = 0.0, 0.0
    for _ in range(_SWEEPS):
        held[0, 1] = friction_size(frictions[0], time, state[0] - math.pi, rate1, load1) if dry[0] else 0.0
        held[1, 1] = friction_size(frictions[1], time, state[1] - state[0], rate2, load2) if dry[1] else 0.0
        alpha1, alpha2, held[0, 0], held[1, 0] = constrained(
            M11, M12, M22, f1, f2, modes[0], modes[1], held[0, 1], held[1, 1]
        )
        if frictions[0, LEVER] == 0.0 and frictions[1, LEVER] == 0.0:
            break
        load1, load2 = bearing_loads(rig, state, alpha1, alpha2, c0 - c1 * alpha1 - c2 * alpha2)
        if abs(load1 + load2 - last) <= 1e-15 * last:
            break
        last = load1 + load2
    rates[0], rates[1], rates[2], rates[3] = state[2], state[3], alpha1, alpha2
    moves = rig[CART_MASS] > 0.0
    rates[4], rates[5] = (state[5], c0 - c1 * alpha1 - c2 * alpha2) if moves else (0.0, 0.0)


@compiled
def step(
    system: System, modes: Array, time: float, state: Array, h: float, end: Array, stages: Array, tolerance: float
) -> float:
    """Set the state after a step, and return its estimated error over the tolerance.

    Args:
        system: what moves.
        modes: (2,) what the joints do all the time.
        time: at the beginning [s].
        state: (8,) at the beginning.
        h: the step [s].
        end: (8,) is set to the state at the end; a joint that is stuck has exactly no rate.
        stages: (12, 8) is set to the rates on the way, of which the first are at the beginning, the last at the end.
        tolerance: relative and absolute tolerance of the step.
    """
    inner, held = np.empty(STATES), np.empty((2, 2))
    for s in range(STAGES):
        for i in range(STATES):
            change = 0.0
            for r in range(s):
                change += _A[s][r] * stages[r, i]
            inner[i] = state[i] + h * change
        find_rates(system, modes, time + _C[s] * h, inner, stages[s], held)
    error5, error3 = 0.0, 0.0
    for i in range(STATES):
        change, fifth, third = 0.0, 0.0, 0.0
        for s in range(STAGES):
            change += _B[s] * stages[s, i]
            fifth += _E5[s] * stages[s, i]
            third += _E3[s] * stages[s, i]
        end[i] = state[i] + h * change
        scale = tolerance * (1.0 + max(abs(state[i]), abs(end[i])))
        error5 += (fifth / scale) ** 2
        error3 += (third / scale) ** 2
    if modes[0] == STUCK:
        end[2] = 0.0
    if modes[1] == STUCK:
        end[3] = end[2]
    return h * error5 / math.sqrt((error5 + 0.01 * error3) * STATES) if error5 > 0.0 else 0.0

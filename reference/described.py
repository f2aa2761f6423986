# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Torques beyond the paper's model, in formulas from the physics, one by one; encoders' errors are in `encoders`.

They are independent of the package's own and of the engine's: dry friction turns over in another form and at another
width, drag is summed over strips.
"""

import math
from collections.abc import Callable, Mapping

import numpy as np

from reference.pendulum import accelerations

Values = Mapping[str, float]
State = tuple[float, ...]
Torque = Callable[[float, State, Values, float], tuple[float, float]]
"""From time, state, values and strength to the generalised torques on theta1 and theta2 [N m]."""
Law = Callable[[float, float, float], float]
"""From a joint's angle since hanging [rad], its rate [rad/s] and the strength to its torque [N m]."""

_TURNOVER = 0.005
"""Rate at which dry friction has 71 % of its full size [rad/s]."""
_STRIPS = 20


def sign(rate: float) -> float:
    """Return the direction of a motion, smooth near rest."""
    return rate / math.sqrt(rate * rate + _TURNOVER * _TURNOVER)


def in_joint(joint: str, law: Law) -> Torque:
    """Return a torque between the two bodies of a joint."""
    if joint == "inner":

        def torque(time: float, state: State, values: Values, strength: float) -> tuple[float, float]:
            return law(state[0] - math.pi, state[2], strength), 0.0
    else:

        def torque(time: float, state: State, values: Values, strength: float) -> tuple[float, float]:
            across = law(state[1] - state[0], state[3] - state[2], strength)
            return -across, across

    return torque


def dry(joint: str) -> Torque:
    """Coulomb friction."""
    return in_joint(joint, lambda _, rate, size: -size * sign(rate))


def stribeck(joint: str, rng: np.random.Generator) -> Torque:
    """Coulomb friction that grows as the motion slows down."""
    slow, more = rng.uniform(0.3, 1.5), rng.uniform(0.6, 1.5)

    def law(_: float, rate: float, size: float) -> float:
        return -size * (1.0 + more * math.exp(-((rate / slow) ** 2))) * sign(rate)

    return in_joint(joint, law)


def quadratic(joint: str) -> Torque:
    """Friction with the square of the joint's speed."""
    return in_joint(joint, lambda _, rate, size: -size * rate * abs(rate))


def spring(joint: str, rng: np.random.Generator) -> Torque:
    """A cable across the joint, at ease somewhere near hanging."""
    at_ease = rng.uniform(-0.3, 0.3)
    return in_joint(joint, lambda angle, _, size: -size * (angle - at_ease))


def cogging(joint: str, rng: np.random.Generator) -> Torque:
    """The detents of a motor."""
    periods, phase = int(rng.integers(3, 17)), rng.uniform(-math.pi, math.pi)
    return in_joint(joint, lambda angle, _, size: size * math.sin(periods * angle + phase))


def load_friction(joint: str) -> Torque:
    """Dry friction in proportion to the force that the joint's bearing carries, which the friction itself changes."""

    def under(acting: tuple[float, float], state: State, values: Values, strength: float) -> tuple[float, float]:
        theta1, theta2, omega1, omega2 = state[:4]
        alpha1, alpha2 = accelerations(values, np.array(state[:4]), 0.0, acting)
        along, up = 0.0, 0.0
        bodies = [(values["m2"], values["L"], values["l2"])]
        if joint == "inner":
            bodies += [(values["m1"], values["l1"], 0.0), (values["m0"], values["L"], 0.0)]
        for mass, r1, r2 in bodies:
            s1, k1, s2, k2 = math.sin(theta1), math.cos(theta1), math.sin(theta2), math.cos(theta2)
            along += mass * (r1 * (alpha1 * k1 - omega1**2 * s1) + r2 * (alpha2 * k2 - omega2**2 * s2))
            up += mass * (values["g"] - r1 * (alpha1 * s1 + omega1**2 * k1) - r2 * (alpha2 * s2 + omega2**2 * k2))
        size = strength * math.hypot(along, up)
        if joint == "inner":
            return -size * sign(omega1), 0.0
        across = -size * sign(omega2 - omega1)
        return -across, across

    def torque(time: float, state: State, values: Values, strength: float) -> tuple[float, float]:
        acting = (0.0, 0.0)
        for _ in range(20):
            acting = under(acting, state, values, strength)
        return acting

    return torque


def drag(joint: str, rng: np.random.Generator) -> Torque:
    """Air drag on a rod; of the outer one by its rotation alone, or strip by strip along it."""
    if joint == "inner":

        def torque(time: float, state: State, values: Values, strength: float) -> tuple[float, float]:
            return -strength * state[2] * abs(state[2]), 0.0
    elif rng.random() < 0.5:

        def torque(time: float, state: State, values: Values, strength: float) -> tuple[float, float]:
            return 0.0, -strength * state[3] * abs(state[3])
    else:
        share = rng.uniform(0.0, 1.0)

        def torque(time: float, state: State, values: Values, strength: float) -> tuple[float, float]:
            theta1, theta2, omega1, omega2 = state[:4]
            shortest = 2.0 * values["l2"]
            length = shortest + share * max(values["L"] - shortest, 0.0)
            carried = values["L"] * math.cos(theta1 - theta2)
            force, moment = 0.0, 0.0
            for k in range(_STRIPS):
                along = (k + 0.5) / _STRIPS * length
                across = carried * omega1 + along * omega2
                # So that a rod that only rotates has the torque -strength omega2 |omega2|.
                pressure = -4.0 * strength / length**3 * across * abs(across) / _STRIPS
                force += pressure
                moment += along * pressure
            return carried * force, moment

    return torque


def tilt() -> Torque:
    """A base that is not level: gravity pulls askew."""

    def torque(time: float, state: State, values: Values, strength: float) -> tuple[float, float]:
        first = values["m1"] * values["l1"] + (values["m2"] + values["m0"]) * values["L"]
        moments = (first * values["g"], values["m2"] * values["l2"] * values["g"])
        turned = [m * (math.sin(a - strength) - math.sin(a)) for m, a in zip(moments, state, strict=False)]
        return turned[0], turned[1]

    return torque

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What can go on in a pendulum beyond the paper's model: formulas from the physics, one by one.

They are independent of the package's own and of the engine's: dry friction turns over in another form and at another
width, drag is summed over strips.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from reference.pendulum import accelerations

Array = npt.NDArray[np.float64]
Values = Mapping[str, float]
State = tuple[float, ...]
Motion = Callable[[Array], Array]
"""From times (n,) [s] to the states (n, 4) then."""
Law = Callable[[float, float, float], float]
"""From a joint's angle since hanging [rad], its rate [rad/s] and the strength to its torque [N m]."""

_TURNOVER = 0.005
"""Rate at which dry friction has 71 % of its full size [rad/s]."""
_STRIPS = 20


@dataclass(frozen=True)
class Described:
    """An effect. Its formulas take the strength, so that the same one can be made weak or strong."""

    name: str
    torque: Callable[[float, State, Values, float], tuple[float, float]] | None = None
    """`(time, state, values, strength)` to the generalised torques on theta1 and theta2 [N m]."""
    reading: Callable[[Array, Motion, Values, float], Array] | None = None
    """`(times, motion, values, strength)` to what is added to the encoders' angles (n, 2) [rad]: inner, outer."""


def sign(rate: float) -> float:
    """Return the direction of a motion, smooth near rest."""
    return rate / math.sqrt(rate * rate + _TURNOVER * _TURNOVER)


def in_joint(name: str, joint: str, law: Law) -> Described:
    """Return an effect that is a torque between the two bodies of a joint."""
    if joint == "inner":

        def torque(time: float, state: State, values: Values, strength: float) -> tuple[float, float]:
            return law(state[0] - math.pi, state[2], strength), 0.0
    else:

        def torque(time: float, state: State, values: Values, strength: float) -> tuple[float, float]:
            across = law(state[1] - state[0], state[3] - state[2], strength)
            return -across, across

    return Described(name, torque)


def dry(joint: str) -> Described:
    """Coulomb friction."""
    return in_joint("coulomb_friction", joint, lambda _, rate, size: -size * sign(rate))


def stribeck(joint: str, rng: np.random.Generator) -> Described:
    """Coulomb friction that grows as the motion slows down."""
    slow, more = rng.uniform(0.3, 1.5), rng.uniform(0.6, 1.5)

    def law(_: float, rate: float, size: float) -> float:
        return -size * (1.0 + more * math.exp(-((rate / slow) ** 2))) * sign(rate)

    return in_joint("stribeck_friction", joint, law)


def quadratic(joint: str) -> Described:
    """Friction with the square of the joint's speed."""
    return in_joint("quadratic_friction", joint, lambda _, rate, size: -size * rate * abs(rate))


def spring(joint: str, rng: np.random.Generator) -> Described:
    """A cable across the joint, at ease somewhere near hanging."""
    at_ease = rng.uniform(-0.3, 0.3)
    return in_joint("joint_spring", joint, lambda angle, _, size: -size * (angle - at_ease))


def cogging(joint: str, rng: np.random.Generator) -> Described:
    """The detents of a motor."""
    periods, phase = int(rng.integers(3, 17)), rng.uniform(-math.pi, math.pi)
    return in_joint("cogging_torque", joint, lambda angle, _, size: size * math.sin(periods * angle + phase))


def load_friction(joint: str) -> Described:
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

    return Described("load_friction", torque)


def drag(joint: str, rng: np.random.Generator) -> Described:
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

    return Described("air_drag", torque)


def tilt() -> Described:
    """A base that is not level: gravity pulls askew."""

    def torque(time: float, state: State, values: Values, strength: float) -> tuple[float, float]:
        first = values["m1"] * values["l1"] + (values["m2"] + values["m0"]) * values["L"]
        moments = (first * values["g"], values["m2"] * values["l2"] * values["g"])
        turned = [m * (math.sin(a - strength) - math.sin(a)) for m, a in zip(moments, state, strict=False)]
        return turned[0], turned[1]

    return Described("gravity_tilt", torque)


def offset(joint: str) -> Described:
    """An encoder that is off."""
    return _encoder("encoder_offset", joint, lambda angle, time, size: 0.0 * angle + size)


def scale(joint: str) -> Described:
    """An encoder with other counts a turn than thought."""
    return _encoder("encoder_scale", joint, lambda angle, time, size: size * angle)


def eccentricity(joint: str, rng: np.random.Generator) -> Described:
    """An encoder's disc beside its axle."""
    phase = rng.uniform(-math.pi, math.pi)
    return _encoder("encoder_eccentricity", joint, lambda angle, time, size: size * np.sin(angle + phase))


def slip(joint: str, at: float) -> Described:
    """An encoder that misses counts at an instant [s] of one trial."""
    return _encoder("encoder_slip", joint, lambda angle, time, size: np.where(time >= at, size, 0.0))


def late() -> Described:
    """An outer encoder that is read later than the inner one."""

    def reading(times: Array, motion: Motion, values: Values, strength: float) -> Array:
        now, before = motion(times), motion(times - strength)
        return np.stack([np.zeros(len(times)), np.diff(before[:, :2] - now[:, :2], axis=1)[:, 0]], axis=1)

    return Described("time_offset", reading=reading)


def flex() -> Described:
    """An inner rod that the outer one bends. Strength: compliance at its end [m/N].

    A cantilever loaded at its end leaves its chord by a slope of F L^2 / (3 E I) at the root and half of that at the
    end (Euler and Bernoulli); the encoders sit at these.
    """

    def reading(times: Array, motion: Motion, values: Values, strength: float) -> Array:
        states = motion(times)
        theta1, theta2, omega1, omega2 = states.T
        alpha = np.array([accelerations(values, state, 0.0) for state in states])
        along = np.cos(theta1) * values["L"] * alpha[:, 0] - np.sin(theta1) * values["L"] * omega1**2
        along += values["l2"] * (np.cos(theta2) * alpha[:, 1] - np.sin(theta2) * omega2**2)
        up = -np.sin(theta1) * values["L"] * alpha[:, 0] - np.cos(theta1) * values["L"] * omega1**2 + values["g"]
        up -= values["l2"] * (np.sin(theta2) * alpha[:, 1] + np.cos(theta2) * omega2**2)
        across = -values["m2"] * (np.cos(theta1) * along - np.sin(theta1) * up) - values["m0"] * (
            values["L"] * alpha[:, 0] - values["g"] * np.sin(theta1)
        )
        bent = strength / values["L"] * across
        return np.stack([-bent, -0.5 * bent], axis=1)

    return Described("rod_flex", reading=reading)


def backlash(joint: str) -> Described:
    """An encoder whose coupling has play. Strength: half of the play."""

    def play(angle: Array, time: Array, size: float) -> Array:
        shown = np.empty_like(angle)
        last = angle[0]
        for k, now in enumerate(angle):
            last = min(max(last, now - size), now + size)
            shown[k] = last
        return shown - angle

    return _encoder("backlash", joint, play)


def _encoder(name: str, joint: str, added: Callable[[Array, Array, float], Array]) -> Described:
    """Return an effect on one encoder; `added` takes the joint's angle since hanging, the time and the strength."""

    def reading(times: Array, motion: Motion, values: Values, strength: float) -> Array:
        theta = motion(times)[:, :2]
        nothing = np.zeros(len(times))
        if joint == "inner":
            return np.stack([added(theta[:, 0] - math.pi, times, strength), nothing], axis=1)
        return np.stack([nothing, added(theta[:, 1] - theta[:, 0], times, strength)], axis=1)

    return Described(name, reading=reading)

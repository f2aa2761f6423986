# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What can go on in a pendulum beyond the paper's model: the formulas of hidden truths, from the physics.

They are independent of the package's own: dry friction turns over at another width and in another form, drag is summed
over other strips, a knock has another shape. Some of them the package does not know at all.
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
_KNOCK = 0.04
"""Duration of a knock [s]."""
_CART_MASS = 0.6
"""Mass of a compliant base [kg]."""
_CART_DAMPING = 0.2
"""Its damping, relative to the critical one."""


@dataclass(frozen=True)
class HiddenEffect:
    """One effect. Its formulas take the strength, so that the same one can be made weak or strong."""

    name: str
    joint: str
    unit: str
    """Unit of the strength."""
    small: float
    """A strength at which what it does is still in proportion to it."""
    largest: float
    """The largest strength that a rig may have."""
    torque: Callable[[float, State, Values, float], tuple[float, float]] | None = None
    """`(time, state, values, strength)` to the generalised torques on theta1 and theta2 [N m]."""
    reading: Callable[[Array, Motion, Values, float], Array] | None = None
    """`(times, motion, values, strength)` to what is added to the encoders' angles (n, 2) [rad]: inner, outer."""
    compliant: bool = False
    """Whether the cart is held by a spring, of which the strength is the compliance [m/N]."""
    trial: int | None = None
    """For what happens once: in which of the trials."""


def sign(rate: float) -> float:
    """Return the direction of a motion, smooth near rest."""
    return rate / math.sqrt(rate * rate + _TURNOVER * _TURNOVER)


def wrapped(angle: float) -> float:
    """Return an angle in -pi to pi [rad]."""
    return math.remainder(angle, 2.0 * math.pi)


def in_joint(name: str, joint: str, unit: str, small: float, largest: float, law: Law) -> HiddenEffect:
    """Return an effect that is a torque between the two bodies of a joint."""
    if joint == "inner":

        def torque(time: float, state: State, values: Values, strength: float) -> tuple[float, float]:
            return law(state[0] - math.pi, state[2], strength), 0.0
    else:

        def torque(time: float, state: State, values: Values, strength: float) -> tuple[float, float]:
            across = law(state[1] - state[0], state[3] - state[2], strength)
            return -across, across

    return HiddenEffect(name, joint, unit, small, largest, torque)


def dry(joint: str) -> HiddenEffect:
    """Coulomb friction."""
    return in_joint("coulomb_friction", joint, "N m", 1e-5, 0.05, lambda _, rate, size: -size * sign(rate))


def stribeck(joint: str, rng: np.random.Generator) -> HiddenEffect:
    """Coulomb friction that grows as the motion slows down."""
    slow, more = rng.uniform(0.3, 1.5), rng.uniform(0.6, 1.5)

    def law(_: float, rate: float, size: float) -> float:
        return -size * (1.0 + more * math.exp(-((rate / slow) ** 2))) * sign(rate)

    return in_joint("stribeck_friction", joint, "N m", 1e-5, 0.03, law)


def quadratic(joint: str) -> HiddenEffect:
    """Friction with the square of the joint's speed."""
    return in_joint("quadratic_friction", joint, "N m s^2", 1e-7, 2e-3, lambda _, rate, size: -size * rate * abs(rate))


def spring(joint: str, rng: np.random.Generator) -> HiddenEffect:
    """A cable across the joint, at ease somewhere near hanging."""
    at_ease = rng.uniform(-0.3, 0.3)
    return in_joint("joint_spring", joint, "N m/rad", 1e-5, 0.1, lambda angle, _, size: -size * (angle - at_ease))


def cogging(joint: str, rng: np.random.Generator) -> HiddenEffect:
    """The detents of a motor."""
    periods, phase = int(rng.integers(3, 17)), rng.uniform(-math.pi, math.pi)
    return in_joint(
        "cogging_torque", joint, "N m", 1e-5, 0.05, lambda angle, _, size: size * math.sin(periods * angle + phase)
    )


def rub(joint: str, rng: np.random.Generator) -> HiddenEffect:
    """A bearing that rubs over a part of its turn. The package does not know it."""
    middle, half = rng.uniform(-0.8, 0.8), rng.uniform(0.2, 0.5)

    def law(angle: float, rate: float, size: float) -> float:
        beyond = (abs(wrapped(angle - middle)) - half) / 0.05
        return -size * sign(rate) / (1.0 + math.exp(min(beyond, 50.0)))

    return in_joint("partial_rub", joint, "N m", 1e-5, 0.1, law)


def magnet(joint: str, rng: np.random.Generator) -> HiddenEffect:
    """A magnet that the joint is drawn to near hanging. Strength: largest torque."""
    reach, at = rng.uniform(0.08, 0.25), rng.uniform(-0.1, 0.1)

    def law(angle: float, _: float, size: float) -> float:
        away = wrapped(angle - at) / reach
        return -size * away * math.exp(0.5 * (1.0 - away * away))

    return in_joint("magnet", joint, "N m", 1e-5, 0.1, law)


def load_friction(joint: str) -> HiddenEffect:
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

    return HiddenEffect("load_friction", joint, "m", 1e-6, 0.01, torque)


def drag(joint: str, rng: np.random.Generator) -> HiddenEffect:
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

    return HiddenEffect("air_drag", joint, "N m s^2", 1e-7, 2e-3, torque)


def tilt() -> HiddenEffect:
    """A base that is not level: gravity pulls askew."""

    def torque(time: float, state: State, values: Values, strength: float) -> tuple[float, float]:
        first = values["m1"] * values["l1"] + (values["m2"] + values["m0"]) * values["L"]
        moments = (first * values["g"], values["m2"] * values["l2"] * values["g"])
        turned = [m * (math.sin(a - strength) - math.sin(a)) for m, a in zip(moments, state, strict=False)]
        return turned[0], turned[1]

    return HiddenEffect("gravity_tilt", "base", "rad", 1e-5, 0.1, torque)


def knock(joint: str, trial: int, at: float) -> HiddenEffect:
    """A push on one rod that lasts an instant [s] of one trial."""

    def torque(time: float, state: State, values: Values, strength: float) -> tuple[float, float]:
        phase = (time - at) / _KNOCK
        push = strength / _KNOCK * (1.0 - math.cos(2.0 * math.pi * phase)) if 0.0 < phase < 1.0 else 0.0
        return (push, 0.0) if joint == "inner" else (0.0, push)

    return HiddenEffect("impulse", joint, "N m s", 1e-6, 0.05, torque, trial=trial)


def compliance() -> HiddenEffect:
    """A cart that is held by something soft."""
    return HiddenEffect("pivot_compliance", "base", "m/N", 1e-5, 2e-4, compliant=True)


def cart_acceleration(values: Values, state: State, torque: tuple[float, float], compliance: float) -> float:
    """Return the acceleration [m/s^2] of a cart that a spring and a damper hold; state[4:] are its place and speed."""
    theta1, theta2, omega1, omega2, place, speed = state
    rods = values["m1"] + values["m2"] + values["m0"]
    first = values["m1"] * values["l1"] + (values["m2"] + values["m0"]) * values["L"]
    second = values["m2"] * values["l2"]
    angles = np.array(state[:4])

    def momentum_rate(u: float) -> float:
        alpha1, alpha2 = accelerations(values, angles, u, torque)
        return (
            (rods + _CART_MASS) * u
            + first * (alpha1 * math.cos(theta1) - omega1**2 * math.sin(theta1))
            + second * (alpha2 * math.cos(theta2) - omega2**2 * math.sin(theta2))
        )

    still, one = momentum_rate(0.0), momentum_rate(1.0)
    damping = 2.0 * _CART_DAMPING * math.sqrt((rods + _CART_MASS) / compliance)
    return (-place / compliance - damping * speed - still) / (one - still)


def offset(joint: str) -> HiddenEffect:
    """An encoder that is off."""
    return _encoder("encoder_offset", joint, "rad", 1e-5, 0.1, lambda angle, time, size: 0.0 * angle + size)


def scale(joint: str) -> HiddenEffect:
    """An encoder with other counts a turn than thought."""
    return _encoder("encoder_scale", joint, "1", 1e-5, 0.05, lambda angle, time, size: size * angle)


def eccentricity(joint: str, rng: np.random.Generator) -> HiddenEffect:
    """An encoder's disc beside its axle."""
    phase = rng.uniform(-math.pi, math.pi)
    return _encoder(
        "encoder_eccentricity", joint, "rad", 1e-5, 0.05, lambda angle, time, size: size * np.sin(angle + phase)
    )


def slip(joint: str, trial: int, at: float) -> HiddenEffect:
    """An encoder that misses counts at an instant [s] of one trial."""
    return _encoder(
        "encoder_slip", joint, "rad", 1e-5, 0.2, lambda angle, time, size: np.where(time >= at, size, 0.0), trial
    )


def late() -> HiddenEffect:
    """An outer encoder that is read later than the inner one."""

    def reading(times: Array, motion: Motion, values: Values, strength: float) -> Array:
        now, before = motion(times), motion(times - strength)
        return np.stack([np.zeros(len(times)), np.diff(before[:, :2] - now[:, :2], axis=1)[:, 0]], axis=1)

    return HiddenEffect("time_offset", "outer", "s", 1e-5, 0.02, reading=reading)


def flex() -> HiddenEffect:
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

    return HiddenEffect("rod_flex", "inner", "m/N", 1e-6, 5e-3, reading=reading)


def backlash(joint: str) -> HiddenEffect:
    """An encoder whose coupling has play. Strength: half of the play."""

    def play(angle: Array, time: Array, size: float) -> Array:
        shown = np.empty_like(angle)
        last = angle[0]
        for k, now in enumerate(angle):
            last = min(max(last, now - size), now + size)
            shown[k] = last
        return shown - angle

    return _encoder("backlash", joint, "rad", 1e-5, 0.05, play)


def _encoder(
    name: str,
    joint: str,
    unit: str,
    small: float,
    largest: float,
    added: Callable[[Array, Array, float], Array],
    trial: int | None = None,
) -> HiddenEffect:
    """Return an effect on one encoder; `added` takes the joint's angle since hanging, the time and the strength."""

    def reading(times: Array, motion: Motion, values: Values, strength: float) -> Array:
        theta = motion(times)[:, :2]
        nothing = np.zeros(len(times))
        if joint == "inner":
            return np.stack([added(theta[:, 0] - math.pi, times, strength), nothing], axis=1)
        return np.stack([nothing, added(theta[:, 1] - theta[:, 0], times, strength)], axis=1)

    return HiddenEffect(name, joint, unit, small, largest, reading=reading, trial=trial)

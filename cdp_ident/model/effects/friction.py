"""Friction in the joints beyond the paper's viscous kind. It acts against the joint's relative motion."""

import math
from dataclasses import replace

from cdp_ident.model.compilation import Compilable, inlined, part
from cdp_ident.model.effects.effect import EffectParameter, Joint, TorqueEffect
from cdp_ident.model.equations import accelerations

SMOOTHING = 0.02
"""Dry friction changes sign as tanh(speed / SMOOTHING) [rad/s]: smooth near rest, full at a fiftieth of a radian a
second, and not too stiff for the integrator's step."""


@inlined
def _direction(rate):
    return math.tanh(rate / SMOOTHING)


@part
def _coulomb_inner(theta1, theta2, omega1, omega2, time, values, row, constants):
    return -values[row, 0] * _direction(omega1), 0.0


@part
def _coulomb_outer(theta1, theta2, omega1, omega2, time, values, row, constants):
    torque = -values[row, 0] * _direction(omega2 - omega1)
    return -torque, torque


@inlined
def _stribeck(rate, values, row):
    near_rest = math.exp(-((rate / values[row, 2]) ** 2))
    return -(values[row, 0] + values[row, 1] * near_rest) * _direction(rate)


@part
def _stribeck_inner(theta1, theta2, omega1, omega2, time, values, row, constants):
    return _stribeck(omega1, values, row), 0.0


@part
def _stribeck_outer(theta1, theta2, omega1, omega2, time, values, row, constants):
    torque = _stribeck(omega2 - omega1, values, row)
    return -torque, torque


@inlined
def _uneven(angle, rate, values, row):
    return -(values[row, 0] * math.sin(angle) + values[row, 1] * math.cos(angle)) * _direction(rate)


@part
def _uneven_inner(theta1, theta2, omega1, omega2, time, values, row, constants):
    return _uneven(theta1 - math.pi, omega1, values, row), 0.0


@part
def _uneven_outer(theta1, theta2, omega1, omega2, time, values, row, constants):
    torque = _uneven(theta2 - theta1, omega2 - omega1, values, row)
    return -torque, torque


@part
def _quadratic_inner(theta1, theta2, omega1, omega2, time, values, row, constants):
    return -values[row, 0] * omega1 * abs(omega1), 0.0


@part
def _quadratic_outer(theta1, theta2, omega1, omega2, time, values, row, constants):
    rate = omega2 - omega1
    torque = -values[row, 0] * rate * abs(rate)
    return -torque, torque


@inlined
def _load(theta1, theta2, omega1, omega2, constants, mass, inner_moment, outer_moment):
    """Return the size of a bearing's load over A22, from the mass and first moments that it carries.

    Its acceleration is that of the paper's model: friction changes the load too little to matter to itself.
    """
    A23, A33, a1, c1, c2, m2_l2, g = (
        constants[0], constants[1], constants[2], constants[3], constants[4], constants[5], constants[6],
    )  # fmt: skip
    alpha1, alpha2 = accelerations(theta1, theta2, omega1, omega2, 0.0, A23, A33, a1, c1, c2, m2_l2, g)
    sin1, cos1, sin2, cos2 = math.sin(theta1), math.cos(theta1), math.sin(theta2), math.cos(theta2)
    inward1, inward2 = omega1 * omega1, omega2 * omega2
    across = inner_moment * (cos1 * alpha1 - sin1 * inward1) + outer_moment * (cos2 * alpha2 - sin2 * inward2)
    up = mass * g - inner_moment * (sin1 * alpha1 + cos1 * inward1) - outer_moment * (sin2 * alpha2 + cos2 * inward2)
    return math.sqrt(across * across + up * up)


@part
def _load_inner(theta1, theta2, omega1, omega2, time, values, row, constants):
    load = _load(theta1, theta2, omega1, omega2, constants, values[row, 1], constants[2], constants[5])
    return -values[row, 0] * load * _direction(omega1), 0.0


@part
def _load_outer(theta1, theta2, omega1, omega2, time, values, row, constants):
    mass = values[row, 1]
    # The outer rod hangs on a point that moves on a circle of radius L = A23 / (m2 l2).
    carried = mass * constants[0] / constants[5]
    load = _load(theta1, theta2, omega1, omega2, constants, mass, carried, constants[5])
    torque = -values[row, 0] * load * _direction(omega2 - omega1)
    return -torque, torque


def _both(
    name: str,
    description: str,
    formula: str,
    source: str,
    parameters: tuple[EffectParameter, ...],
    inner: Compilable,
    outer: Compilable,
    contains: str = "",
) -> tuple[TorqueEffect, ...]:
    joints: tuple[tuple[Joint, Compilable], ...] = (("inner", inner), ("outer", outer))
    return tuple(
        TorqueEffect(name, joint, "", description, formula, source, parameters, torque, linear=False, contains=contains)
        for joint, torque in joints
    )


def _torque(name: str, typical: float) -> EffectParameter:
    return EffectParameter(name, "N m", 0.0, 20.0, typical, inertia_power=1)


_LOADED: tuple[tuple[Joint, float, Compilable], ...] = (("inner", 7.0, _load_inner), ("outer", 2.0, _load_outer))

FRICTION: tuple[TorqueEffect, ...] = (
    *_both(
        "coulomb_friction",
        "dry friction",
        f"-torque tanh(speed / {SMOOTHING} rad/s)",
        "Coulomb, 1785; smoothed as in Armstrong-Helouvry et al., Automatica 30, 1994",
        (_torque("torque", 0.05),),
        _coulomb_inner,
        _coulomb_outer,
    ),
    *_both(
        "stribeck_friction",
        "dry friction that is larger near rest",
        f"-(torque + extra exp(-(speed / stribeck_speed)^2)) tanh(speed / {SMOOTHING} rad/s)",
        "Stribeck, 1902; in the form of Armstrong-Helouvry et al., Automatica 30, 1994",
        (
            _torque("torque", 0.05),
            _torque("extra", 0.05),
            EffectParameter("stribeck_speed", "rad/s", 0.1, 5.0, 0.5, shape=True),
        ),
        _stribeck_inner,
        _stribeck_outer,
        contains="coulomb_friction",
    ),
    *_both(
        "quadratic_friction",
        "friction that grows with the square of the joint's speed",
        "-coefficient speed |speed|",
        "turbulent lubricant or fan drag of the joint: White, Fluid Mechanics, 2011",
        (EffectParameter("coefficient", "N m s^2", 0.0, 2.0, 0.005, inertia_power=1),),
        _quadratic_inner,
        _quadratic_outer,
    ),
    *(
        TorqueEffect(
            "load_friction",
            joint,
            "",
            "dry friction that grows with the bearing's load",
            f"-lever |load| tanh(speed / {SMOOTHING} rad/s), the load from the constraint forces",
            "Coulomb friction in a loaded bearing: SKF, Rolling Bearings, 2018",
            (
                EffectParameter("lever", "m", 0.0, 0.05, 1e-3),
                # What hangs on the bearing; no zero-input motion of the paper's model shows a mass by itself.
                EffectParameter("mass", "kg", 0.01, 1000.0, mass, inertia_power=1, shape=True),
            ),
            torque,
            linear=False,
        )
        for joint, mass, torque in _LOADED
    ),
)

_VARIATION = EffectParameter("sine", "N m", -20.0, 20.0, 0.0, inertia_power=1)
UNEVENNESS: tuple[TorqueEffect, ...] = _both(
    "uneven_friction",
    "what dry friction varies by over a turn",
    f"-(sine sin(angle) + cosine cos(angle)) tanh(speed / {SMOOTHING} rad/s), angles of the joint from hanging",
    "position-dependent friction: Armstrong-Helouvry, Control of Machines with Friction, 1991; its first harmonic",
    (_VARIATION, replace(_VARIATION, name="cosine")),
    _uneven_inner,
    _uneven_outer,
)
"""No effect by itself, for it would feed energy in where it is negative: it shows whether dry friction is even."""

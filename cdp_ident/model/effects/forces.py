"""Forces on the rods and torques in the joints other than friction: the air, springs, cogging, knocks."""

import math

import numpy as np

from cdp_ident.model.compilation import Compilable, inlined, part
from cdp_ident.model.effects.constants import LENGTH, OUTER_LENGTH
from cdp_ident.model.effects.effect import EffectParameter, Joint, TorqueEffect
from cdp_ident.model.equations import accelerations

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)
_STRIPS = tuple(float(node) for node in 0.5 * (_NODES + 1.0))
_SHARES = tuple(float(weight) for weight in 0.5 * _WEIGHTS)
"""Gauss-Legendre quadrature along a rod of unit length."""
_AHEAD = 2e-3
"""Step of the differences along the motion [s]."""
_KNOCK = 0.01
"""Standard deviation in time of a knock [s]."""
COGGING_PERIODS = tuple(range(2, 17))
"""How often in a turn a cogging torque may repeat. Once a turn is an unbalance, which gravity's terms hold already."""


@part
def _drag_inner(theta1, theta2, omega1, omega2, time, values, row, constants):
    return -values[row, 0] * omega1 * abs(omega1), 0.0


@part
def _drag_outer_strips(theta1, theta2, omega1, omega2, time, values, row, constants):
    # Across the outer rod, its lower joint carries it along at L omega1 cos(theta1 - theta2).
    lever = constants[LENGTH] * math.cos(theta1 - theta2) / (values[row, 1] * constants[OUTER_LENGTH])
    carried = lever * omega1
    torque1, torque2 = 0.0, 0.0
    for k in range(len(_STRIPS)):
        speed = carried + _STRIPS[k] * omega2
        # Four times the mean over strips gives -coefficient omega2 |omega2| where the joint is at rest.
        force = -4.0 * _SHARES[k] * values[row, 0] * speed * abs(speed)
        torque1 += lever * force
        torque2 += _STRIPS[k] * force
    return torque1, torque2


@part
def _drag_outer_rotation(theta1, theta2, omega1, omega2, time, values, row, constants):
    return 0.0, -values[row, 0] * omega2 * abs(omega2)


@part
def _spring_inner(theta1, theta2, omega1, omega2, time, values, row, constants):
    return values[row, 1] - values[row, 0] * (theta1 - math.pi), 0.0


@part
def _spring_outer(theta1, theta2, omega1, omega2, time, values, row, constants):
    torque = values[row, 1] - values[row, 0] * (theta2 - theta1)
    return -torque, torque


@part
def _cogging_inner(theta1, theta2, omega1, omega2, time, values, row, constants):
    angle = values[row, 2] * theta1
    return values[row, 0] * math.sin(angle) + values[row, 1] * math.cos(angle), 0.0


@part
def _cogging_outer(theta1, theta2, omega1, omega2, time, values, row, constants):
    angle = values[row, 2] * (theta2 - theta1)
    torque = values[row, 0] * math.sin(angle) + values[row, 1] * math.cos(angle)
    return -torque, torque


@part
def _tilt(theta1, theta2, omega1, omega2, time, values, row, constants):
    tilt, a1, m2_l2, g = values[row, 0], constants[2], constants[5], constants[6]
    return (
        a1 * g * (math.sin(theta1 - tilt) - math.sin(theta1)),
        m2_l2 * g * (math.sin(theta2 - tilt) - math.sin(theta2)),
    )


@part
def _pivot(theta1, theta2, omega1, omega2, time, values, row, constants):
    # The pivot moves by -compliance times the rods' horizontal pull, whose second derivative along the motion is
    # taken by differences; as the rods see it, that is the cart's acceleration.
    compliance, a1, m2_l2 = values[row, 0], constants[2], constants[5]
    if compliance == 0.0:
        return 0.0, 0.0
    alpha1, alpha2 = _paper_accelerations(theta1, theta2, omega1, omega2, constants)
    jerk1, jerk2, changes = 0.0, 0.0, 0.0
    at_rest = _pull(theta1, theta2, omega1, omega2, alpha1, alpha2, a1, m2_l2)
    for _ in range(2):
        speeding1, speeding2, changes = 0.0, 0.0, -2.0 * at_rest
        for direction in range(-1, 2, 2):
            e = direction * _AHEAD
            angle1 = theta1 + e * (omega1 + 0.5 * e * alpha1)
            angle2 = theta2 + e * (omega2 + 0.5 * e * alpha2)
            rate1 = omega1 + e * (alpha1 + 0.5 * e * jerk1)
            rate2 = omega2 + e * (alpha2 + 0.5 * e * jerk2)
            beta1, beta2 = _paper_accelerations(angle1, angle2, rate1, rate2, constants)
            speeding1 += direction * beta1
            speeding2 += direction * beta2
            changes += _pull(angle1, angle2, rate1, rate2, beta1, beta2, a1, m2_l2)
        jerk1, jerk2 = 0.5 * speeding1 / _AHEAD, 0.5 * speeding2 / _AHEAD
    u = -compliance * changes / (_AHEAD * _AHEAD)
    return -a1 * math.cos(theta1) * u, -m2_l2 * math.cos(theta2) * u


@inlined
def _paper_accelerations(theta1, theta2, omega1, omega2, constants):
    return accelerations(
        theta1, theta2, omega1, omega2, 0.0,
        constants[0], constants[1], constants[2], constants[3], constants[4], constants[5], constants[6],
    )  # fmt: skip


@inlined
def _pull(theta1, theta2, omega1, omega2, alpha1, alpha2, a1, m2_l2):
    """Return the rate of change of the rods' horizontal momentum over A22 [m/s^2 / m]."""
    return a1 * (math.cos(theta1) * alpha1 - math.sin(theta1) * omega1 * omega1) + m2_l2 * (
        math.cos(theta2) * alpha2 - math.sin(theta2) * omega2 * omega2
    )


@part
def _knock_inner(theta1, theta2, omega1, omega2, time, values, row, constants):
    late = (time - values[row, 1]) / _KNOCK
    return values[row, 0] * math.exp(-0.5 * late * late) / (_KNOCK * math.sqrt(2.0 * math.pi)), 0.0


@part
def _knock_outer(theta1, theta2, omega1, omega2, time, values, row, constants):
    late = (time - values[row, 1]) / _KNOCK
    return 0.0, values[row, 0] * math.exp(-0.5 * late * late) / (_KNOCK * math.sqrt(2.0 * math.pi))


_COGGING: tuple[tuple[Joint, Compilable], ...] = (("inner", _cogging_inner), ("outer", _cogging_outer))


def _cogging(periods: int) -> tuple[TorqueEffect, ...]:
    return tuple(
        TorqueEffect(
            "cogging_torque",
            joint,
            f"{periods} per turn",
            f"a torque that repeats {periods} times a turn",
            "sine sin(periods angle) + cosine cos(periods angle)",
            "detent torque of a motor or a magnet ring: Hendershot and Miller, 1994",
            (
                EffectParameter("sine", "N m", -20.0, 20.0, 0.05, inertia_power=1),
                EffectParameter("cosine", "N m", -20.0, 20.0, 0.05, inertia_power=1),
                EffectParameter("periods", "1", float(periods), float(periods), float(periods)),
            ),
            torque,
            harmonic=True,
        )
        for joint, torque in _COGGING
    )


_DRAG = EffectParameter("coefficient", "N m s^2", 0.0, 2.0, 0.005, inertia_power=1)
# No length of the outer rod is in the paper's model; where its centre of mass is does not tell where it ends.
_LENGTH_RATIO = EffectParameter("length_ratio", "1", 0.3, 3.0, 1.0, shape=True, optional=True)
_DRAG_SOURCE = "drag of a cylinder across a flow: Hoerner, Fluid-Dynamic Drag, 1965"
_SPRING = (
    EffectParameter("stiffness", "N m/rad", 0.0, 100.0, 0.1, inertia_power=1),
    EffectParameter("torque", "N m", -20.0, 20.0, 0.01, inertia_power=1),
)
_SPRING_SOURCE = "Hooke; a cable across the joint or a seal that does not slip"
_IMPULSE = (
    EffectParameter("impulse", "N m s", -50.0, 50.0, 0.05, inertia_power=1),
    EffectParameter("time", "s", 0.0, math.inf, 0.0, shape=True),
)
_IMPULSE_FORMULA = f"a torque pulse about `time`, of {_KNOCK} s standard deviation, whose integral is `impulse`"

FORCES: tuple[TorqueEffect, ...] = (
    TorqueEffect(
        "air_drag", "inner", "", "air drag on the rod", "-coefficient omega1 |omega1|", _DRAG_SOURCE, (_DRAG,),
        _drag_inner, linear=False,
    ),
    TorqueEffect(
        "air_drag", "outer", "strips", "air drag on the rod",
        "force across each strip of the rod -v |v|, v the strip's absolute speed; coefficient as for rotation alone; "
        "what the air acts on is length_ratio times as long as the rod is taken to be",
        f"strip theory; {_DRAG_SOURCE}", (_DRAG, _LENGTH_RATIO), _drag_outer_strips, linear=False,
    ),
    TorqueEffect(
        "air_drag", "outer", "rotation", "air drag on the rod", "-coefficient omega2 |omega2|", _DRAG_SOURCE, (_DRAG,),
        _drag_outer_rotation, linear=False,
    ),
    TorqueEffect(
        "joint_spring", "inner", "", "a spring across the joint", "torque - stiffness (theta1 - pi)", _SPRING_SOURCE,
        _SPRING, _spring_inner,
    ),
    TorqueEffect(
        "joint_spring", "outer", "", "a spring across the joint", "torque - stiffness (theta2 - theta1)",
        _SPRING_SOURCE, _SPRING, _spring_outer,
    ),
    TorqueEffect(
        "gravity_tilt", "base", "", "a base that is not level", "gravity acts along theta = tilt",
        "statics; the same motion as with an inner encoder that is off by the tilt",
        (EffectParameter("tilt", "rad", -0.3, 0.3, 0.01),), _tilt,
    ),
    TorqueEffect(
        "pivot_compliance", "base", "", "a cart that gives way", "x = -compliance times the rods' horizontal pull",
        "quasi-static elasticity: valid while the cart's own oscillation is much faster than the swing",
        (EffectParameter("compliance", "m/N", 0.0, 2e-3, 1e-5, inertia_power=-1),), _pivot,
    ),
    *(effect for periods in COGGING_PERIODS for effect in _cogging(periods)),
    TorqueEffect(
        "impulse", "inner", "", "a knock on the rod", _IMPULSE_FORMULA, "", _IMPULSE, _knock_inner, at_an_instant=True,
        linear=False,
    ),
    TorqueEffect(
        "impulse", "outer", "", "a knock on the rod", _IMPULSE_FORMULA, "", _IMPULSE, _knock_outer, at_an_instant=True,
        linear=False,
    ),
)  # fmt: skip

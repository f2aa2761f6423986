"""Forces on the rods and torques in the joints other than friction: the air, springs, cogging, impulses."""

import math
from dataclasses import replace

import numpy as np

from cdp_ident.model.compilation import inlined, part
from cdp_ident.model.effects.constants import LENGTH, OUTER_LENGTH
from cdp_ident.model.effects.effect import (
    JOINTS,
    NOT_BY_ANY,
    NOT_BY_COEFFICIENTS,
    NOT_BY_STATE,
    EffectParameter,
    Form,
    TorqueEffect,
)
from cdp_ident.model.equations import accelerations, sine_and_cosine, sines_and_cosines

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)
_STRIPS = tuple((0.5 * (float(node) + 1.0), 0.5 * float(weight)) for node, weight in zip(_NODES, _WEIGHTS, strict=True))
"""Gauss-Legendre quadrature along a rod of unit length: strips, and their shares."""
_AHEAD = 2e-3
"""Step of the differences along the motion [s]."""
_NUDGE = 1e-5
"""Step of the differences of the pull's acceleration [rad], [rad/s]."""
_PULSE = 0.01
"""Standard deviation in time of an impulse [s]."""
COGGING_PERIODS = tuple(range(2, 17))
"""How often in a turn a cogging torque may repeat. Once a turn is an unbalance, which gravity's terms hold already."""


@inlined
def _drag_inner(state, turned, time, parameters, constants):
    size, speed = parameters[0], state[2]
    squared = -speed * abs(speed)
    x = (0.0, 0.0, -2.0 * size * abs(speed), 0.0)
    return (
        size * squared, 0.0, x, NOT_BY_STATE, NOT_BY_COEFFICIENTS, NOT_BY_COEFFICIENTS, (squared, 0.0, 0.0), NOT_BY_ANY,
    )  # fmt: skip


@inlined
def _drag_outer_strips(state, turned, time, parameters, constants):
    # Across the outer rod, its lower joint carries it along at L omega1 cos(theta1 - theta2).
    size, ratio, _ = parameters
    _, _, omega1, omega2 = state
    reach = constants[LENGTH] / (ratio * constants[OUTER_LENGTH])
    sin1, cos1, sin2, cos2 = turned
    lever, lever_turns = reach * (cos1 * cos2 + sin1 * sin2), -reach * (sin1 * cos2 - cos1 * sin2)
    # Sums over the strips of the force, of its derivative by a strip's speed (steepness), and of their moments.
    unit, moment, steepness, first, second = 0.0, 0.0, 0.0, 0.0, 0.0
    for strip, share in _STRIPS:
        speed = lever * omega1 + strip * omega2
        # Four times the mean over strips gives -coefficient omega2 |omega2| where the joint is at rest.
        weight = -4.0 * share * abs(speed)
        unit += weight * speed
        moment += strip * weight * speed
        steepness += 2.0 * weight
        first += 2.0 * strip * weight
        second += 2.0 * strip * strip * weight
    by_lever1, by_lever2 = size * (unit + lever * steepness * omega1), size * first * omega1
    turns1, turns2, across = lever_turns * by_lever1, lever_turns * by_lever2, size * lever * first
    return (
        size * lever * unit, size * moment,
        (turns1, -turns1, size * lever * lever * steepness, across), (turns2, -turns2, across, size * second),
        NOT_BY_COEFFICIENTS, NOT_BY_COEFFICIENTS,
        (lever * unit, -lever / ratio * by_lever1, 0.0), (moment, -lever / ratio * by_lever2, 0.0),
    )  # fmt: skip


@inlined
def _drag_outer_rotation(state, turned, time, parameters, constants):
    size, speed = parameters[0], state[3]
    squared = -speed * abs(speed)
    y = (0.0, 0.0, 0.0, -2.0 * size * abs(speed))
    return (
        0.0, size * squared, NOT_BY_STATE, y, NOT_BY_COEFFICIENTS, NOT_BY_COEFFICIENTS, NOT_BY_ANY, (squared, 0.0, 0.0),
    )  # fmt: skip


@inlined
def _spring(angle, speed, parameters):
    stiffness, torque, _ = parameters
    return torque - stiffness * angle, -stiffness, 0.0, (-angle, 1.0, 0.0)


@inlined
def _cogging(angle, speed, parameters):
    of_sine, of_cosine, periods = parameters
    sine, cosine = sine_and_cosine(periods * angle)
    # The number of periods is given, not fitted.
    slope = periods * (of_sine * cosine - of_cosine * sine)
    return of_sine * sine + of_cosine * cosine, slope, 0.0, (sine, cosine, 0.0)


@inlined
def _tilt(state, turned, time, parameters, constants):
    tilt, a1, m2_l2, g = parameters[0], constants[2], constants[5], constants[6]
    sin1, cos1, sin2, cos2 = turned
    sine, cosine = sine_and_cosine(tilt)
    level = 2.0 * sine_and_cosine(0.5 * tilt)[0] ** 2  # 1 - cosine, without a difference
    cosine1, cosine2 = cos1 * cosine + sin1 * sine, cos2 * cosine + sin2 * sine
    sine1, sine2 = -sin1 * level - cos1 * sine, -sin2 * level - cos2 * sine
    return (
        a1 * g * sine1, m2_l2 * g * sine2,
        (a1 * g * (cosine1 - cos1), 0.0, 0.0, 0.0), (0.0, m2_l2 * g * (cosine2 - cos2), 0.0, 0.0),
        (0.0, 0.0, g * sine1, 0.0, 0.0, 0.0, a1 * sine1), (0.0, 0.0, 0.0, 0.0, 0.0, g * sine2, m2_l2 * sine2),
        (-a1 * g * cosine1, 0.0, 0.0), (-m2_l2 * g * cosine2, 0.0, 0.0),
    )  # fmt: skip


@inlined
def _quasi_static_base(state, turned, time, parameters, constants):
    compliance, a1, m2_l2 = parameters[0], constants[2], constants[5]
    theta1, theta2, omega1, omega2 = state
    u = _acceleration_of_pull(theta1, theta2, omega1, omega2, constants)
    sin1, cos1, sin2, cos2 = turned
    cosine1, cosine2 = a1 * cos1, m2_l2 * cos2
    scale = 0.5 * compliance / _NUDGE
    by_theta1 = scale * (
        _acceleration_of_pull(theta1 + _NUDGE, theta2, omega1, omega2, constants)
        - _acceleration_of_pull(theta1 - _NUDGE, theta2, omega1, omega2, constants)
    )
    by_theta2 = scale * (
        _acceleration_of_pull(theta1, theta2 + _NUDGE, omega1, omega2, constants)
        - _acceleration_of_pull(theta1, theta2 - _NUDGE, omega1, omega2, constants)
    )
    by_omega1 = scale * (
        _acceleration_of_pull(theta1, theta2, omega1 + _NUDGE, omega2, constants)
        - _acceleration_of_pull(theta1, theta2, omega1 - _NUDGE, omega2, constants)
    )
    by_omega2 = scale * (
        _acceleration_of_pull(theta1, theta2, omega1, omega2 + _NUDGE, constants)
        - _acceleration_of_pull(theta1, theta2, omega1, omega2 - _NUDGE, constants)
    )
    along = compliance * u
    return (
        cosine1 * along, cosine2 * along,
        (cosine1 * by_theta1 - a1 * sin1 * along, cosine1 * by_theta2, cosine1 * by_omega1, cosine1 * by_omega2),
        (cosine2 * by_theta1, cosine2 * by_theta2 - m2_l2 * sin2 * along, cosine2 * by_omega1, cosine2 * by_omega2),
        (0.0, 0.0, cos1 * along, 0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0, 0.0, cos2 * along, 0.0),
        (cosine1 * u, 0.0, 0.0), (cosine2 * u, 0.0, 0.0),
    )  # fmt: skip


@part
def _acceleration_of_pull(theta1, theta2, omega1, omega2, constants):
    """Return the second derivative of the rods' horizontal pull along the paper's motion, by differences.

    The base moves by minus compliance times the pull; as the rods see it, that is an acceleration of the cart.
    """
    turned = sines_and_cosines(theta1, theta2)
    alpha1, alpha2 = _paper_accelerations(turned, omega1, omega2, constants)
    speeding, half = 2.0 * _AHEAD, 0.5 * _AHEAD * _AHEAD
    angle1, angle2 = theta1 + half * alpha1, theta2 + half * alpha2
    before = sines_and_cosines(angle1 - _AHEAD * omega1, angle2 - _AHEAD * omega2)
    after = sines_and_cosines(angle1 + _AHEAD * omega1, angle2 + _AHEAD * omega2)
    old1, old2 = omega1 - _AHEAD * alpha1, omega2 - _AHEAD * alpha2
    new1, new2 = omega1 + _AHEAD * alpha1, omega2 + _AHEAD * alpha2
    # The speeds' curvature is that of the accelerations without it.
    first1, first2 = _paper_accelerations(before, old1, old2, constants)
    last1, last2 = _paper_accelerations(after, new1, new2, constants)
    bend1, bend2 = half * (last1 - first1) / speeding, half * (last2 - first2) / speeding
    pulls = _pull(before, old1 + bend1, old2 + bend2, constants) + _pull(after, new1 + bend1, new2 + bend2, constants)
    return (pulls - 2.0 * _pull(turned, omega1, omega2, constants)) / (_AHEAD * _AHEAD)


@inlined
def _paper_accelerations(turned, omega1, omega2, constants):
    return accelerations(
        turned, omega1, omega2, 0.0,
        constants[0], constants[1], constants[2], constants[3], constants[4], constants[5], constants[6],
    )  # fmt: skip


@inlined
def _pull(turned, omega1, omega2, constants):
    """Return the rate of change of the rods' horizontal momentum over A22 [m/s^2 / m]."""
    sin1, cos1, sin2, cos2 = turned
    alpha1, alpha2 = _paper_accelerations(turned, omega1, omega2, constants)
    inner, outer = cos1 * alpha1 - sin1 * omega1 * omega1, cos2 * alpha2 - sin2 * omega2 * omega2
    return constants[2] * inner + constants[5] * outer


@inlined
def _bell(time, parameters):
    """Return an impulse's torque, and its derivatives by the impulse and by the instant."""
    impulse, at, _ = parameters
    late = (time - at) / _PULSE
    bell = math.exp(-0.5 * late * late) / (_PULSE * math.sqrt(2.0 * math.pi))
    return impulse * bell, (bell, impulse * bell * late / _PULSE, 0.0)


@inlined
def _impulse_inner(state, turned, time, parameters, constants):
    torque, slopes = _bell(time, parameters)
    return (
        torque, 0.0, NOT_BY_STATE, NOT_BY_STATE, NOT_BY_COEFFICIENTS, NOT_BY_COEFFICIENTS, slopes, NOT_BY_ANY,
    )  # fmt: skip


@inlined
def _impulse_outer(state, turned, time, parameters, constants):
    torque, slopes = _bell(time, parameters)
    return (
        0.0, torque, NOT_BY_STATE, NOT_BY_STATE, NOT_BY_COEFFICIENTS, NOT_BY_COEFFICIENTS, NOT_BY_ANY, slopes,
    )  # fmt: skip


def _cogging_of(periods: int) -> tuple[TorqueEffect, ...]:
    return tuple(
        TorqueEffect(
            "cogging_torque",
            joint,
            f"{periods} per turn",
            f"a torque that repeats {periods} times a turn",
            "sine sin(periods angle) + cosine cos(periods angle), angles of the joint from hanging",
            "detent torque of a motor or a magnet ring: Hendershot and Miller, 1994",
            (
                EffectParameter("sine", "N m", -200.0, 200.0, 0.05, inertia_power=1),
                EffectParameter("cosine", "N m", -200.0, 200.0, 0.05, inertia_power=1),
                EffectParameter("periods", "1", float(periods), float(periods), float(periods)),
            ),
            _cogging,
            harmonic=True,
        )
        for joint in JOINTS
    )


_DRAG = EffectParameter("coefficient", "N m s^2", 0.0, 2.0, 0.005, inertia_power=1)
# No length of the outer rod is in the paper's model; its centre of mass does not determine where it ends.
_LENGTH_RATIO = EffectParameter("length_ratio", "1", 0.3, 3.0, 1.0, shape=True, optional=True)
_DRAG_SOURCE = "drag of a cylinder across a flow: Hoerner, Fluid-Dynamic Drag, 1965"
_SPRING = (
    EffectParameter("stiffness", "N m/rad", 0.0, 1000.0, 0.1, inertia_power=1),
    EffectParameter("torque", "N m", -200.0, 200.0, 0.01, inertia_power=1),
)
_IMPULSE = (
    EffectParameter("impulse", "N m s", -50.0, 50.0, 0.05, inertia_power=1),
    EffectParameter("time", "s", 0.0, math.inf, 0.0, shape=True),
)
_IMPULSE_FORMULA = f"a torque pulse about `time`, of {_PULSE} s standard deviation, whose integral is `impulse`"
_COMPLIANCE = EffectParameter("compliance", "m/N", 0.0, 1e-2, 1e-5, inertia_power=-1)

FORCES: tuple[TorqueEffect, ...] = (
    TorqueEffect(
        "air_drag", "inner", "", "air drag on the rod", "-coefficient omega1 |omega1|", _DRAG_SOURCE, (_DRAG,),
        _drag_inner, Form.RODS, linear=False,
    ),
    TorqueEffect(
        "air_drag", "outer", "strips", "air drag on the rod",
        "force across each strip of the rod -v |v|, v the strip's absolute speed; coefficient as for rotation alone; "
        "what the air acts on is length_ratio times as long as the rod is taken to be",
        f"strip theory; {_DRAG_SOURCE}", (_DRAG, _LENGTH_RATIO), _drag_outer_strips, Form.RODS, linear=False,
    ),
    TorqueEffect(
        "air_drag", "outer", "rotation", "air drag on the rod", "-coefficient omega2 |omega2|", _DRAG_SOURCE, (_DRAG,),
        _drag_outer_rotation, Form.RODS, linear=False,
    ),
    *(
        TorqueEffect(
            "joint_spring", joint, "", "a spring across the joint", "torque - stiffness angle, angle from hanging",
            "Hooke; a cable across the joint or a seal that does not slip", _SPRING, _spring, in_balance=True,
        )
        for joint in JOINTS
    ),
    TorqueEffect(
        "gravity_tilt", "base", "", "a base that is not level", "gravity acts along theta = tilt",
        "statics; the same motion as with an inner encoder that is off by the tilt",
        (EffectParameter("tilt", "rad", -0.3, 0.3, 0.01),), _tilt, Form.RODS, acts_as_zero=True,
    ),
    TorqueEffect(
        "pivot_compliance", "base", "", "a cart that gives way", "x = -compliance times the rods' horizontal pull",
        "quasi-static elasticity: valid while the cart's own oscillation is much faster than the swing",
        (_COMPLIANCE,), _quasi_static_base, Form.RODS,
    ),
    TorqueEffect(
        "pivot_compliance", "base", "oscillating", "a cart that gives way and swings by itself",
        "x'' + 2 damping_ratio natural_frequency x' + natural_frequency^2 x = "
        "-compliance natural_frequency^2 (the rods' horizontal pull); "
        "1 / (compliance natural_frequency^2) is the mass of what moves along: cart, rods and all",
        "oscillator with one degree of freedom: Den Hartog, Mechanical Vibrations, 1956",
        (
            replace(_COMPLIANCE, upper=10.0),
            EffectParameter("natural_frequency", "rad/s", 0.3, 1000.0, 15.0, shape=True),
            EffectParameter("damping_ratio", "1", 0.0, 5.0, 0.05, shape=True),
        ), None, Form.BASE, states=2, contains="pivot_compliance",
    ),
    *(effect for periods in COGGING_PERIODS for effect in _cogging_of(periods)),
    TorqueEffect(
        "geared_rotor", "outer", "", "the rotor of a geared drive",
        "inertia between the rods A23 cos(theta1 - theta2) + coupling; for a rotor of inertia J that turns n times as "
        "fast as the joint, coupling = J n (1 - n), and the rest of its inertia is in that of the rods",
        "kinetic energy of a rotor at the speed omega1 + n (omega2 - omega1): Siciliano et al., Robotics, 2009, 7.2",
        (EffectParameter("coupling", "kg m^2", -0.9, 0.9, -0.02, inertia_power=1),), None, Form.COUPLING,
        in_balance=True,
    ),
    TorqueEffect(
        "impulse", "inner", "", "an impulse on the rod", _IMPULSE_FORMULA, "", _IMPULSE, _impulse_inner, Form.RODS,
        at_an_instant=True, linear=False,
    ),
    TorqueEffect(
        "impulse", "outer", "", "an impulse on the rod", _IMPULSE_FORMULA, "", _IMPULSE, _impulse_outer, Form.RODS,
        at_an_instant=True, linear=False,
    ),
)  # fmt: skip

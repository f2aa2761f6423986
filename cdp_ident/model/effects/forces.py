"""Forces on the rods and torques in the joints other than friction: the air, springs, cogging, impulses."""

import math
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from cdp_ident.model.compilation import inlined
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
from cdp_ident.model.equations import exponential_decay, response, sine_and_cosine, solved, torques_on_rods

Array = npt.NDArray[np.float64]

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)
_STRIPS = tuple((0.5 * (float(node) + 1.0), 0.5 * float(weight)) for node, weight in zip(_NODES, _WEIGHTS, strict=True))
"""Gauss-Legendre quadrature along a rod of unit length: strips, and their shares."""
_NUDGE = 1e-5
"""Step of the differences of the pull's acceleration [rad], [rad/s] …"""
_NUDGED = math.sin(_NUDGE), math.cos(_NUDGE)
"""… and its sine and cosine."""
_HEAVIER = 1.5, 4.0, 12.0
"""Masses of what moves along with a cart that gives way, over the rods' share, to begin fits with."""
_DAMPING_RATIO = 0.05
"""Damping ratio of such a cart, to begin fits with."""
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
    _, _, omega1, omega2 = state
    sin1, cos1, sin2, cos2 = turned
    u = _acceleration_of_pull(turned, omega1, omega2, constants)
    scale = 0.5 * compliance / _NUDGE
    by_theta1 = scale * (
        _acceleration_of_pull((*_nudged(sin1, cos1, 1.0), sin2, cos2), omega1, omega2, constants)
        - _acceleration_of_pull((*_nudged(sin1, cos1, -1.0), sin2, cos2), omega1, omega2, constants)
    )
    by_theta2 = scale * (
        _acceleration_of_pull((sin1, cos1, *_nudged(sin2, cos2, 1.0)), omega1, omega2, constants)
        - _acceleration_of_pull((sin1, cos1, *_nudged(sin2, cos2, -1.0)), omega1, omega2, constants)
    )
    by_omega1 = scale * (
        _acceleration_of_pull(turned, omega1 + _NUDGE, omega2, constants)
        - _acceleration_of_pull(turned, omega1 - _NUDGE, omega2, constants)
    )
    by_omega2 = scale * (
        _acceleration_of_pull(turned, omega1, omega2 + _NUDGE, constants)
        - _acceleration_of_pull(turned, omega1, omega2 - _NUDGE, constants)
    )
    cosine1, cosine2, along = a1 * cos1, m2_l2 * cos2, compliance * u
    return (
        cosine1 * along, cosine2 * along,
        (cosine1 * by_theta1 - a1 * sin1 * along, cosine1 * by_theta2, cosine1 * by_omega1, cosine1 * by_omega2),
        (cosine2 * by_theta1, cosine2 * by_theta2 - m2_l2 * sin2 * along, cosine2 * by_omega1, cosine2 * by_omega2),
        (0.0, 0.0, cos1 * along, 0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0, 0.0, cos2 * along, 0.0),
        (cosine1 * u, 0.0, 0.0), (cosine2 * u, 0.0, 0.0),
    )  # fmt: skip


@inlined
def _nudged(sine, cosine, sign):
    """Return sine and cosine of an angle that is `_NUDGE` larger, or by sign -1 smaller."""
    by, of = sign * _NUDGED[0], _NUDGED[1]
    return sine * of + cosine * by, cosine * of - sine * by


@inlined
def _acceleration_of_pull(turned, omega1, omega2, constants):
    """Return the second derivative in time of the rods' horizontal pull, over A22, along the paper's motion.

    The base moves by minus compliance times the pull; as the rods see it, that is an acceleration of the cart. The pull
    is the second derivative of a1 sin theta1 + m2 l2 sin theta2, so that it takes the fourth one of the angles. These
    follow from the equations of motion M alpha = N, derived once and twice: M jerk = N' - M' alpha and
    M snap = N'' - 2 M' jerk - M'' alpha.
    """
    A23, A33, a1, c1, c2, m2_l2, g = (
        constants[0], constants[1], constants[2], constants[3], constants[4], constants[5], constants[6],
    )  # fmt: skip
    sin1, cos1, sin2, cos2 = turned
    # What is beside the diagonal of M, and what turns the one rod by the other's speed squared, and their rates.
    m, n = A23 * (cos1 * cos2 + sin1 * sin2), A23 * (sin1 * cos2 - cos1 * sin2)
    relative = omega1 - omega2
    m_rate, n_rate = -n * relative, m * relative
    inverse = response(A33, m)
    push1, push2 = torques_on_rods(turned, omega1, omega2, 0.0, A23, a1, c1, c2, m2_l2, g, 0.0, 0.0)
    alpha1, alpha2 = solved(inverse, push1, push2)
    relative_rate = alpha1 - alpha2
    m_bend, n_bend = -n_rate * relative - n * relative_rate, m_rate * relative + m * relative_rate
    rate1, rate2 = cos1 * omega1, cos2 * omega2
    bend1, bend2 = cos1 * alpha1 - sin1 * omega1 * omega1, cos2 * alpha2 - sin2 * omega2 * omega2
    jerk1, jerk2 = solved(
        inverse,
        a1 * g * rate1 - n_rate * omega2 * omega2 - 2.0 * n * omega2 * alpha2 - c1 * alpha1 - c2 * relative_rate
        - m_rate * alpha2,
        m2_l2 * g * rate2 + n_rate * omega1 * omega1 + 2.0 * n * omega1 * alpha1 + c2 * relative_rate - m_rate * alpha1,
    )  # fmt: skip
    friction = c2 * (jerk1 - jerk2)
    snap1, snap2 = solved(
        inverse,
        a1 * g * bend1 - n_bend * omega2 * omega2 - 4.0 * n_rate * omega2 * alpha2
        - 2.0 * n * (alpha2 * alpha2 + omega2 * jerk2) - c1 * jerk1 - friction - 2.0 * m_rate * jerk2 - m_bend * alpha2,
        m2_l2 * g * bend2 + n_bend * omega1 * omega1 + 4.0 * n_rate * omega1 * alpha1
        + 2.0 * n * (alpha1 * alpha1 + omega1 * jerk1) + friction - 2.0 * m_rate * jerk1 - m_bend * alpha1,
    )  # fmt: skip
    return a1 * _fourth_of_sine(sin1, cos1, omega1, alpha1, jerk1, snap1) + m2_l2 * _fourth_of_sine(
        sin2, cos2, omega2, alpha2, jerk2, snap2
    )


@inlined
def _fourth_of_sine(sine, cosine, rate, bend, jerk, snap):
    """Return the fourth derivative in time of the sine of an angle, of the first four ones of which are given."""
    squared = rate * rate
    return cosine * (snap - 6.0 * squared * bend) + sine * (squared * squared - 3.0 * bend * bend - 4.0 * rate * jerk)


def _on_carts(compliance: float, coefficients: Array) -> list[tuple[float, float, float]]:
    """Return the parameters of a compliance under carts of several masses.

    What moves along is heavier than the rods' share, which turns them and not the cart: a lighter one has no inertia.
    """
    _, A33, a1, _, _, m2_l2, _ = coefficients
    share = a1**2 + m2_l2**2 / A33
    stiffness = 1.0 / max(compliance, np.finfo(float).tiny)
    return [(compliance, math.sqrt(stiffness / (times * share)), _DAMPING_RATIO) for times in _HEAVIER]


@inlined
def _bell(time, parameters):
    """Return an impulse's torque, and its derivatives by the impulse and by the instant."""
    impulse, at, _ = parameters
    late = (time - at) / _PULSE
    bell = exponential_decay(0.5 * late * late) / (_PULSE * math.sqrt(2.0 * math.pi))
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
            of_angle=True,
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
            of_angle=True,
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
            EffectParameter("damping_ratio", "1", 0.0, 5.0, _DAMPING_RATIO, shape=True),
        ), None, Form.BASE, states=2, contains="pivot_compliance", begins=_on_carts,
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

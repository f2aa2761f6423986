"""Friction in the joints beyond the paper's viscous kind. It acts against the joint's relative motion.

Dry friction is set-valued: while the joint slips its size is what its law says, and while a torque of that size at
rest suffices the joint stands still (`sticking`). Presliding friction is elastic instead until it slips: it has a state
of its own, and nothing sticks.
"""

import math

from cdp_ident.model.compilation import Compilable, inlined, part
from cdp_ident.model.effects.effect import (
    JOINTS,
    NOT_BY_ANY,
    NOT_BY_COEFFICIENTS,
    NOT_BY_STATE,
    EffectParameter,
    Form,
    Joint,
    TorqueEffect,
)
from cdp_ident.model.equations import acceleration_derivatives, exponential_decay

_SLIPPING = 1e-11
"""What is elastic before it slips has slipped when its state is so close to its limit."""


@inlined
def _coulomb(angle, speed, parameters):
    return parameters[0], 0.0, 0.0, (1.0, 0.0, 0.0)


@inlined
def _stribeck(angle, speed, parameters):
    torque, more, width = parameters
    relative = speed / width
    near_rest = exponential_decay(relative * relative)
    extra = more * near_rest
    by_width = 2.0 * extra * relative * relative / width
    return torque + extra, 0.0, -2.0 * extra * relative / width, (1.0, near_rest, by_width)


@inlined
def _quadratic(angle, speed, parameters):
    coefficient, _, _ = parameters
    squared = -speed * abs(speed)
    return coefficient * squared, 0.0, -2.0 * coefficient * abs(speed), (squared, 0.0, 0.0)


@part
def _dahl(speed, direction, own, values, row, slopes):
    torque, give = values[row, 0], values[row, 1]
    slips = 1.0 - direction * own
    if abs(slips) < _SLIPPING:
        # It slips as dry friction does: its state stays as it is until the joint turns back.
        slips, speed = 0.0, 0.0
    rate = speed * slips / give
    slopes[0, 0], slopes[0, 1], slopes[0, 2], slopes[0, 3] = 0.0, -torque, -own, 0.0
    slopes[1, 0], slopes[1, 1] = slips / give, -direction * speed / give
    slopes[1, 2], slopes[1, 3] = 0.0, -rate / give
    return -torque * own, rate


@inlined
def _load(state, turned, parameters, constants, inner_moment, outer_moment, carries_inner_rod):
    """Return lever times the bearing's load over A22, from the mass and the first moments that it carries.

    Its acceleration is that of the paper's model: friction changes the load too little to matter to itself.
    """
    lever, mass, _ = parameters
    A23, A33, a1, c1, c2, m2_l2, g = (
        constants[0], constants[1], constants[2], constants[3], constants[4], constants[5], constants[6],
    )  # fmt: skip
    _, _, omega1, omega2 = state
    alpha1, alpha2, _, by_rods, by_coefficient = acceleration_derivatives(
        turned, omega1, omega2, 0.0, A23, A33, a1, c1, c2, m2_l2, g, 0.0, 0.0
    )
    sin1, cos1, sin2, cos2 = turned
    along1, along2 = cos1 * alpha1 - sin1 * omega1 * omega1, cos2 * alpha2 - sin2 * omega2 * omega2
    down1, down2 = sin1 * alpha1 + cos1 * omega1 * omega1, sin2 * alpha2 + cos2 * omega2 * omega2
    across = inner_moment * along1 + outer_moment * along2
    up = mass * g - inner_moment * down1 - outer_moment * down2
    load = math.sqrt(across * across + up * up) + 1e-300
    by_across, by_up = lever * across / load, lever * up / load
    by_alpha1 = inner_moment * (by_across * cos1 - by_up * sin1)
    by_alpha2 = outer_moment * (by_across * cos2 - by_up * sin2)
    by_inner, by_outer = by_across * along1 - by_up * down1, by_across * along2 - by_up * down2
    by_A23, by_a1, by_m2_l2, by_mass = 0.0, 0.0, by_outer, by_up * g
    if carries_inner_rod:
        by_a1 = by_inner
    else:
        by_A23 = by_inner * mass / m2_l2
        by_m2_l2 -= by_inner * mass * A23 / (m2_l2 * m2_l2)
        by_mass += by_inner * A23 / m2_l2
    x = (
        by_alpha1 * by_rods[0][0] + by_alpha2 * by_rods[0][1] - inner_moment * (by_across * down1 + by_up * along1),
        by_alpha1 * by_rods[1][0] + by_alpha2 * by_rods[1][1] - outer_moment * (by_across * down2 + by_up * along2),
        by_alpha1 * by_rods[2][0] + by_alpha2 * by_rods[2][1]
        - 2.0 * inner_moment * omega1 * (by_across * sin1 + by_up * cos1),
        by_alpha1 * by_rods[3][0] + by_alpha2 * by_rods[3][1]
        - 2.0 * outer_moment * omega2 * (by_across * sin2 + by_up * cos2),
    )  # fmt: skip
    by_coefficients = (
        by_alpha1 * by_coefficient[0][0] + by_alpha2 * by_coefficient[0][1] + by_A23,
        by_alpha1 * by_coefficient[1][0] + by_alpha2 * by_coefficient[1][1],
        by_alpha1 * by_coefficient[2][0] + by_alpha2 * by_coefficient[2][1] + by_a1,
        by_alpha1 * by_coefficient[3][0] + by_alpha2 * by_coefficient[3][1],
        by_alpha1 * by_coefficient[4][0] + by_alpha2 * by_coefficient[4][1],
        by_alpha1 * by_coefficient[5][0] + by_alpha2 * by_coefficient[5][1] + by_m2_l2,
        by_alpha1 * by_coefficient[6][0] + by_alpha2 * by_coefficient[6][1] + by_up * mass,
    )
    return lever * load, 0.0, x, NOT_BY_STATE, by_coefficients, NOT_BY_COEFFICIENTS, (load, by_mass, 0.0), NOT_BY_ANY


@inlined
def _load_inner(state, turned, time, parameters, constants):
    return _load(state, turned, parameters, constants, constants[2], constants[5], True)


@inlined
def _load_outer(state, turned, time, parameters, constants):
    # The outer rod hangs on a point that moves on a circle of radius L = A23 / (m2 l2).
    carried = parameters[1] * constants[0] / constants[5]
    return _load(state, turned, parameters, constants, carried, constants[5], False)


def _both(
    name: str,
    description: str,
    formula: str,
    source: str,
    parameters: tuple[EffectParameter, ...],
    law: Compilable,
    dry: bool = True,
    contains: str = "",
    turns_over: str = "",
    in_balance: bool = False,
) -> tuple[TorqueEffect, ...]:
    return tuple(
        TorqueEffect(
            name,
            joint,
            "",
            description,
            formula,
            source,
            parameters,
            law,
            dry=dry,
            linear=False,
            turns_over=turns_over,
            contains=contains,
            in_balance=in_balance,
        )
        for joint in JOINTS
    )


def _torque(name: str, typical: float) -> EffectParameter:
    return EffectParameter(name, "N m", 0.0, 500.0, typical, inertia_power=1)


_SET_VALUED = "set-valued: Leine and Nijmeijer, Dynamics and Bifurcations of Non-smooth Mechanical Systems, 2004"
_LOADED: tuple[tuple[Joint, float, Compilable], ...] = (("inner", 7.0, _load_inner), ("outer", 2.0, _load_outer))

FRICTION: tuple[TorqueEffect, ...] = (
    *_both(
        "coulomb_friction",
        "dry friction",
        "torque against the motion; up to torque at rest",
        f"Coulomb, 1785; {_SET_VALUED}",
        (_torque("torque", 0.05),),
        _coulomb,
        in_balance=True,
    ),
    *_both(
        "stribeck_friction",
        "dry friction that is larger near rest",
        "torque + extra exp(-(speed / stribeck_speed)^2) against the motion; up to torque + extra at rest",
        f"Stribeck, 1902; in the form of Armstrong-Helouvry et al., Automatica 30, 1994; {_SET_VALUED}",
        (
            _torque("torque", 0.05),
            _torque("extra", 0.05),
            EffectParameter("stribeck_speed", "rad/s", 0.05, 20.0, 0.5, shape=True),
        ),
        _stribeck,
        contains="coulomb_friction",
        turns_over="stribeck_speed",
    ),
    *(
        TorqueEffect(
            "presliding_friction",
            joint,
            "",
            "dry friction that gives way before it slips",
            "-torque s; s' = (speed - |speed| s) / give, from -1 to 1",
            "Dahl, A solid friction model, Aerospace Corporation TOR-0158, 1968",
            (_torque("torque", 0.05), EffectParameter("give", "rad", 5e-4, 0.3, 0.02, shape=True)),
            _dahl,
            Form.MEMORY,
            states=1,
            start_std=1.0,
            linear=False,
            turns_over="give",
            contains="coulomb_friction",
        )
        for joint in JOINTS
    ),
    *_both(
        "quadratic_friction",
        "friction that grows with the square of the joint's speed",
        "-coefficient speed |speed|",
        "turbulent lubricant or fan drag of the joint: White, Fluid Mechanics, 2011",
        (EffectParameter("coefficient", "N m s^2", 0.0, 2.0, 0.005, inertia_power=1),),
        _quadratic,
        dry=False,
    ),
    *(
        TorqueEffect(
            "load_friction",
            joint,
            "",
            "dry friction that grows with the bearing's load",
            "lever |load| against the motion, the load from the constraint forces; up to lever |load| at rest",
            "Coulomb friction in a loaded bearing: SKF, Rolling Bearings, 2018",
            (
                EffectParameter("lever", "m", 0.0, 0.2, 1e-3),
                # What hangs on the bearing; no zero-input motion of the paper's model shows a mass by itself.
                EffectParameter("mass", "kg", 0.01, 1000.0, mass, inertia_power=1, shape=True, includes_weights=True),
            ),
            law,
            Form.RODS,
            dry=True,
            linear=False,
        )
        for joint, mass, law in _LOADED
    ),
)

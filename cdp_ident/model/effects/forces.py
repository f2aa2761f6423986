# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Forces on the rods, the joints and the cart other than friction: the air, springs, cogging, impulses, motors."""

import math
from dataclasses import replace

import numpy as np

from cdp_ident.model.effects.effect import (
    HARMONIC,
    JOINTS,
    TIME,
    Effect,
    EffectParameter,
    Joint,
    Law,
    State,
    harmonic_in_joints,
    in_joints,
    off_by_an_angle,
)

_PULSE = 0.01
"""Standard deviation in time of an impulse [s]; of one whose duration is fitted the least is `_SHORTEST`."""
_SHORTEST = 0.003
COGGING_PERIODS = tuple(range(2, 17))
"""How often in a turn a cogging torque may repeat. Once a turn is an unbalance, which gravity's terms hold already."""

_AROUND = tuple(f"{angle:.1f}" for angle in np.arange(-3.0, 3.2, 0.2))
"""Angles that a magnet's place is looked for at [rad]: its usual reach apart."""
_SECTORS = _AROUND[::2]
"""Angles that a sector of friction is looked for at [rad]."""
_STOPS = tuple(f"{sign}{angle}" for sign in ("", "-") for angle in (0.5, 0.8, 1.2, 1.6, 2.0, 2.5, 3.0))
"""Angles that a stop is looked for at [rad]."""

_TORQUE = EffectParameter("torque", "N m", -200.0, 200.0, 0.01)
_STIFFNESS = EffectParameter("stiffness", "N m/rad", 0.0, 1000.0, 0.1)
_DRAG = EffectParameter("coefficient", "N m s^2", 0.0, 2.0, 0.005)
# No length of the outer rod is in the paper's model; its centre of mass does not determine where it ends.
_LENGTH_RATIO = EffectParameter("length_ratio", "1", 0.3, 3.0, 1.0, shape=True, optional=True)
_ACROSS, _BLUNT = (
    f"drag of a {what}: Hoerner, Fluid-Dynamic Drag, 1965" for what in ("cylinder across a flow", "sphere")
)


def _drag(
    joint: Joint, law: Law, variant: str = "", description: str = "air drag on the rod", source: str = _ACROSS
) -> Effect:
    parameters = (_DRAG, _LENGTH_RATIO) if law.where else (_DRAG,)
    return Effect("air_drag", joint, description, law, parameters, source, variant)


_BOB = Law(
    # Against the velocity of the rod's end, which is speed times its length.
    torques=(
        "-coefficient*speed_of_end*lever*(lever*omega1 + along*omega2)",
        "-coefficient*speed_of_end*(omega2 + lever*along*omega1)",
    ),
    where=(
        ("lever", "L/(length_ratio*outer_length)"),
        ("along", "cos(theta1 - theta2)"),
        ("speed_of_end", "sqrt((lever*omega1)^2 + omega2^2 + 2*lever*along*omega1*omega2 + 1e-30)"),
    ),
)
_STRIPS = Law(
    # Four times the integral of across |across| over place, from 0 in the joint to 1 at the tip, where across is
    # at_joint + place omega2: so -coefficient omega2 |omega2| where the joint is at rest. If the air comes from the
    # other side near the joint, as far as turn, that part counts with the other sign. What the air acts on is
    # length_ratio times as long as the rod is taken to be; the joint carries it along across itself.
    # 1e-12 (rad/s)^2 keeps a rod at rest from a division by zero; there turns is zero.
    torques=(
        "-4*coefficient*lever*sign(at_tip)*(at_joint^2 + at_joint*omega2 + omega2^2/3 - 2*turns*turn*at_joint^2/3)",
        "-4*coefficient*sign(at_tip)*(at_joint^2/2 + 2*at_joint*omega2/3 + omega2^2/4 - turns*turn^2*at_joint^2/6)",
    ),
    where=(
        ("lever", "L/(length_ratio*outer_length)*cos(theta1 - theta2)"),
        ("at_joint", "lever*omega1"),
        ("at_tip", "at_joint + omega2"),
        ("turns", "(1 - sign(at_joint)*sign(at_tip))/2"),
        ("turn", "-at_joint*omega2/(omega2^2 + 1e-12)"),
    ),
)


def _cogging(periods: int) -> tuple[Effect, ...]:
    return harmonic_in_joints(
        "cogging_torque",
        f"a torque that repeats {periods} times a turn",
        Law(torque=HARMONIC),
        periods,
        EffectParameter("", "N m", -200.0, 200.0, 0.05),
        "detent torque of a motor or a magnet ring: Hendershot and Miller, 1994",
    )


def _varying_viscosity(periods: int) -> tuple[Effect, ...]:
    return harmonic_in_joints(
        "varying_viscosity",
        f"viscous friction that varies {'once' if periods == 1 else 'twice'} a turn",
        Law(torque="-speed*(sine*sin(periods*angle) + cosine*cos(periods*angle))"),
        periods,
        EffectParameter("", "N m s", -50.0, 50.0, 0.01),
        "eddy currents beside a magnet, or a bent axle: Heald, Magnetic braking, Am. J. Phys. 56, 1988",
    )


def _impulse(joint: Joint, lasts: bool) -> Effect:
    width = "duration" if lasts else str(_PULSE)
    pulse = f"impulse*exp(-((t - time)/{width})^2/2)/({width}*sqrt(2*pi))"
    return Effect(
        "impulse",
        joint,
        "a push on the rod" if lasts else "an impulse on the rod",
        Law(torques=(pulse, "") if joint == "inner" else ("", pulse)),
        (
            EffectParameter("impulse", "N m s", -50.0, 50.0, 0.05),
            TIME,
            *([EffectParameter("duration", "s", _SHORTEST, 2.0, 0.1, shape=True)] if lasts else []),
        ),
        f"a torque pulse of {'some' if lasts else f'{_PULSE} s'} standard deviation",
        "lasting" if lasts else "",
        at_an_instant=True,
        contains="impulse" if lasts else "",
    )


_COMPLIANCE = EffectParameter("compliance", "m/N", 0.0, 1e-2, 1e-5)
_FREE_PULL = "a1*(cos(theta1)*free1 - sin(theta1)*omega1^2) + m2_l2*(cos(theta2)*free2 - sin(theta2)*omega2^2)"
_ROUGHLY_RODS, _HEAVIER = "(a1^2 + m2_l2^2/A33)", (4, 1.5, 12)
"""Roughly the rods' mass over A22, and how many times as heavy what moves along may be: fits begin with each."""
_COMPLIANCES = tuple(f"1/({times}*natural_frequency^2*{_ROUGHLY_RODS})" for times in _HEAVIER)
_FREQUENCIES = tuple(f"1/sqrt({times}*(compliance + 1e-300)*{_ROUGHLY_RODS})" for times in _HEAVIER)
_SPEEDS_UP = (
    "-compliance*natural_frequency^2*(carried*u + pull) - 2*damping_ratio*natural_frequency*speed_ahead"
    " - natural_frequency^2*ahead"
)

FORCES = (
    _drag("inner", Law(torques=("-coefficient*omega1*abs(omega1)", ""))),
    _drag("outer", _STRIPS, "strips", source=f"strip theory; {_ACROSS}"),
    _drag("outer", Law(torques=("", "-coefficient*omega2*abs(omega2)")), "rotation"),
    _drag("outer", _BOB, "bob", "air drag on a body at the rod's end", _BLUNT),
    *in_joints(
        "joint_spring",
        "a spring across the joint",
        Law(torque="torque - stiffness*angle"),
        [_STIFFNESS, _TORQUE],
        "Hooke; a cable across the joint or a seal that does not slip",
    ),
    *in_joints(
        "joint_spring",
        "a spring across the joint that stiffens",
        Law(torque="torque - stiffness*angle - hardening*(angle - rest_angle)^3"),
        [
            _STIFFNESS,
            _TORQUE,
            EffectParameter("hardening", "N m/rad^3", -100.0, 100.0, 0.01),
            EffectParameter("rest_angle", "rad", -math.pi, math.pi, 0.0, width=0.3, shape=True, optional=True),
        ],
        "Duffing: Kovacic and Brennan, The Duffing Equation, 2011",
        variant="hardening",
        contains="joint_spring",
    ),
    *in_joints(
        "constant_torque",
        "a constant torque",
        Law(torque="torque"),
        [_TORQUE],
        "beside dry friction: friction that differs by direction; else a twisted cable, or a motor's current",
    ),
    *in_joints(
        "magnet",
        "a magnet that the rod passes",
        # The force between two poles falls with their distance, which is smallest where away is zero.
        Law(
            torque="-pull*away*(1 + tail/2*(away/reach)^2)^(-1/tail)",
            where=(("away", "2*atan(tan((angle - place)/2))"),),
        ),
        [
            EffectParameter("pull", "N m/rad", -1000.0, 1000.0, 0.1),
            EffectParameter("place", "rad", -math.pi, math.pi, 0.0, width=2.0, begins=_AROUND, shape=True),
            EffectParameter("reach", "rad", 0.03, 1.0, 0.2, shape=True, resolves="angle"),
            EffectParameter("tail", "1", 1e-3, 1.0, 0.4, shape=True),
        ],
        "two poles or dipoles on a circle: Jackson, Classical Electrodynamics, 1999, 5; tail is 0.4 for two dipoles",
    ),
    *in_joints(
        "end_stop",
        "an elastic end stop",
        Law(
            # It pushes and does not pull: a joint that leaves it faster than it can follow is free.
            torque="-stiffness*past*pressed*step(past*place)*step(pressed)",
            where=(("past", "angle - place"), ("pressed", "1 + loss*speed*sign(place)")),
        ),
        [
            EffectParameter("stiffness", "N m/rad", 0.0, 5000.0, 1.0),
            EffectParameter("place", "rad", -2.0 * math.pi, 2.0 * math.pi, 0.0, width=2.0, begins=_STOPS, shape=True),
            EffectParameter("loss", "s/rad", 0.0, 10.0, 0.1, shape=True),
        ],
        "Hunt and Crossley, Coefficient of restitution interpreted as damping, J. Appl. Mech. 42, 1975",
    ),
    *off_by_an_angle(
        "gravity_tilt",
        "tilt",
        ("base",),
        ("a base that is not level", "a base that settles", "a base that settles, ever more slowly"),
        lambda tilt: Law(
            torques=("a1*g*(sin(theta1 - now) - sin(theta1))", "m2_l2*g*(sin(theta2 - now) - sin(theta2))"),
            where=(("now", tilt),),
        ),
        "statics; the same motion as with an inner encoder that is off by the tilt",
    ),
    Effect(
        "side_force",
        "base",
        "a steady force on both rods from the side",
        Law(torques=("inner*cos(theta1)", "outer*cos(theta2)")),
        (replace(_TORQUE, name="inner"), replace(_TORQUE, name="outer")),
        "statics: a wind, or a magnet far away; in the ratio of the rods' first moments it is a base that is not level",
    ),
    *(effect for periods in COGGING_PERIODS for effect in _cogging(periods)),
    *(effect for periods in (1, 2) for effect in _varying_viscosity(periods)),
    *in_joints(
        "varying_viscosity",
        "viscous friction in a part of the turn",
        Law(
            # As the edge vanishes it is Gaussian; with an edge of 1 a parabola, to sqrt(2) times its reach.
            torque="-coefficient*speed*exp(log((inside + abs(inside))/2 + 1e-12)/edge)",
            where=(
                ("away", "2*atan(tan((angle - place)/2))"),
                ("inside", "1 - edge*(away/reach)^2/2"),
            ),
        ),
        [
            EffectParameter("coefficient", "N m s", 0.0, 50.0, 0.01),
            EffectParameter("place", "rad", -math.pi, math.pi, 0.0, width=2.0, begins=_SECTORS, shape=True),
            EffectParameter("reach", "rad", 0.05, 1.5, 0.3, shape=True),
            EffectParameter("edge", "1", 0.02, 1.0, 0.1, width=0.5, shape=True, optional=True),
        ],
        "eddy currents in what passes a magnet: Heald, Magnetic braking, Am. J. Phys. 56, 1988",
        variant="near a place",
    ),
    Effect(
        "geared_rotor",
        "outer",
        "the rotor of a geared drive",
        # A rotor of inertia J that turns n times as fast as the joint: coupling = J n (1 - n), and the rest of its
        # inertia is in that of the rods.
        Law(torques=("-coupling*alpha2", "-coupling*alpha1")),
        (EffectParameter("coupling", "kg m^2", -0.9, 0.9, -0.02),),
        "kinetic energy of a rotor at the speed omega1 + n (omega2 - omega1): Siciliano et al., Robotics, 2009, 7.2",
    ),
    *(_impulse(joint, lasts) for lasts in (False, True) for joint in JOINTS),
    Effect(
        "pivot_compliance",
        "base",
        "a compliant base",
        # It is ahead by minus the compliance times the rods' pull, along the motion of the paper's model.
        Law(cart="-compliance*rate(rate(free_pull))", where=(("free_pull", _FREE_PULL),)),
        (_COMPLIANCE,),
        "quasi-static elasticity: valid while the cart's own oscillation is much faster than the swing",
    ),
    Effect(
        "pivot_compliance",
        "base",
        "a compliant base with a mode of its own",
        # 1 / (compliance natural_frequency^2) is the mass of what moves along: cart, rods and all. The weights that a
        # trial's rods carry come on top.
        Law(cart=_SPEEDS_UP, states=(State("ahead", "speed_ahead"), State("speed_ahead", _SPEEDS_UP))),
        (
            # What moves along is heavier than the rods' share, which turns them and not the cart.
            replace(_COMPLIANCE, upper=10.0, begins=_COMPLIANCES),
            EffectParameter("natural_frequency", "rad/s", 0.3, 1000.0, 15.0, shape=True, begins=_FREQUENCIES),
            EffectParameter("damping_ratio", "1", 0.0, 5.0, 0.05, shape=True),
        ),
        "oscillator with one degree of freedom: Den Hartog, Mechanical Vibrations, 1956",
        "oscillating",
        contains="pivot_compliance",
    ),
)

_LATE = 0.05
"""No motor is later, or its record, than this [s]."""

MOTORS = Effect(
    "motors",
    "base",
    "the motors' torques, as they were recorded",
    Law(
        torques=("inner - outer", "outer"),
        where=(
            ("inner", "gain*(drive_inner - lag_inner*(drive_rate_inner - 0.5*lag_inner*drive_curvature_inner))"),
            ("late", "drive_outer - lag_outer*(drive_rate_outer - 0.5*lag_outer*drive_curvature_outer)"),
            ("outer", "gain*(1 + imbalance)*late"),
        ),
    ),
    (
        EffectParameter("gain", "1", 0.0, math.inf, 1.0, power=1),
        EffectParameter("imbalance", "1", -0.5, 1.0, 0.0, shape=True),
        EffectParameter("lag_inner", "s", -_LATE, _LATE, 0.0, width=0.005, shape=True),
        EffectParameter("lag_outer", "s", -_LATE, _LATE, 0.0, width=0.005, shape=True),
    ),
    "a current-controlled motor's torque follows its command with a small lag: Siciliano et al., Robotics, 2009, 8",
)
"""What acts is the recorded torque, a lag later to second order in that. Its gain is 1 / A22 where the record is in
N m; `imbalance` says by how much the gain of the outer joint's motor is larger."""

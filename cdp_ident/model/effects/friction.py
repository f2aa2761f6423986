# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Friction in the joints beyond the paper's viscous kind. It acts against the joint's relative motion.

Dry friction is set-valued: while the joint slips its size is what its law says, and while a torque of that size at
rest suffices the joint stands still (`sticking`). Presliding friction is elastic instead until it slips: it has a state
of its own, and nothing sticks.
"""

from cdp_ident.model.effects.effect import Effect, EffectParameter, Law, State, dies_away, ends_at, in_joints


def _torque(name: str) -> EffectParameter:
    return EffectParameter(name, "N m", 0.0, 500.0, 0.05)


_SET_VALUED = "set-valued: Leine and Nijmeijer, Dynamics and Bifurcations of Non-smooth Mechanical Systems, 2004"


def _load_friction(joint: str, mass: float, moment: str) -> Effect:
    """Return the friction of a joint that carries a first moment of the inner rod's motion, beside the outer rod's.

    The load is that of the paper's model, and what the friction by itself changes in it: across + friction across_by,
    and up + friction up_by. So the friction solves a quadratic equation, friction^2 = lever^2 load^2.
    """
    by1, by2 = ("-A33", "coupling") if joint == "inner" else ("(A33 + coupling)", "-(1 + coupling)")
    load = (
        ("moment", moment),
        ("across1", "moment*(cos(theta1)*free1 - sin(theta1)*omega1^2)"),
        ("across2", "m2_l2*(cos(theta2)*free2 - sin(theta2)*omega2^2)"),
        ("across", "across1 + across2"),
        ("down1", "moment*(sin(theta1)*free1 + cos(theta1)*omega1^2)"),
        ("down2", "m2_l2*(sin(theta2)*free2 + cos(theta2)*omega2^2)"),
        ("up", "mass*g - down1 - down2"),
    )
    by_friction = (
        ("coupling", "A23*cos(theta1 - theta2)"),
        ("slowed", f"direction_{joint}/(A33 - coupling^2)"),
        ("across_by", f"slowed*(moment*cos(theta1)*{by1} + m2_l2*cos(theta2)*{by2})"),
        ("up_by", f"-slowed*(moment*sin(theta1)*{by1} + m2_l2*sin(theta2)*{by2})"),
        # The equation has 1/(1 - x) here, x = lever^2 (across_by^2 + up_by^2). 1 + x is the same but for x^2, some
        # 1e-6, and finite where the bearing would jam.
        ("grows", "1 + lever^2*(across_by^2 + up_by^2)"),
        ("more", "lever*(across*across_by + up*up_by)"),
    )
    return Effect(
        "load_friction",
        "inner" if joint == "inner" else "outer",
        "dry friction that grows with the bearing's load",
        Law(friction="lever*grows*(more + sqrt(more^2 + (across^2 + up^2)/grows))", where=(*load, *by_friction)),
        (
            EffectParameter("lever", "m", 0.0, 0.2, 1e-3),
            # What hangs on the bearing; no zero-input motion of the paper's model shows a mass by itself.
            EffectParameter("mass", "kg", 0.01, 1000.0, mass, shape=True, includes_weights=True),
        ),
        "Coulomb friction in a loaded bearing, the load from the constraint forces: SKF, Rolling Bearings, 2018",
    )


FRICTION = (
    *in_joints(
        "coulomb_friction",
        "dry friction",
        Law(friction="torque"),
        [_torque("torque")],
        f"Coulomb, 1785; {_SET_VALUED}",
    ),
    *in_joints(
        "stribeck_friction",
        "dry friction that is larger near rest",
        Law(friction="torque + extra*exp(-(speed/stribeck_speed)^2)"),
        [
            _torque("torque"),
            _torque("extra"),
            EffectParameter("stribeck_speed", "rad/s", 0.05, 20.0, 0.5, shape=True, resolves="speed"),
        ],
        f"Stribeck, 1902; in the form of Armstrong-Helouvry et al., Automatica 30, 1994; {_SET_VALUED}",
        contains="coulomb_friction",
    ),
    *in_joints(
        "drifting_friction",
        "dry friction that changes along a trial",
        Law(friction="now*step(now)", where=(("now", "torque + drift*t"),)),
        [_torque("torque"), EffectParameter("drift", "N m/s", -50.0, 50.0, 0.005)],
        f"a bearing that warms up, to first order; {_SET_VALUED}",
        contains="coulomb_friction",
    ),
    *in_joints(
        "drifting_friction",
        "dry friction that changes along a trial, ever more slowly",
        Law(friction="now*step(now)", where=(("now", "last_torque + change*exp(-t/time_constant)"),)),
        [
            ends_at(_torque("last_torque"), "torque"),
            *dies_away(EffectParameter("change", "N m", -500.0, 500.0, 0.05)),
        ],
        f"a bearing that warms up; {_SET_VALUED}",
        variant="relaxing",
        contains="drifting_friction",
    ),
    *in_joints(
        "drifting_viscosity",
        "viscous friction that changes along a trial",
        Law(torque="-drift*t*speed"),
        [EffectParameter("drift", "N m", -50.0, 50.0, 0.001)],
        "a lubricant or a magnet's disc that warms up, to first order",
    ),
    *in_joints(
        "drifting_viscosity",
        "viscous friction that changes along a trial, ever more slowly",
        Law(torque="-change*exp(-t/time_constant)*speed"),
        dies_away(EffectParameter("change", "N m s", -50.0, 50.0, 0.01)),
        "a lubricant or a magnet's disc that warms up",
        variant="relaxing",
        contains="drifting_viscosity",
    ),
    *in_joints(
        "presliding_friction",
        "dry friction that gives way before it slips",
        Law(
            torque="-torque*bend",
            states=(State("bend", "speed*(1 - direction*bend)/give", limit=1.0, start_std=1.0),),
        ),
        [_torque("torque"), EffectParameter("give", "rad", 5e-4, 2.0, 0.02, shape=True, resolves="angle")],
        "Dahl, A solid friction model, Aerospace Corporation TOR-0158, 1968",
        contains="coulomb_friction",
    ),
    *in_joints(
        "quadratic_friction",
        "friction that grows with the square of the joint's speed",
        Law(torque="-coefficient*speed*abs(speed)"),
        [EffectParameter("coefficient", "N m s^2", 0.0, 2.0, 0.005)],
        "turbulent lubricant or fan drag of the joint: White, Fluid Mechanics, 2011",
    ),
    _load_friction("inner", 7.0, "a1"),
    # The outer rod hangs on a point that moves on a circle of radius L.
    _load_friction("outer", 2.0, "mass*L"),
)

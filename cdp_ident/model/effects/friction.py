"""Friction in the joints beyond the paper's viscous kind. It acts against the joint's relative motion.

Dry friction is set-valued: while the joint slips its size is what its law says, and while a torque of that size at
rest suffices the joint stands still (`sticking`). Presliding friction is elastic instead until it slips: it has a state
of its own, and nothing sticks.
"""

from cdp_ident.model.effects.effect import Effect, EffectParameter, Law, State, in_joints


def _torque(name: str) -> EffectParameter:
    return EffectParameter(name, "N m", 0.0, 500.0, 0.05, inertia_power=1)


_SET_VALUED = "set-valued: Leine and Nijmeijer, Dynamics and Bifurcations of Non-smooth Mechanical Systems, 2004"


def _load(alpha1: str, alpha2: str, prefix: str = "") -> tuple[tuple[str, str], ...]:
    """Return the force in a joint, across and up, where the rods have some accelerations."""
    return (
        (f"{prefix}along1", f"cos(theta1)*{alpha1} - sin(theta1)*omega1^2"),
        (f"{prefix}along2", f"cos(theta2)*{alpha2} - sin(theta2)*omega2^2"),
        (f"{prefix}down1", f"sin(theta1)*{alpha1} + cos(theta1)*omega1^2"),
        (f"{prefix}down2", f"sin(theta2)*{alpha2} + cos(theta2)*omega2^2"),
        (f"{prefix}across", f"moment*{prefix}along1 + m2_l2*{prefix}along2"),
        (f"{prefix}up", f"mass*g - moment*{prefix}down1 - m2_l2*{prefix}down2"),
    )


def _load_friction(joint: str, mass: float, moment: str) -> Effect:
    """Return the friction of a joint that carries a first moment of the inner rod's motion, beside the outer rod's.

    The load's acceleration is that of the paper's model, and what the friction by itself changes in it, to first order.
    """
    by1, by2 = ("-A33", "coupling") if joint == "inner" else ("(A33 + coupling)", "-(1 + coupling)")
    felt = (
        ("coupling", "A23*cos(theta1 - theta2)"),
        ("slowed", f"direction_{joint}*lever*sqrt(free_across^2 + free_up^2)/(A33 - coupling^2)"),
        ("felt1", f"free1 + slowed*{by1}"),
        ("felt2", f"free2 + slowed*{by2}"),
    )
    return Effect(
        "load_friction",
        "inner" if joint == "inner" else "outer",
        "dry friction that grows with the bearing's load",
        Law(
            friction="lever*sqrt(across^2 + up^2)",
            where=(("moment", moment), *_load("free1", "free2", "free_"), *felt, *_load("felt1", "felt2")),
        ),
        (
            EffectParameter("lever", "m", 0.0, 0.2, 1e-3),
            # What hangs on the bearing; no zero-input motion of the paper's model shows a mass by itself.
            EffectParameter("mass", "kg", 0.01, 1000.0, mass, inertia_power=1, shape=True, includes_weights=True),
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
        "presliding_friction",
        "dry friction that gives way before it slips",
        Law(
            torque="-torque*bend",
            states=(State("bend", "speed*(1 - direction*bend)/give", limit=1.0, start_std=1.0),),
        ),
        [_torque("torque"), EffectParameter("give", "rad", 5e-4, 0.3, 0.02, shape=True, resolves="angle")],
        "Dahl, A solid friction model, Aerospace Corporation TOR-0158, 1968",
        contains="coulomb_friction",
    ),
    *in_joints(
        "quadratic_friction",
        "friction that grows with the square of the joint's speed",
        Law(torque="-coefficient*speed*abs(speed)"),
        [EffectParameter("coefficient", "N m s^2", 0.0, 2.0, 0.005, inertia_power=1)],
        "turbulent lubricant or fan drag of the joint: White, Fluid Mechanics, 2011",
    ),
    _load_friction("inner", 7.0, "a1"),
    # The outer rod hangs on a point that moves on a circle of radius L.
    _load_friction("outer", 2.0, "mass*L"),
)

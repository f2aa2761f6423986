# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The words of formulas, and where compiled code finds what they stand for.

A formula is arithmetic (`+ - * / ^` and parentheses) of numbers, names and the functions below. Names are the field's:
angles from upright, speeds, accelerations, the base parameters over A22 (see `parameters`), and a law's own parameters
and states. Within a law of a joint, `angle` (from where the rods hang), `speed` and `acceleration` are that joint's.
"""

STATE = ("theta1", "theta2", "omega1", "omega2")
"""The rods' angles from upright [rad] and speeds [rad/s]."""
ACCELERATIONS = ("alpha1", "alpha2", "u")
"""The rods' accelerations [rad/s^2], and that of the cart's joint [m/s^2], which a law may change."""
MOST_STATES = 2
"""States that one law has of its own, at most."""
OWN = tuple(f"own{k}" for k in range(MOST_STATES))
COEFFICIENTS = ("A23", "A33", "a1", "c1", "c2", "L", "g")
"""The base parameters over A22, L [m] and g [m/s^2]."""
VARIABLES = (*STATE, *ACCELERATIONS, *OWN, *COEFFICIENTS)
"""What laws are differentiated by, beside their parameters: they are first among the inputs of compiled code."""
TURNED = ("sin1", "cos1", "sin2", "cos2")
"""Sines and cosines of theta1 and theta2."""
GIVEN = (
    *("t", "direction_inner", "direction_outer", "outer_length", "carried", *TURNED),
    *("drive_inner", "drive_outer", "drive_rate_inner", "drive_rate_outer"),
    *("drive_curvature_inner", "drive_curvature_outer"),
)
"""What else they may depend on: the time t in the trial [s], the direction in which each joint slips (1 or -1), the
outer rod's length [m], the mass of weights on the rods over A22 [1/m^2], the sines and cosines of theta1 and theta2,
and the torques that motors are known to bring to the joints [N m], with their rates [N m/s] and the rates of these."""
INPUTS = (*VARIABLES, *GIVEN)
VALUE, PARAMETERS = 0, 1 + len(VARIABLES)
"""Columns of what compiled laws return: the value, its derivatives by the variables, and from here on by the
parameters."""

TORQUE1, TORQUE2, FRICTION, CART, RATES = range(5)
"""Rows of what a law adds to the motion: torques on both rods, the size of dry friction in its joint (all over A22),
the acceleration of the cart's joint, and the rates of the law's own states."""
SUMS = (TORQUE1, TORQUE2, CART)
"""The rows that all laws add to, in the order of the sums."""
INNER, OUTER, LATENESS = (RATES + MOST_STATES + k for k in range(3))
"""Rows of what a law adds to the readings of the inner and the outer encoder [rad], and how late its encoder is read
[s]."""
ROWS = LATENESS + 1

OPERATORS = {
    "mean": "the mean of an expression over a variable from 0 to 1: mean(expression, variable)",
    "rate": "the rate of change of an expression along the motion of the paper's model, its cart at rest",
}

OF_JOINT = {
    "inner": {
        "angle": "theta1 - pi",
        "speed": "omega1",
        "acceleration": "alpha1",
        "drive": "drive_inner",
        "drive_rate": "drive_rate_inner",
    },
    "outer": {
        "angle": "theta2 - theta1",
        "speed": "omega2 - omega1",
        "acceleration": "alpha2 - alpha1",
        "drive": "drive_outer",
        "drive_rate": "drive_rate_outer",
    },
}
"""A joint's own angle, speed and acceleration, its motor's torque and the rate of that."""
DERIVED = {
    "sin12": "sin1*cos2 - cos1*sin2",
    "cos12": "cos1*cos2 + sin1*sin2",
    "m2_l2": "A23/L",
    "pull": "a1*(cos(theta1)*alpha1 - sin(theta1)*omega1^2) + m2_l2*(cos(theta2)*alpha2 - sin(theta2)*omega2^2)",
}
"""Sine and cosine of theta1 - theta2; the outer rod's moment and the horizontal force with which the rods pull at the
cart, over A22 and without weights."""
FREE = ("free1", "free2")
"""The rods' accelerations by the paper's model, its cart at rest."""
MASSES = dict.fromkeys(("A23", "A33", "a1", "c1", "c2", "carried", "m2_l2", "pull"), 1)
"""How often the units of words have a mass, where they have one."""


def words_of(joint: str) -> set[str]:
    """Return the words that the formulas of a joint's law may use, but for its own."""
    of_joint = {*OF_JOINT[joint], "direction"} if joint in OF_JOINT else set[str]()
    return {*STATE, *ACCELERATIONS, *COEFFICIENTS, *GIVEN, *DERIVED, *FREE} | of_joint


PAPER = (
    "a1*(g*sin(theta1) - u*cos(theta1)) - A23*sin(theta1 - theta2)*omega2^2 - c1*omega1 - c2*(omega1 - omega2)"
    " - alpha1 - A23*cos(theta1 - theta2)*alpha2",
    "m2_l2*(g*sin(theta2) - u*cos(theta2)) + A23*sin(theta1 - theta2)*omega1^2 - c2*(omega2 - omega1)"
    " - A23*cos(theta1 - theta2)*alpha1 - A33*alpha2",
)
"""The paper's Eq. (1), divided by A22, inertia included: what remains is zero. Eq. (1) prints theta2' in C32; it must
be theta1': only so is energy kept without friction (docs/explanation/paper.md)."""

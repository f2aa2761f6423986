# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A compliant base under the rods' pull."""

from cdp_ident.model.effects.effect import Effect, EffectParameter, Law, State

_COMPLIANCE = EffectParameter("compliance", "m/N", 0.0, 1e-2, 1e-5, inertia_power=-1)
_ROUGHLY_RODS, _HEAVIER = "(a1^2 + m2_l2^2/A33)", (1.5, 4, 12)
"""Roughly the rods' mass over A22, and how many times as heavy what moves along may be: fits begin with each."""
_SPEEDS_UP = (
    "-compliance*natural_frequency^2*(carried*u + pull) - 2*damping_ratio*natural_frequency*speed_ahead"
    " - natural_frequency^2*ahead"
)

CART = (
    Effect(
        "pivot_compliance",
        "base",
        "a compliant base",
        # It is ahead by minus the compliance times the rods' pull, along the motion of the paper's model.
        Law(
            cart="-compliance*rate(rate(free_pull))",
            where=(
                (
                    "free_pull",
                    "a1*(cos(theta1)*free1 - sin(theta1)*omega1^2) + m2_l2*(cos(theta2)*free2 - sin(theta2)*omega2^2)",
                ),
            ),
        ),
        (_COMPLIANCE,),
        "quasi-static elasticity: valid while the cart's own oscillation is much faster than the swing",
    ),
    Effect(
        "pivot_compliance",
        "base",
        "a compliant base with a mode of its own",
        # 1 / (compliance natural_frequency^2) is the mass of what moves along: cart, rods and all. The weights that a
        # trial's rods carry come on top.
        Law(
            cart=_SPEEDS_UP,
            states=(State("ahead", "speed_ahead"), State("speed_ahead", _SPEEDS_UP)),
        ),
        (
            # What moves along is heavier than the rods' share, which turns them and not the cart.
            EffectParameter(
                "compliance",
                "m/N",
                0.0,
                10.0,
                1e-5,
                inertia_power=-1,
                begins=tuple(f"1/({times}*natural_frequency^2*{_ROUGHLY_RODS})" for times in _HEAVIER),
            ),
            EffectParameter(
                "natural_frequency",
                "rad/s",
                0.3,
                1000.0,
                15.0,
                shape=True,
                begins=tuple(f"1/sqrt({times}*(compliance + 1e-300)*{_ROUGHLY_RODS})" for times in _HEAVIER),
            ),
            EffectParameter("damping_ratio", "1", 0.0, 5.0, 0.05, shape=True),
        ),
        "oscillator with one degree of freedom: Den Hartog, Mechanical Vibrations, 1956",
        "oscillating",
        contains="pivot_compliance",
    ),
)

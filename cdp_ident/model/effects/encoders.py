# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Errors of the encoders in the angles that they report, and a rod that bends under them.

The inner encoder turns by theta1 and the outer one by theta2 - theta1, so an error of the inner one is in both
absolute angles.
"""

from dataclasses import replace

from cdp_ident.model.effects.effect import (
    HARMONIC,
    JOINTS,
    TIME,
    Effect,
    EffectParameter,
    Law,
    State,
    harmonic_in_joints,
    in_joints,
    off_by_an_angle,
)

_BEND = (
    "sag*(L*alpha1/g - sin(theta1) + u*cos(theta1)/g)"
    " + swing*L/g*(cos(theta1 - theta2)*alpha2 + sin(theta1 - theta2)*omega2^2)"
)


_SIZE = EffectParameter("", "rad", -0.1, 0.1, 0.01)
_WAVE = (replace(_SIZE, name="sine"), replace(_SIZE, name="cosine"))


def _harmonic(periods: int) -> tuple[Effect, ...]:
    return harmonic_in_joints(
        "encoder_harmonic",
        f"an encoder's error that repeats {periods} times a turn",
        Law(reading=HARMONIC),
        periods,
        _SIZE,
        "a magnet or a scale that is not round, interpolation between poles: Hagiwara et al., IEEE TIM 41, 1992",
    )


ENCODERS = (
    *off_by_an_angle(
        "encoder_offset",
        "offset",
        JOINTS,
        (
            "an encoder that is off by an angle",
            "an encoder whose zero drifts",
            "an encoder whose zero drifts, ever more slowly",
        ),
        lambda offset: Law(reading=offset),
        "zero set while the rod did not hang still, a coupling that is loose or creeps, an encoder that warms up",
    ),
    *in_joints(
        "encoder_scale",
        "an encoder whose counts per turn are taken wrongly",
        Law(reading="scale*angle"),
        [EffectParameter("scale", "1", -0.25, 0.25, 0.01)],
        "a belt or gear between joint and encoder, or a wrong setting",
    ),
    *(
        Effect(
            "encoder_eccentricity",
            joint,
            "an encoder disc off its centre",
            Law(reading=f"sine*sin({turned}) + cosine*cos({turned})"),
            _WAVE,
            "Engelhardt et al., eccentricity error of angle encoders",
        )
        for joint, turned in zip(JOINTS, ("theta1", "angle"), strict=True)
    ),
    *(effect for periods in (2, 3, 4) for effect in _harmonic(periods)),
    *in_joints(
        "encoder_interpolation",
        "an encoder's interpolation error",
        Law(reading=HARMONIC),
        [
            EffectParameter("sine", "rad", -0.05, 0.05, 1e-3),
            EffectParameter("cosine", "rad", -0.05, 0.05, 1e-3),
            EffectParameter("periods", "1", 5.0, 2000.0, 50.0, width=1000.0, shape=True),
        ],
        "between a scale's periods, or a magnetic ring's poles, of so many a turn: Hagiwara et al., IEEE TIM 41, 1992",
    ),
    *in_joints(
        "encoder_compliance",
        "an encoder behind an elastic coupling",
        # What it turns beside the joint, seen from the joint, is an oscillator that the joint's acceleration drives.
        Law(reading="-compliance*acceleration"),
        [EffectParameter("compliance", "s^2", 0.0, 0.01, 1e-4)],
        "quasi-static elasticity: valid while the encoder's own oscillation is much faster than the swing",
    ),
    *in_joints(
        "encoder_compliance",
        "an encoder behind an elastic coupling, with a mode of its own",
        Law(
            reading="-twist",
            states=(
                State("twist", "twist_rate"),
                State("twist_rate", "acceleration - twist/compliance - 2*damping_ratio/sqrt(compliance)*twist_rate"),
            ),
        ),
        [
            EffectParameter("compliance", "s^2", 2e-5, 0.05, 1e-4),
            EffectParameter("damping_ratio", "1", 0.0, 5.0, 0.05, shape=True),
        ],
        "oscillator driven by its foundation: Den Hartog, Mechanical Vibrations, 1956",
        variant="oscillating",
        contains="encoder_compliance",
    ),
    Effect(
        "time_offset",
        "outer",
        "an encoder that is read late",
        Law(lateness="delay"),
        (EffectParameter("delay", "s", -0.03, 0.03, 0.002),),
        "two converters read one after the other, or a filter in one of them",
    ),
    *in_joints(
        "encoder_filter",
        "a filter behind an encoder",
        # What a filter of first order shows is late by its time constant, and beyond that this.
        Law(reading="time_constant_squared*acceleration/2"),
        [EffectParameter("time_constant_squared", "s^2", 0.0, 1e-2, 1e-5)],
        "low-pass filter of first order, to second order in its time constant",
    ),
    *(
        Effect(
            "encoder_filter",
            joint,
            "an encoder behind a filter of first order",
            Law(reading="-time_constant*behind", states=(State("behind", "(speed - behind)/time_constant"),)),
            (EffectParameter("time_constant", "s", 1e-4, 0.1, 0.002, begins=(delay,)),),
            "low-pass filter of first order",
            variant="first order",
            contains="time_offset.outer",
        )
        # An inner encoder that is late is an outer one that is early.
        for joint, delay in zip(JOINTS, ("-delay", "delay"), strict=True)
    ),
    Effect(
        "oblique_view",
        "base",
        "a camera that looks askew",
        # A circle is seen as an ellipse, whose longer axis has some direction.
        Law(
            readings=("of1", "of2 - of1"),
            where=tuple(
                (
                    f"of{k}",
                    f"atan((sine*sin(2*theta{k}) + cosine*cos(2*theta{k}))"
                    f"/(1 - sine*cos(2*theta{k}) + cosine*sin(2*theta{k})))",
                )
                for k in (1, 2)
            ),
        ),
        _WAVE,
        "orthographic projection: Hartley and Zisserman, Multiple View Geometry, 2004",
    ),
    *in_joints(
        "backlash",
        "an encoder whose coupling has play",
        # The encoder follows once the joint has turned through the gap; until then it stays as it is.
        Law(
            reading="-gap/2*side",
            states=(State("side", "2*speed/(gap + 1e-9)", limit=1.0, start_std=1.0, at_zero="direction"),),
        ),
        [EffectParameter("gap", "rad", 0.0, 0.2, 0.01)],
        "play operator: Krasnosel'skii and Pokrovskii, Systems with Hysteresis, 1989",
    ),
    *in_joints(
        "encoder_slip",
        "an encoder that lost counts",
        Law(reading="slip*step(t - time)"),
        [
            EffectParameter("slip", "rad", -0.5, 0.5, 0.01),
            TIME,
        ],
        "counts lost at high speed or by interference",
        at_an_instant=True,
    ),
    Effect(
        # A cantilever with a force across its end leaves the line between the joints by a slope at its root, where the
        # inner encoder is, and by half of that at its end, to the other side; by less where the hub gives way, by more
        # where the rod does beyond its middle (`end_share`). The force is what accelerates all that hangs there, so
        # that the slope is linear in what it is of a rod held level, by the weight of m2 + m0 (`sag`), and
        # m2 l2 / ((m2 + m0) L) of it (`swing`). The bending itself is quasi-static.
        "rod_flex",
        "inner",
        "a rod that bends",
        Law(readings=("bend", "end_share*bend"), where=(("bend", _BEND),)),
        (
            EffectParameter("sag", "rad", 0.0, 0.3, 0.01),
            EffectParameter("swing", "rad", 0.0, 0.3, 0.005),
            EffectParameter("end_share", "1", 0.0, 2.0, 0.5, width=0.5, shape=True, optional=True),
        ),
        "cantilever with a force across its end: Euler and Bernoulli; Timoshenko, Strength of Materials, 1955",
    ),
)

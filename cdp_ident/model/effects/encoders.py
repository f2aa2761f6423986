"""Errors of the encoders in the angles that they report.

The inner encoder turns by theta1 and the outer one by theta2 - theta1, so an error of the inner one is in both
absolute angles.
"""

import math

from cdp_ident.model.compilation import Compilable, part
from cdp_ident.model.effects.effect import EffectParameter, Joint, SensorEffect
from cdp_ident.model.equations import sine_and_cosine


@part
def _offset(angle, time, values, row, slopes):
    slopes[row, 0], slopes[row, 1] = 0.0, 1.0
    return values[row, 0]


@part
def _scale_inner(angle, time, values, row, slopes):
    turned = angle - math.pi
    slopes[row, 0], slopes[row, 1] = values[row, 0], turned
    return values[row, 0] * turned


@part
def _scale_outer(angle, time, values, row, slopes):
    slopes[row, 0], slopes[row, 1] = values[row, 0], angle
    return values[row, 0] * angle


@part
def _eccentricity(angle, time, values, row, slopes):
    sine, cosine = sine_and_cosine(angle)
    slopes[row, 0] = values[row, 0] * cosine - values[row, 1] * sine
    slopes[row, 1], slopes[row, 2] = sine, cosine
    return values[row, 0] * sine + values[row, 1] * cosine


@part
def _slip(angle, time, values, row, slopes):
    after = 1.0 if time >= values[row, 1] else 0.0
    slopes[row, 0], slopes[row, 1], slopes[row, 2] = 0.0, after, 0.0
    return values[row, 0] * after


def _each(
    name: str,
    description: str,
    formula: str,
    source: str,
    parameters: tuple[EffectParameter, ...],
    inner: Compilable | None,
    outer: Compilable | None,
    **kind: bool,
) -> tuple[SensorEffect, ...]:
    laws: tuple[tuple[Joint, Compilable | None], ...] = (("inner", inner), ("outer", outer))
    return tuple(
        SensorEffect(name, joint, "", description, formula, source, parameters, law, **kind) for joint, law in laws
    )


ENCODERS: tuple[SensorEffect, ...] = (
    *_each(
        "encoder_offset",
        "an encoder that is off by an angle",
        "angle + offset",
        "zero set while the rod did not hang still, or a loose coupling",
        (EffectParameter("offset", "rad", -0.3, 0.3, 0.01),),
        _offset,
        _offset,
        acts_as_zero=True,
    ),
    *_each(
        "encoder_scale",
        "an encoder whose counts per turn are taken wrongly",
        "angle + scale (angle - angle at rest)",
        "a belt or gear between joint and encoder, or a wrong setting",
        (EffectParameter("scale", "1", -0.1, 0.1, 0.01),),
        _scale_inner,
        _scale_outer,
        is_scale=True,
    ),
    *_each(
        "encoder_eccentricity",
        "an encoder disc off its centre",
        "angle + sine sin(angle) + cosine cos(angle)",
        "Engelhardt et al., eccentricity error of angle encoders",
        (
            EffectParameter("sine", "rad", -0.1, 0.1, 0.01),
            EffectParameter("cosine", "rad", -0.1, 0.1, 0.01),
        ),
        _eccentricity,
        _eccentricity,
    ),
    SensorEffect(
        "time_offset",
        "outer",
        "",
        "an encoder that is read late",
        "the angle that was there `delay` earlier",
        "two converters read one after the other, or a filter in one of them",
        (EffectParameter("delay", "s", -0.03, 0.03, 0.002),),
        law=None,
        delays=True,
    ),
    *_each(
        "backlash",
        "an encoder whose coupling has play",
        "angle - gap/2 sign(speed) once the joint has turned through the gap; until then as it was",
        "play operator: Krasnosel'skii and Pokrovskii, Systems with Hysteresis, 1989",
        (EffectParameter("gap", "rad", 0.0, 0.2, 0.01),),
        None,
        None,
        has_play=True,
    ),
    *_each(
        "encoder_slip",
        "an encoder that lost counts",
        "angle + slip from `time` on",
        "counts lost at high speed or by interference",
        (
            EffectParameter("slip", "rad", -0.5, 0.5, 0.01),
            EffectParameter("time", "s", 0.0, math.inf, 0.0, shape=True),
        ),
        _slip,
        _slip,
        at_an_instant=True,
    ),
)

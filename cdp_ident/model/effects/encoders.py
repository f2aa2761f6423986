"""Errors of the encoders in the angles that they report.

The inner encoder turns by theta1 and the outer one by theta2 - theta1, so an error of the inner one is in both
absolute angles.
"""

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from cdp_ident.model.effects.effect import Added, EffectParameter, Joint, SensorEffect

Array = npt.NDArray[np.float64]


def _offset(angle: Array, time: Array, values: Sequence[float] | Array) -> Added:
    return Added(values[0], 0.0, (1.0,))


def _scale(rest: float):
    def reading(angle: Array, time: Array, values: Sequence[float] | Array) -> Added:
        turned = angle - rest
        return Added(values[0] * turned, values[0], (turned,))

    return reading


def _eccentricity(angle: Array, time: Array, values: Sequence[float] | Array) -> Added:
    sine, cosine = np.sin(angle), np.cos(angle)
    return Added(values[0] * sine + values[1] * cosine, values[0] * cosine - values[1] * sine, (sine, cosine))


def _nothing_added(angle: Array, time: Array, values: Sequence[float] | Array) -> Added:
    return Added(0.0, 0.0, (0.0,))


def _slip(angle: Array, time: Array, values: Sequence[float] | Array) -> Added:
    after = (time >= values[1]).astype(float)
    return Added(values[0] * after, 0.0, (after, 0.0))


_RESTS: tuple[tuple[Joint, float], ...] = (("inner", math.pi), ("outer", 0.0))


def _each(
    name: str,
    description: str,
    formula: str,
    source: str,
    parameters: tuple[EffectParameter, ...],
    reading,
    **kind: bool,
) -> tuple[SensorEffect, ...]:
    return tuple(
        SensorEffect(name, joint, "", description, formula, source, parameters, reading(rest), **kind)
        for joint, rest in _RESTS
    )


ENCODERS: tuple[SensorEffect, ...] = (
    *_each(
        "encoder_offset",
        "an encoder that is off by an angle",
        "angle + offset",
        "zero set while the rod did not hang still, or a loose coupling",
        (EffectParameter("offset", "rad", -0.3, 0.3, 0.01),),
        lambda rest: _offset,
        acts_as_zero=True,
    ),
    *_each(
        "encoder_scale",
        "an encoder whose counts per turn are taken wrongly",
        "angle + scale (angle - angle at rest)",
        "a belt or gear between joint and encoder, or a wrong setting",
        (EffectParameter("scale", "1", -0.1, 0.1, 0.01),),
        _scale,
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
        lambda rest: _eccentricity,
    ),
    SensorEffect(
        "time_offset",
        "outer",
        "",
        "an encoder that is read late",
        "the angle that was there `delay` earlier",
        "two converters read one after the other, or a filter in one of them",
        (EffectParameter("delay", "s", -0.03, 0.03, 0.002),),
        _nothing_added,
        delays=True,
    ),
    *(
        SensorEffect(
            "backlash",
            joint,
            "",
            "an encoder whose coupling has play",
            "angle - gap/2 sign(speed) once the joint has turned through the gap; until then as it was",
            "play operator: Krasnosel'skii and Pokrovskii, Systems with Hysteresis, 1989",
            (EffectParameter("gap", "rad", 0.0, 0.2, 0.01),),
            _nothing_added,
            has_play=True,
        )
        for joint, _ in _RESTS
    ),
    *(
        SensorEffect(
            "encoder_slip",
            joint,
            "",
            "an encoder that lost counts",
            "angle + slip from `time` on",
            "counts lost at high speed or by interference",
            (
                EffectParameter("slip", "rad", -0.5, 0.5, 0.01),
                EffectParameter("time", "s", 0.0, math.inf, 0.0, shape=True),
            ),
            _slip,
            at_an_instant=True,
        )
        for joint, _ in _RESTS
    ),
)

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Nonparametric torques: smooth curves over a joint's angle or speed, whose shape is estimated from the data.

A curve is a cubic B-spline on uniform knots; its coefficients are the effect's parameters. Its smoothness is not part
of the effect: in the fit, a penalty on differences of neighbouring coefficients determines it (P-splines: Eilers and
Marx, Flexible smoothing with B-splines and penalties, Statistical Science 11, 1996). There are so many knots that a
magnet's torque and the edges of a rub are followed.
"""

import math
from collections.abc import Iterator
from typing import Literal

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.machine.compilation import Compilable
from cdp_ident.model.effects.effect import JOINTS, Curve, Effect, EffectParameter, Joint, Law
from cdp_ident.model.formulas.language import FRICTION, INPUTS, PARAMETERS, TORQUE1, TORQUE2

_OVER_ANGLE, _OVER_SPEED = 80, 32
"""How many coefficients a curve has: over a turn, and over all speeds."""
_DIRECTION = INPUTS.index("direction_inner")
_SLOW = 0.25
"""Speeds are on a scale that is linear below and logarithmic above this [rad/s]: friction changes most near rest."""
_FASTEST = 7.0
"""asinh of the largest speed over that; beyond, the curve is constant."""


def _spline_law(name: str, joint: Joint, curve: Curve, dry: bool) -> Compilable:
    """Return a law as `formulas/code.py` makes others: a spline over the angle or speed of a joint."""
    outer, over_angle, count = joint == "outer", curve.over == "angle", curve.count
    width, intervals = PARAMETERS + count, count - 3
    per_radian = count / (2.0 * math.pi)
    first_by = 1 if over_angle else 3
    zero = 0.0 if outer else math.pi
    row1, row2 = TORQUE1 * width, TORQUE2 * width

    def law(z, p, sums, rows):
        if over_angle:
            turned = ((z[1] - z[0] if outer else z[0]) - zero) * per_radian
            whole = math.floor(turned)
            x, scale, k = turned - whole, per_radian, int(whole) % count
            a, b, c, d = (k - 1) % count, k, (k + 1) % count, (k + 2) % count
        else:
            relative = (z[3] - z[2] if outer else z[2]) / _SLOW
            along = (math.asinh(relative) / _FASTEST + 1.0) * (0.5 * intervals)
            scale = 0.5 * intervals / (_FASTEST * _SLOW * math.sqrt(1.0 + relative * relative))
            if along < 0.0 or along > intervals:
                along, scale = 0.0 if along < 0.0 else float(intervals), 0.0
            k = min(int(along), intervals - 1)
            x, a, b, c, d = along - k, k, k + 1, k + 2, k + 3
        y = 1.0 - x
        direction = (z[_DIRECTION + 1] if outer else z[_DIRECTION]) if dry else 0.0
        # What one unit of torque is on both rods.
        onto2 = (-direction if dry else 1.0) if outer else 0.0
        onto1 = -onto2 if outer else (-direction if dry else 1.0)
        of_a, of_d = y * y * y / 6.0, x * x * x / 6.0
        of_b = (4.0 - 6.0 * x * x + 3.0 * x * x * x) / 6.0
        of_c = (4.0 - 6.0 * y * y + 3.0 * y * y * y) / 6.0
        for column in range(PARAMETERS, width):
            rows[row1 + column], rows[row2 + column] = 0.0, 0.0
        for column, of in ((a, of_a), (b, of_b), (c, of_c), (d, of_d)):
            rows[row1 + PARAMETERS + column], rows[row2 + PARAMETERS + column] = onto1 * of, onto2 * of
        torque = p[a] * of_a + p[b] * of_b + p[c] * of_c + p[d] * of_d
        if dry:
            rows[FRICTION * width] = torque
        slope = (
            scale
            * 0.5
            * (-p[a] * y * y + p[b] * (3.0 * x * x - 4.0 * x) + p[c] * (4.0 * y - 3.0 * y * y) + p[d] * x * x)
        )
        sums[0] += onto1 * torque
        sums[PARAMETERS] += onto2 * torque
        first, second = (-slope, slope) if outer else (slope, 0.0)
        for row, onto in ((0, onto1), (PARAMETERS, onto2)):
            sums[row + first_by] += onto * first
            sums[row + first_by + 1] += onto * second

    law.__name__ = law.__qualname__ = name
    globals()[name] = law  # where pickle finds it again
    return law


def basis(curve: Curve, at: Array) -> Array:
    """Return what each coefficient of a curve contributes (n, count) at angles [rad] or speeds [rad/s]."""
    if curve.over == "angle":
        away = at[:, None] * (curve.count / (2.0 * np.pi)) - np.arange(curve.count)
        away = np.abs((away + 0.5 * curve.count) % curve.count - 0.5 * curve.count)
    else:
        intervals = curve.count - 3
        along = (np.arcsinh(at / _SLOW) / _FASTEST + 1.0) * (0.5 * intervals)
        away = np.abs(np.clip(along, 0.0, intervals)[:, None] + 1.0 - np.arange(curve.count))
    near, far = (4.0 - 6.0 * away**2 + 3.0 * away**3) / 6.0, np.maximum(2.0 - away, 0.0) ** 3 / 6.0
    return np.where(away < 1.0, near, far)


def _in_both(
    variant: str, description: str, over: Literal["angle", "speed"], count: int, dry: bool
) -> Iterator[Effect]:
    lowest = 0.0 if dry else -500.0
    parameters = tuple(
        EffectParameter(f"c{k}", "N m", lowest, 500.0, 0.5 + 0.2 * math.sin(0.4 * k), width=5.0) for k in range(count)
    )
    for joint in JOINTS:
        law = _spline_law(f"{variant}_{joint}", joint, Curve(over, count), dry)
        yield Effect(
            "unknown_torque", joint, description, Law(friction="a curve") if dry else Law(torque="a curve"), parameters,
            "P-splines: Eilers and Marx, Statistical Science 11, 1996", variant, curve=Curve(over, count, law),
        )  # fmt: skip


CURVES: tuple[Effect, ...] = (
    *_in_both("over_angle", "an unknown torque that depends on the angle", "angle", _OVER_ANGLE, dry=False),
    *_in_both("over_speed", "an unknown torque that depends on the speed", "speed", _OVER_SPEED, dry=False),
    *_in_both(
        "friction_over_angle", "an unknown dry friction that depends on the angle", "angle", _OVER_ANGLE, dry=True
    ),
)  # fmt: skip
"""Torques in a joint that are not in the catalogue."""

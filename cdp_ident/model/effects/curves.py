"""Torques without a name: smooth curves over a joint's angle or speed, whose shape is estimated from the data.

A curve is a cubic B-spline on uniform knots; its coefficients are the effect's parameters. Its smoothness is not part
of the effect: in the fit, a penalty on differences of neighbouring coefficients determines it (P-splines: Eilers and
Marx, Flexible smoothing with B-splines and penalties, Statistical Science 11, 1996). There are so many knots that they
do not limit the shape.
"""

import math

import numpy as np
import numpy.typing as npt

from cdp_ident.model.compilation import Compilable, inlined, part
from cdp_ident.model.effects.effect import JOINTS, Curve, EffectParameter, Form, TorqueEffect

Array = npt.NDArray[np.float64]

_OVER_ANGLE, _OVER_SPEED = 128, 64
"""How many coefficients a curve has: over a turn, and over all speeds."""
_SLOW = 0.25
"""Speeds are on a scale that is linear below and logarithmic above this [rad/s]: friction changes most near rest."""
_FASTEST = 7.0
"""asinh of the largest speed over that; beyond, the curve is constant."""


@inlined
def _spline(place, first, second, third, fourth, values, row, slopes):
    """Return the spline at `place` knots past the second of four neighbouring coefficients, and its slope there."""
    x, y = place, 1.0 - place
    cube, other = x * x * x, y * y * y
    slopes[0, 2 + first], slopes[0, 2 + fourth] = other / 6.0, cube / 6.0
    slopes[0, 2 + second] = (4.0 - 6.0 * x * x + 3.0 * cube) / 6.0
    slopes[0, 2 + third] = (4.0 - 6.0 * y * y + 3.0 * other) / 6.0
    c0, c1, c2, c3 = values[row, first], values[row, second], values[row, third], values[row, fourth]
    value = (
        c0 * slopes[0, 2 + first] + c1 * slopes[0, 2 + second] + c2 * slopes[0, 2 + third] + c3 * slopes[0, 2 + fourth]
    )
    slope = 0.5 * (-c0 * y * y + c1 * (3.0 * x * x - 4.0 * x) + c2 * (4.0 * y - 3.0 * y * y) + c3 * x * x)
    return value, slope


@part
def _over_angle(angle, speed, values, row, slopes):
    slopes[0, 1 : 2 + _OVER_ANGLE] = 0.0
    turned = angle * (_OVER_ANGLE / (2.0 * math.pi))
    whole = math.floor(turned)
    k = int(whole) % _OVER_ANGLE
    value, slope = _spline(
        turned - whole,
        (k - 1) % _OVER_ANGLE, k, (k + 1) % _OVER_ANGLE, (k + 2) % _OVER_ANGLE, values, row, slopes,
    )  # fmt: skip
    slopes[0, 0] = slope * (_OVER_ANGLE / (2.0 * math.pi))
    return value


@part
def _over_speed(angle, speed, values, row, slopes):
    slopes[0, : 2 + _OVER_SPEED] = 0.0
    relative = speed / _SLOW
    intervals = _OVER_SPEED - 3
    along = (math.asinh(relative) / _FASTEST + 1.0) * (0.5 * intervals)
    if along < 0.0 or along > intervals:
        along = 0.0 if along < 0.0 else float(intervals)
    k = min(int(along), intervals - 1)
    value, slope = _spline(along - k, k, k + 1, k + 2, k + 3, values, row, slopes)
    if 0.0 < along < intervals:
        slopes[0, 1] = slope * 0.5 * intervals / (_FASTEST * _SLOW * math.sqrt(1.0 + relative * relative))
    return value


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
    variant: str, description: str, formula: str, curve: Curve, law: Compilable, lowest: float, dry: bool
) -> tuple[TorqueEffect, ...]:
    parameters = tuple(
        EffectParameter(f"c{k}", "N m", lowest, 500.0, 0.5 + 0.2 * math.sin(0.4 * k), inertia_power=1)
        for k in range(curve.count)
    )
    source = "P-splines: Eilers and Marx, Statistical Science 11, 1996"
    return tuple(
        TorqueEffect(
            "unknown_torque",
            joint,
            variant,
            description,
            formula,
            source,
            parameters,
            law,
            Form.CURVE,
            dry=dry,
            linear=not dry,
            curve=curve,
        )
        for joint in JOINTS
    )


_TURN, _SPEEDS = Curve("angle", _OVER_ANGLE), Curve("speed", _OVER_SPEED)
CURVES: tuple[TorqueEffect, ...] = (
    *_in_both(
        "over_angle",
        "an unknown torque that depends on the angle",
        f"a cubic B-spline over the joint's angle from hanging, {_OVER_ANGLE} coefficients a turn",
        _TURN,
        _over_angle,
        -500.0,
        dry=False,
    ),
    *_in_both(
        "over_speed",
        "an unknown torque that depends on the speed",
        f"a cubic B-spline over asinh(speed / {_SLOW} rad/s), {_OVER_SPEED} coefficients",
        _SPEEDS,
        _over_speed,
        -500.0,
        dry=False,
    ),
    *_in_both(
        "friction_over_angle",
        "an unknown dry friction that depends on the angle",
        f"a cubic B-spline over the joint's angle from hanging, {_OVER_ANGLE} coefficients a turn, against the motion; "
        "up to that at rest",
        _TURN,
        _over_angle,
        0.0,
        dry=True,
    ),
)
"""Torques in a joint that are not in the catalogue."""

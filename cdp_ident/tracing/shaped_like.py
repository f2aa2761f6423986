# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects that are shaped like a nonparametric torque over an angle: where a fit with them begins.

A curve is linear in its coefficients and is found from anywhere; a law that acts at one place is found from near it.
"""

import ctypes
from collections.abc import Iterator

import numpy as np
from scipy.optimize import least_squares

from cdp_ident.arrays import Array
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.likelihood.scores import begun
from cdp_ident.likelihood.whole_swing import WholeSwings
from cdp_ident.model.effects.catalogue import known_effects
from cdp_ident.model.effects.curves import basis
from cdp_ident.model.effects.effect import Curve, Effect
from cdp_ident.model.formulas.compiled import compiled_law
from cdp_ident.model.formulas.language import INPUTS, PARAMETERS, ROWS, SUMS

_STEPS = 30
"""A law that is not like the curve after so many is not."""


def shaped_like_the_last(found: WholeSwings) -> Iterator[tuple[ActiveEffect, Array]]:
    """Yield effects that act at a place, with the values (k,) by which each is most like a model's last effect.

    Args:
        found: a model; there are none unless its last effect is a torque that is a curve over an angle.

    Raises:
        LinAlgError, ValueError: how exactly the curve is known is not known.
    """
    last, place = found.model.effects[-1], found.model.places(len(found.model.effects) - 1)
    curve = last.effect.curve
    if curve is None or curve.over != "angle" or last.effect.dry:
        return
    root = np.linalg.cholesky(np.linalg.inv(found.covariance[place, place])).T
    for effect in known_effects():
        if effect.at_place_of_joint and effect.joint == last.effect.joint:
            yield ActiveEffect(effect), _most_like(effect, curve, found.values[place], root, found.recorded.time_unit)


def _most_like(effect: Effect, curve: Curve, coefficients: Array, root: Array, unit: float) -> Array:
    """Return an effect's values (k,) for which a curve with these coefficients is the most probable one.

    Args:
        effect: a torque over its joint's angle.
        curve: over the same angle.
        coefficients: (n,) of the curve.
        root: (n, n) of the coefficients' precision.
        unit: the rig's time unit [s].
    """
    angles: Array = np.asarray((np.arange(curve.count) * (2.0 * np.pi / curve.count) + np.pi) % (2.0 * np.pi) - np.pi)
    onto: Array = np.asarray(root @ np.linalg.inv(basis(curve, angles)))
    aim: Array = np.asarray(root @ coefficients)
    fitted = ActiveEffect(effect).fitted
    lower, upper = (np.array([getattr(parameter, end) for parameter in fitted]) for end in ("lower", "upper"))
    strong = next(k for k, parameter in enumerate(fitted) if not parameter.shape)

    def left(values: Array) -> Array:
        return np.asarray(onto @ _torque(effect, values, angles) - aim)

    best, least = np.zeros(len(fitted)), np.inf
    for _, values in begun([effect], unit):
        values[strong] = 1.0
        column = left(values) + aim
        values[strong] = float(column @ aim) / max(float(column @ column), np.finfo(float).tiny)
        within = np.clip(values, lower + 1e-6 * (upper - lower), upper - 1e-6 * (upper - lower))
        sizes = np.maximum(np.abs(within), 0.1)
        result = least_squares(left, within, bounds=(lower, upper), x_scale=sizes, max_nfev=_STEPS)
        if result.cost < least:
            best, least = result.x, result.cost
    return best


def _torque(effect: Effect, values: Array, angles: Array) -> Array:
    """Return the torque (n,) of an effect in its joint at rest at angles (n,) [rad], over A22."""
    law = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 4)(compiled_law(effect))
    inputs, outer = np.zeros(len(INPUTS)), effect.joint == "outer"
    parameters = np.array(ActiveEffect(effect).all_values(values))
    sums, rows = np.zeros(PARAMETERS * len(SUMS)), np.zeros(ROWS * (PARAMETERS + len(parameters)))
    found, addresses = np.empty(len(angles)), [array.ctypes.data for array in (inputs, parameters, sums, rows)]
    for k, angle in enumerate(angles):
        inputs[0], inputs[1] = (0.0, angle) if outer else (np.pi + angle, 0.0)
        sums[:] = 0.0
        law(*addresses)
        found[k] = sums[PARAMETERS if outer else 0]
    return found

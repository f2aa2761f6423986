# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is known of a model's values before any trial: the part of the evidence that keeps models small.

A strength may well be zero, and is hardly larger than a torque that gravity has; a shape parameter is of the size that
is typical. Both scale with the rig: all that has a second in its unit, with the rig's time unit. Curves are smooth: the
second differences of their coefficients are small (a random walk of second order: Rue and Held, Gaussian Markov Random
Fields, 2005, section 3.4).
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import block_diag

from cdp_ident.arrays import Array
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.model.effects.effect import Curve, EffectParameter
from cdp_ident.model.parameters import CONSTANTS, time_unit

_SECONDS = {"N m": -2, "N m/rad": -2, "N m/rad^3": -2, "N m s": -1, "N m/s": -3, "rad/s": -1, "s": 1, "s^2": 2}
"""The power of a second in each unit, torques being over A22; in those that are not here it is zero."""
_TYPICAL_UNIT = time_unit(*(constant.nominal for constant in CONSTANTS))
"""Time unit of the rig for which typical values are given: the paper's [s]."""


class Known(NamedTuple):
    """A normal distribution of a model's values; those with no precision may be anything."""

    precision: Array
    """(unknowns, unknowns)"""
    centre: Array
    """(unknowns,)"""
    logarithm: float
    """Of the determinant of the covariance, of what is known."""

    def rows(self, values: Array) -> Array:
        """Return rows (k, unknowns + 1) whose squares are what is known, by changes of the values, and at them."""
        sizes, vectors = np.linalg.eigh(self.precision)
        roots = np.sqrt(np.maximum(sizes, 0.0))[:, None] * vectors.T
        return np.column_stack([roots, roots @ (values - self.centre)])


def known_before(model: MotionModel) -> Known:
    """Return what is known of a model's values before any trial."""
    end = len(model.names) - sum(len(active.fitted) for active in model.effects)
    centre, precision = (of[:end] for of in model.known)
    unit = time_unit(model.mechanism.length, model.mechanism.gravity)
    blocks, centres = list[Array]([np.diag(precision)]), list[Array]([centre])
    for active in model.effects:
        of_effect, its_centre = known_of(active, unit)
        blocks.append(of_effect)
        centres.append(its_centre)
    determinants = (np.linalg.slogdet(block[np.ix_(*[np.diag(block) > 0.0] * 2)])[1] for block in blocks)
    return Known(block_diag(*blocks), np.concatenate(centres), -float(sum(determinants)))


def known_of(active: ActiveEffect, unit: float) -> tuple[Array, Array]:
    """Return precision (k, k) and centre (k,) of an effect's fitted parameters on a rig with a time unit [s]."""
    centre = np.array([typical(p, unit) if p.shape and np.isfinite(_width(p, unit)) else 0.0 for p in active.fitted])
    precision = np.diag([_width(parameter, unit) ** -2 for parameter in active.fitted])
    if active.effect.curve is not None:
        precision = precision + np.max(np.diag(precision)) / active.bend**2 * bending(active.effect.curve)
    return precision, centre


def typical(parameter: EffectParameter, unit: float) -> float:
    """Return a parameter's typical value on a rig with a time unit [s]."""
    scaled = parameter.typical * (unit / _TYPICAL_UNIT) ** _SECONDS.get(parameter.unit, 0)
    return float(min(max(scaled, parameter.lower), parameter.upper))


def _width(parameter: EffectParameter, unit: float) -> float:
    """Return the standard deviation of a parameter's value beforehand."""
    return parameter.prior_width * (unit / _TYPICAL_UNIT) ** _SECONDS.get(parameter.unit, 0)


def bending(curve: Curve) -> Array:
    """Return the form (count, count) that is the sum of squares of a curve's second differences."""
    identity = np.eye(curve.count)
    if curve.over == "angle":
        bends = np.roll(identity, -1, axis=0) - 2.0 * identity + np.roll(identity, 1, axis=0)
    else:
        bends = np.diff(identity, 2, axis=0)
    return np.asarray(bends.T @ bends)

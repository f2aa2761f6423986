# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From the base parameters (and, with weights, A22) to the nearest of all physical values that have them.

Of all physical parameters that have the fitted base parameters, those are chosen that lie closest to what was known
before: close in the logarithm, each parameter measured by its own uncertainty. They are positive, and no rod has a
larger moment of inertia than its mass and length allow.
"""

import warnings
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from cdp_ident.arrays import Array, Mask
from cdp_ident.fit.prior import FARTHEST, KNOWN_RELATIVE_STD, Prior
from cdp_ident.model.acting import outer_rod_length
from cdp_ident.model.parameters import GROUPS, SYMBOLS, groups_of, inertia_about_cart

_FRICTIONS = np.array([symbol in ("c1", "c2") for symbol in SYMBOLS])
_FRICTION_GROUPS = np.array([group.symbol.startswith("c") for group in GROUPS])
_PLACES = {symbol: place for place, symbol in enumerate(SYMBOLS)}
_MET = 1e-6
"""A condition counts as met when the logarithms of what it compares differ by less."""
CONFIDENCE = 1.96
"""Half width of a 95 % interval, in standard deviations."""
_WIDEST = 0.5
"""Half width of the interval, as a share of the value, from which on a value counts as not determined."""


@dataclass(frozen=True)
class PhysicalValues:
    """The chosen member of the family."""

    values: Array
    """(9,) physical values in the order of `SYMBOLS`."""
    std: Array
    """(9,) their standard deviations, the nominal values' own uncertainties included."""
    determined: Mask
    """(9,) whether trials and measured values determine the value, or the nominal values had to."""
    inertia_relative_std: float
    """Relative standard deviation of their A22, to which all torques of the model are relative."""
    inertia_std_once_weighed: float
    """The same, were the outer rod's mass known."""
    possible: bool
    """Whether a mechanism with these base parameters was found; if not, the values are those known before."""


def is_determined(value: float, std: float) -> bool:
    """Return whether the 95 % interval of a value stays within half the value to either side."""
    return bool(CONFIDENCE * std < _WIDEST * abs(value))


def shown_by_trials(values: Array, length: float, with_inertia: bool) -> Array:
    """Return the base parameters (..., 5) of physical values (..., 9), followed by 1 / A22 (..., 6) with weights."""
    groups = groups_of(values, length)
    return np.concatenate([groups, 1.0 / inertia_about_cart(values, length)[..., None]], -1) if with_inertia else groups


def nearest_physical_values(shown: Array, covariance: Array, prior: Prior, length: float) -> PhysicalValues:
    """Choose the physical values with given base parameters that lie closest to the prior.

    Args:
        shown: (5,) fitted base parameters, or (6,) with 1 / A22, where weights show it.
        covariance: (5, 5) or (6, 6) their covariance.
        prior: nominal and known values and their uncertainties.
        length: L [m].
    """
    centre, deviations = prior.centre, prior.relative_std
    searched = (centre > 0) & ~_FRICTIONS
    groups, with_inertia = shown[: len(GROUPS)], len(shown) > len(GROUPS)
    inertial = ~np.append(_FRICTION_GROUPS, False)[: len(shown)]

    def physical(logarithms: Array) -> Array:
        values = centre.copy()
        values[searched] *= np.exp(logarithms)
        values[_FRICTIONS] = 1.0
        # The frictions follow from their base parameters, which are relative to the inertia that the others make.
        values[_FRICTIONS] = groups[_FRICTION_GROUPS] / groups_of(values, length)[_FRICTION_GROUPS]
        return values

    def mismatch(logarithms: Array) -> Array:
        return np.log(shown_by_trials(physical(logarithms), length, with_inertia)[inertial] / shown[inertial])

    def room_for_inertia(logarithms: Array) -> Array:
        m1, m2, _, l1, l2, J1, J2, *_ = physical(logarithms)
        # Mass spread over an interval varies about its centre by no more than (end - centre)(centre - beginning)
        # (Bhatia and Davis, 2000). The outer rod's length is not a parameter: it is at least twice l2, or L.
        outer_length = outer_rod_length(length, l2)
        return np.array([np.log(m1 * l1 * max(length - l1, 1e-9) / J1), np.log(m2 * l2 * (outer_length - l2) / J2)])

    def slopes_of_mismatch(logarithms: Array) -> Array:
        # What trials show of the inertias does not depend on the frictions.
        return logarithmic_derivatives(physical(logarithms), length, with_inertia)[inertial][:, searched]

    def slopes_of_room(logarithms: Array) -> Array:
        _, _, _, l1, l2, *_ = physical(logarithms)
        slopes = np.zeros((2, len(SYMBOLS)))
        slopes[0, _PLACES["m1"]] = slopes[1, _PLACES["m2"]] = 1.0
        slopes[0, _PLACES["J1"]] = slopes[1, _PLACES["J2"]] = -1.0
        slopes[0, _PLACES["l1"]] = 1.0 - (l1 / (length - l1) if length - l1 > 1e-9 else 0.0)
        slopes[1, _PLACES["l2"]] = 1.0 - l2 / (length - l2) if length > 2.0 * l2 else 2.0
        return slopes[:, searched]

    scale = deviations[searched]
    count = int(searched.sum())
    with warnings.catch_warnings():
        # Rounding takes its steps beyond the bounds, from where they are brought back.
        warnings.filterwarnings("ignore", "Values in x were outside bounds", RuntimeWarning)
        result = minimize(
            lambda z: float(z @ z),
            np.zeros(count),
            jac=lambda z: 2 * z,
            method="SLSQP",
            bounds=[(-FARTHEST, FARTHEST)] * count,
            constraints=[
                {
                    "type": "eq",
                    "fun": lambda z: mismatch(z * scale),
                    "jac": lambda z: slopes_of_mismatch(z * scale) * scale,
                },
                {
                    "type": "ineq",
                    "fun": lambda z: room_for_inertia(z * scale),
                    "jac": lambda z: slopes_of_room(z * scale) * scale,
                },
            ],
            # A smaller change is rounding, below which the method goes on until it has made all its iterations.
            options={"maxiter": 300, "ftol": 1e-11},
        )
    # Not by whether the method says that it has converged: at the minimum, rounding may keep it from noticing.
    found = result.x * scale
    possible = bool(np.max(np.abs(mismatch(found))) < _MET and np.min(room_for_inertia(found)) > -_MET)
    values = physical(found) if possible else centre
    return PhysicalValues(values, *_uncertainty(values, shown, covariance, prior, length), possible)


def logarithmic_derivatives(values: Array, length: float, with_inertia: bool = False) -> Array:
    """Return the derivatives of the logarithms of what trials show with respect to the values' logarithms.

    They are (5, 9), or (6, 9) with weights; see `shown_by_trials`.
    """
    step = 1e-6
    shifted = np.exp(step * np.concatenate([np.eye(len(values)), -np.eye(len(values))])) * values
    with np.errstate(divide="ignore", invalid="ignore"):
        logarithms = np.log(shown_by_trials(shifted, length, with_inertia))
        derivatives = (logarithms[: len(values)] - logarithms[len(values) :]).T / (2 * step)
    return np.nan_to_num(derivatives)


def _uncertainty(
    values: Array, shown: Array, shown_covariance: Array, prior: Prior, length: float
) -> tuple[Array, Mask, float, float]:
    """Return standard deviations (9,), what is determined, and the relative one of A22, now and with a rod weighed.

    All are linearised about the values.
    """
    seen = shown > 0
    derivatives = logarithmic_derivatives(values, length, len(shown) > len(GROUPS))[seen]
    relative = shown_covariance[np.ix_(seen, seen)] / np.outer(shown[seen], shown[seen])
    relative = np.where(np.isfinite(relative), relative, 0.0) + np.diag(
        np.where(np.isfinite(np.diag(relative)), 0.0, FARTHEST**2)
    )

    def posterior(spread: Array) -> Array:
        gain = spread @ derivatives.T @ np.linalg.pinv(derivatives @ spread @ derivatives.T + relative, hermitian=True)
        return spread - gain @ derivatives @ spread

    def std_of(covariance: Array) -> Array:
        return np.sqrt(np.maximum(np.diag(covariance), 0.0))

    without_nominal = np.where(prior.is_known, prior.relative_std, FARTHEST)
    # A friction of zero has no logarithm: its deviation is that of its base parameter.
    inertia = values[~_FRICTIONS]
    covariance = posterior(prior.covariance)
    std = std_of(covariance) * values
    determined = CONFIDENCE * std_of(posterior(np.diag(without_nominal**2))) < _WIDEST
    step = np.exp(1e-6 * np.eye(len(values)))
    by_values = np.log(inertia_about_cart(step * values, length) / inertia_about_cart(values, length)) / 1e-6
    with_inertia, rod = covariance @ by_values, _PLACES["m2"]
    variance = by_values @ with_inertia
    once_weighed = variance - with_inertia[rod] ** 2 / (covariance[rod, rod] + KNOWN_RELATIVE_STD**2)
    inertia_std, inertia_std_once_weighed = (float(np.sqrt(max(v, 0.0))) for v in (variance, once_weighed))
    for friction, group in zip(np.flatnonzero(_FRICTIONS), np.flatnonzero(_FRICTION_GROUPS), strict=True):
        if shown[group] <= 0:
            A22 = groups_of(np.array([*inertia, 1.0, 1.0]), length)[group] ** -1
            std[friction] = np.sqrt(shown_covariance[group, group]) * A22
    return std, determined & (prior.centre > 0), inertia_std, inertia_std_once_weighed

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Eq. (10) over windows of trials: what the genetic search makes small."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import groupby

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.windows import Window
from cdp_ident.model.parameters import coefficients_of, groups_of, inertia_about_cart
from cdp_ident.model.population import Population, Segment
from cdp_ident.model.weights import Weight, added_by
from cdp_ident.search.options import IGA

SHORT_IGA = replace(IGA, population=64, generations=2)
"""The improved algorithm cut short: whole swings are fitted from its result."""
PAPER_SPAN = 10.0
"""How long one simulation of the paper's search is [s] (Section 4.2)."""


def search_objective(windows: Sequence[Window], span: float, prior: Prior) -> Callable[[Array], Array]:
    """Return Eq. (10) as a function of chromosomes (n, 9), over segments of the windows' trials.

    Args:
        windows: the windows whose samples count, in the order of time; those held out are not among them.
        span: length of a segment [s]: from the initial state of one window, the motion is simulated for so long.
        prior: gives L and g.
    """
    segments: dict[tuple[Weight, ...], list[Segment]] = {}
    for _, of_trial in groupby(windows, key=lambda window: window.trial):
        run: list[Window] = []
        for window in of_trial:
            if run and window.begin + window.duration - run[0].begin > span * (1 + 1e-3) + 0.5 * window.duration:
                segments.setdefault(window.weights, []).append(_segment(run))
                run = []
            run.append(window)
        segments.setdefault(run[0].weights, []).append(_segment(run))
    populations = {weights: Population(alike, windows[0].grid.step) for weights, alike in segments.items()}

    def objective(chromosomes: Array) -> Array:
        error = np.zeros(len(chromosomes))
        for weights, population in populations.items():
            coefficients = weighted_coefficients(chromosomes, weights, prior)
            inertia = inertia_about_cart(chromosomes, prior.length) + added_by(weights, prior.length)[0]
            error += population.squared_errors(coefficients, inertia).sum(axis=1)
        return error

    return objective


def weighted_coefficients(chromosomes: Array, weights: tuple[Weight, ...], prior: Prior) -> Array:
    """Return the coefficients (n, 7) of chromosomes (n, 9) with weights on the rods; the prior gives L and g."""
    length = prior.length
    groups, inertia = groups_of(chromosomes, length), inertia_about_cart(chromosomes, length)[:, None]
    added = added_by(weights, length)
    weighted = (inertia * groups + added[1:]) / (inertia + added[0]) if weights else groups
    return coefficients_of(weighted, length, prior.gravity)


def _segment(run: Sequence[Window]) -> Segment:
    beginning = run[0].begin
    torques = [window.torques for window in run if window.torques is not None]
    return Segment(
        start=run[0].start,
        time=np.concatenate([window.begin - beginning + window.time for window in run]),
        theta=np.concatenate([window.theta for window in run]),
        cart_acceleration=np.concatenate([window.cart_acceleration for window in run]),
        torques=np.concatenate(torques) if len(torques) == len(run) else None,
    )

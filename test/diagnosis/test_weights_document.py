# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The tables of docs/how_to/weights.md, made anew from the ranks of what trials show."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.physical import nearest_physical_values, shown_by_trials
from cdp_ident.fit.prior import Mechanism, Prior
from cdp_ident.model.parameters import SYMBOLS
from cdp_ident.model.weights import Weight
from reference.pendulum import TABLE_5
from scenarios.paper_rig import A22, LENGTH, PHYSICAL

DOCUMENT = (Path(__file__).parents[2] / "docs/how_to/weights.md").read_text()
INNER, OUTER = Weight("inner", 0.08, 0.25), Weight("outer", 0.05, 0.3)
MEASURED = ((), ("m2",), ("l2",), ("m0", "l2"), ("m1", "m2", "m0"), ("m1", "m2", "m0", "l1"))
PLACES = {"none": (), "on the inner rod": (INNER,), "on the outer rod": (OUTER,), "on both": (INNER, OUTER)}
FITTED = {
    "": {},
    "L": {"length_std": np.inf},
    "g": {"gravity_std": np.inf},
    "L and g": {"length_std": np.inf, "gravity_std": np.inf},
}


def listed(names):
    return ", ".join(f"`{name}`" for name in names) or "–"


def row(*cells):
    return f"| {' | '.join(cells)} |"


def determined_values(known, weighted):
    """Return which of the nine values become determined beside those that are known."""
    shown = shown_by_trials(PHYSICAL, LENGTH, weighted)
    prior = Prior(known={symbol: TABLE_5[symbol] for symbol in known})
    found = nearest_physical_values(shown, np.diag((1e-3 * shown) ** 2), prior, LENGTH)
    return [symbol for symbol, sure in zip(SYMBOLS, found.determined, strict=True) if sure and symbol not in known]


def determined_unknowns(weights, free):
    """Return the unknowns that trials without and with weights determine: those in no direction that changes nothing.

    A motion depends on the coefficients, on first moments only times g.
    """
    model = replace(MotionModel(Mechanism.of(Prior())), inertia_free=bool(weights), **free)
    values = model.initial_values(shown_by_trials(PHYSICAL, LENGTH, False), A22)

    def seen(values):
        coefficients = [
            model.coefficients(model.with_weights(values, of_trial).values) for of_trial in {(): 0, weights: 0}
        ]
        return np.log([(A23, A33, a1 * g, c1, c2, m2_l2 * g) for A23, A33, a1, c1, c2, m2_l2, g in coefficients])

    step = 1e-5
    moves = np.exp(step * np.eye(len(values)))
    slopes = np.array([(seen(values * move) - seen(values / move)).ravel() / (2 * step) for move in moves]).T
    _, singular, directions = np.linalg.svd(slopes)
    unseen = directions[np.count_nonzero(singular > 1e-6 * singular[0]) :]
    return [name for name, moved in zip(model.names, np.abs(unseen).sum(axis=0), strict=True) if moved < 1e-4]


def test_the_table_of_physical_values_is_that_of_the_ranks():
    for known in MEASURED:
        line = row(listed(known), *(listed(determined_values(known, weighted)) for weighted in (False, True)))
        assert line in DOCUMENT, line


def test_the_table_of_places_is_that_of_the_ranks():
    def shown(name):
        return {"one_over_A22": "A22"}.get(name, name)

    all_groups = len(determined_unknowns((), {}))
    for fitted, free in FITTED.items():
        cells = []
        for weights in PLACES.values():
            names = determined_unknowns(weights, free)
            groups = [name for name in names if name.endswith("_over_A22") and name != "one_over_A22"]
            rest = [shown(name) for name in names if name not in groups]
            cells.append(
                ", ".join(["all base parameters" if len(groups) == all_groups else "base parameters but a1/A22", *rest])
            )
        assert row(f"`{fitted}`" if fitted else "–", *cells) in DOCUMENT, row(fitted, *cells)

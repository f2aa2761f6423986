# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The paper's own search problem, on a twin: what its two algorithms are compared on (Section 4)."""

from collections.abc import Callable

import numpy as np

from cdp_ident.model.parameters import PARAMETERS, coefficients_of, groups_of
from cdp_ident.model.population import Population, Segment
from reference.pendulum import TABLE_2, TABLE_3, Array
from scenarios.twin import twin

LOWER = np.array([parameter.nominal * parameter.lower_factor for parameter in PARAMETERS])
UPPER = np.array([parameter.nominal * parameter.upper_factor for parameter in PARAMETERS])
PAPER_IGA_ERROR = 0.8515
"""The best error of the paper's improved algorithm, on a trajectory that was not published (Table 5) [rad^2]."""


def twin_objective(rng: np.random.Generator) -> Callable[[Array], Array]:
    """Return Eq. (10) of chromosomes (n, 9) over the standard twin, followed from the paper's exact start."""
    trial = twin(rng)
    population = Population([Segment(np.array(TABLE_3), trial.time, trial.theta)])

    def objective(chromosomes: Array) -> Array:
        groups = groups_of(chromosomes, TABLE_2["L"])
        return population.squared_errors(coefficients_of(groups, TABLE_2["L"], TABLE_2["g"]))[:, 0]

    return objective

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The paper's own setting: one trial followed from a start that is known exactly, the parameters anywhere in the box.

What search and the fit of whole swings make of it is compared with other optimizers, on the same twin from the same
seed, until each of them is as close to the measured angles as the true parameters are, give or take 5 %.
"""

from dataclasses import dataclass

import numpy as np

from cdp_ident.fit.force_balance import Pieces, balance_of_forces
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.objective import SHORT_IGA, search_objective
from cdp_ident.fit.prior import Mechanism, Prior
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.likelihood.gauss_newton import GaussNewton
from cdp_ident.likelihood.maxima import CLOSE_ENOUGH, ENOUGH_STEPS, NEAR
from cdp_ident.likelihood.noise import Noise
from cdp_ident.likelihood.swing import Swing
from cdp_ident.likelihood.whole_swing import Recorded
from cdp_ident.model.parameters import coefficients_of, groups_of, physical_coefficients, time_unit
from cdp_ident.model.population import Population, Segment
from cdp_ident.model.time_grid import DEFAULT_STEP as STEP
from cdp_ident.search.genetic_search import genetic_search
from cdp_ident.trial.trial import Trial
from reference.pendulum import TABLE_3, TABLE_5, Array
from scenarios.twin import standard_twin

CLOSE = 1.05
"""Squared error over the truth's own at which an optimizer has arrived."""
NOISE, STEPS = 2e-3, np.full(2, 2.0 * np.pi / 8000)
"""Of the twin's encoders [rad]."""
_MOST_STEPS = 10
PRIOR = Prior()
MODEL = MotionModel(Mechanism.of(PRIOR))


@dataclass(frozen=True)
class StartGiven:
    """A twin whose start is known."""

    trial: Trial
    population: Population
    """Simulates from the known start over the whole trial."""
    truth_error: float
    """Squared error of the true parameters, Eq. (10) [rad^2]."""

    @classmethod
    def of(cls, seed: int) -> "StartGiven":
        """Make the twin of a seed."""
        trial = standard_twin(np.random.default_rng(seed))
        population = Population([Segment(np.array(TABLE_3), trial.time, trial.theta)])
        error = float(population.squared_errors(physical_coefficients(TABLE_5)[None])[0, 0])
        return cls(trial, population, error)


@dataclass(frozen=True)
class Arrival:
    """What it took to find the parameters."""

    relative_error: float
    """Squared error over the truth's own."""
    simulations: float
    """Simulations of the whole trial without derivatives."""
    passes: float = 0.0
    """Simulations of the whole trial with derivatives."""


def search_and_fit(problem: StartGiven, rng: np.random.Generator) -> Arrival:
    """Search the box in windows, fit the whole swing from there, then follow it from its start until close enough."""
    windows = cut_into_windows([problem.trial])
    found = genetic_search(search_objective(windows, 0.0, PRIOR), *PRIOR.box, SHORT_IGA, rng)
    return _fitted(problem, groups_of(found.best, PRIOR.length), found.evaluations)


def balance_and_fit(problem: StartGiven) -> Arrival:
    """Fit from a balance of forces, which simulates nothing, as `search_and_fit` does from the search's best."""
    balance = balance_of_forces(Pieces.of([problem.trial], PRIOR.length, PRIOR.gravity))
    return _fitted(problem, balance.groups, 0)


def _fitted(problem: StartGiven, groups: Array, evaluations: int) -> Arrival:
    unit = time_unit(PRIOR.length, PRIOR.gravity)
    nodes = Swing.of(problem.trial, 0, STEP, NEAR * unit)
    recorded = Recorded(tuple(nodes), np.full(2, NOISE), STEPS, unit)
    states = [swing.states(MODEL) for swing in nodes]
    noise = Noise.white(recorded.encoders, recorded.large_torque)
    found = GaussNewton(MODEL, groups, recorded, states, noise, CLOSE_ENOUGH).run(ENOUGH_STEPS).found()
    # Its start is known: the whole trial is one piece.
    (whole,) = Swing.of(problem.trial, 0, STEP, problem.trial.duration)
    values, steps = found.values, 0
    while (error := _error(problem, values)) > CLOSE and steps < _MOST_STEPS:
        linear = whole.linearised(MODEL, values, np.array([TABLE_3]))
        by_values = np.cumsum(linear.slopes[..., MODEL.states :], axis=1).reshape(-1, len(values))
        off = np.cumsum(linear.residuals, axis=1).ravel()
        values, steps = values - np.linalg.lstsq(by_values, off)[0], steps + 1
    return Arrival(error, evaluations, found.steps + steps)


def _error(problem: StartGiven, values: Array) -> float:
    coefficients = coefficients_of(values, PRIOR.length, PRIOR.gravity)
    return float(problem.population.squared_errors(coefficients[None])[0, 0]) / problem.truth_error

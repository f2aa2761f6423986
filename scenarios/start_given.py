"""The paper's own setting: one trial followed from a start that is known exactly, the parameters anywhere in the box.

What search and refinement make of it is compared with other optimizers, on the same twin from the same seed, until
each of them is as close to the measured angles as the true parameters are, give or take 5 %.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cdp_ident.fit.force_balance import Pieces, balances_of
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.objective import SHORT_IGA, search_objective
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.refinement import refine
from cdp_ident.fit.windows import Window, as_one_window, cut_into_windows
from cdp_ident.model.parameters import groups_of, physical_coefficients
from cdp_ident.model.population import Population, Segment
from cdp_ident.search.genetic_search import genetic_search
from cdp_ident.trial.trial import Trial
from reference.pendulum import TABLE_3, TABLE_5, Array
from scenarios.twin import standard_twin

CLOSE = 1.05
"""Squared error over the truth's own at which an optimizer has arrived."""
PRIOR = Prior()
MODEL = MotionModel(Mechanism.of(PRIOR))


@dataclass(frozen=True)
class StartGiven:
    """A twin whose start is known."""

    trial: Trial
    whole: Window
    """The trial as one window, beginning with the known start."""
    population: Population
    """Simulates from the known start over the whole trial."""
    truth_error: float
    """Squared error of the true parameters, Eq. (10) [rad^2]."""

    @classmethod
    def of(cls, seed: int) -> "StartGiven":
        """Make the twin of a seed."""
        trial = standard_twin(np.random.default_rng(seed))
        whole = as_one_window(trial, 0)
        population = Population([Segment(np.array(TABLE_3), trial.time, trial.theta)])
        error = float(population.squared_errors(physical_coefficients(TABLE_5)[None])[0, 0])
        return cls(trial, replace(whole, start=np.array(TABLE_3), start_known=True), population, error)


@dataclass(frozen=True)
class Arrival:
    """What it took to find the parameters."""

    relative_error: float
    """Squared error over the truth's own."""
    simulations: float
    """Simulations of the whole trial without derivatives."""
    passes: float = 0.0
    """Simulations of the whole trial with derivatives."""


def search_and_refine(problem: StartGiven, rng: np.random.Generator) -> Arrival:
    """Search the box in windows, refine there, then follow the whole trial from its start until close enough."""
    windows = cut_into_windows([problem.trial])
    found = genetic_search(search_objective(windows, 0.0, PRIOR), *PRIOR.box, SHORT_IGA, rng)
    return _refined(problem, windows, groups_of(found.best, PRIOR.length), found.evaluations)


def balance_and_refine(problem: StartGiven) -> Arrival:
    """Refine from a balance of forces, which simulates nothing, as `search_and_refine` does from the search's best."""
    balance, *_ = balances_of(Pieces.of([problem.trial], PRIOR.length, PRIOR.gravity))
    return _refined(problem, cut_into_windows([problem.trial]), balance.groups, 0)


def _refined(problem: StartGiven, windows: Sequence[Window], groups: Array, evaluations: int) -> Arrival:
    in_windows = refine(MODEL, MODEL.initial_values(groups), windows)
    close = np.sqrt(CLOSE * problem.truth_error / problem.whole.theta.size)
    fit = refine(MODEL, in_windows.values, [problem.whole], stop=lambda rmse: rmse < close)
    return Arrival(fit.squared_error / problem.truth_error, evaluations, in_windows.simulations + fit.simulations)

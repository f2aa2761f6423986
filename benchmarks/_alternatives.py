# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Other optimizers on the problem of `scenarios.start_given`, each until it has arrived.

pycma and differential evolution simulate with this package's compiled population, which flatters them; least squares
integrates its compiled equations by scipy, and MuJoCo's system identification simulates with its own engine.
"""

import contextlib
import warnings
from collections.abc import Callable

import numpy as np
from scipy.optimize import differential_evolution, least_squares

from benchmarks import _mujoco
from benchmarks.simulation import by_scipy
from cdp_ident.model.parameters import SYMBOLS, coefficients_of, groups_of
from reference.pendulum import TABLE_2, TABLE_3, Array
from scenarios.start_given import CLOSE, PRIOR, Arrival, StartGiven

LOWER, UPPER = PRIOR.box
MOST_SIMULATIONS = 172_200
"""As many as the paper's improved algorithm makes."""


class _EndError(Exception):
    """Ends an optimizer that has no other way to be told that it has arrived."""


class _Counted:
    """Counts simulations of a problem, and keeps the least squared error, over the truth's own."""

    def __init__(self, problem: StartGiven) -> None:
        self._problem = problem
        self.simulations, self.best = 0, float("inf")

    def errors(self, chromosomes: Array) -> Array:
        """Return the squared error of chromosomes (n, 9), over the truth's own."""
        errors = self._problem.population.squared_errors(coefficients(chromosomes))[:, 0] / self._problem.truth_error
        self.take(float(errors.min()), len(chromosomes))
        return errors

    def take(self, error: float, simulations: int = 1) -> None:
        """Note what so many simulations came to."""
        self.simulations += simulations
        self.best = min(self.best, error)

    @property
    def ends(self) -> bool:
        """Whether it has arrived, or is given up."""
        return self.best < CLOSE or self.simulations >= MOST_SIMULATIONS

    @property
    def arrival(self) -> Arrival:
        """What it came to."""
        return Arrival(self.best, self.simulations)


def coefficients(chromosomes: Array) -> Array:
    """Return the coefficients (n, 7) of chromosomes (n, 9)."""
    return coefficients_of(groups_of(chromosomes, PRIOR.length), PRIOR.length, PRIOR.gravity)


def evenly(x: Array) -> Array:
    """Return the chromosomes (n, 9) of points in the unit box."""
    return LOWER + (UPPER - LOWER) * x


def logarithmically(x: Array) -> Array:
    """Return the chromosomes (n, 9) of points in the unit box, which is that of their logarithms."""
    return np.asarray(LOWER * (UPPER / LOWER) ** x)


def by_pycma(problem: StartGiven, seed: int, spread: Callable[[Array], Array] = evenly) -> Arrival:
    """Restart CMA-ES until it has arrived; `spread` takes the unit box to the parameters'."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # that it cannot plot
        import cma  # type: ignore[import-untyped]  # noqa: PLC0415 - where it can, it loads all of matplotlib

    counted, restart = _Counted(problem), 0
    while not counted.ends:
        restart += 1
        options = {"bounds": [0, 1], "verbose": -9, "seed": 1000 * seed + restart}
        strategy = cma.CMAEvolutionStrategy(len(LOWER) * [0.5], 0.3, options)
        while not counted.ends and not strategy.stop():
            points = strategy.ask()
            strategy.tell(points, (problem.truth_error * counted.errors(spread(np.array(points)))).tolist())
    return counted.arrival


def by_differential_evolution(problem: StartGiven, seed: int) -> Arrival:
    """Use scipy's differential evolution as it comes, whole generations at once."""
    counted = _Counted(problem)
    differential_evolution(
        lambda points: counted.errors(points.T.reshape(-1, len(LOWER))),
        list(zip(LOWER, UPPER, strict=True)),
        seed=seed,
        vectorized=True,
        updating="deferred",
        callback=lambda *_, **__: counted.ends,
    )
    return counted.arrival


def by_least_squares(problem: StartGiven, seed: int) -> Arrival:
    """Use scipy alone: least squares over its integrator, from somewhere in the box."""
    counted = _Counted(problem)
    times, theta = problem.trial.time, problem.trial.theta

    def residuals(x: Array) -> Array:
        error = (by_scipy(coefficients(evenly(x)), np.array(TABLE_3), times)[:, :2] - theta).ravel()
        counted.take(float(error @ error) / problem.truth_error)
        if counted.ends:
            raise _EndError
        return np.asarray(error)

    with contextlib.suppress(_EndError):
        least_squares(residuals, np.random.default_rng(seed).uniform(size=len(LOWER)), bounds=(0.0, 1.0))
    return counted.arrival


def by_mujoco(problem: StartGiven, seed: int) -> Arrival:
    """Use `mujoco.sysid`, from somewhere in the box."""
    counted = _Counted(problem)
    drawn = np.random.default_rng(seed).uniform(LOWER, UPPER)

    def watch(chromosomes: Array) -> None:
        counted.errors(chromosomes)
        if counted.ends:
            raise _EndError

    with contextlib.suppress(_EndError):
        initial = TABLE_2 | dict(zip(SYMBOLS, map(float, drawn), strict=True))
        _mujoco.identify(problem.trial.time, problem.trial.theta, np.array(TABLE_3), initial, LOWER, UPPER, watch)
    return counted.arrival

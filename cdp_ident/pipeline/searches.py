# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The paper's two genetic algorithms on the same trials, each with several seeds."""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.configuration.settings import Settings
from cdp_ident.fit.data import noise_over
from cdp_ident.fit.objective import PAPER_SPAN, search_objective, weighted_coefficients
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.scales import scales_of
from cdp_ident.fit.windows import Window, beginning_of
from cdp_ident.model.motions import simulate
from cdp_ident.pipeline.job import load
from cdp_ident.report.outcome import Job
from cdp_ident.search.genetic_search import Progress, genetic_search
from cdp_ident.search.options import GeneticOptions

_METHODS = ("tga", "iga")


@dataclass(frozen=True)
class Course:
    """One search from its first population to its end."""

    seed: int
    generations: tuple[Progress, ...]
    """After the first population, and after each generation."""
    seconds: float
    """That it took [s]."""

    @property
    def end(self) -> Progress:
        """What it came to."""
        return self.generations[-1]


@dataclass(frozen=True)
class Algorithm:
    """One algorithm's searches, which differ by the seed."""

    name: str
    options: GeneticOptions
    courses: tuple[Course, ...]
    """By their last error, the best first."""
    typical: Course
    """The one in the middle."""
    simulated: tuple[Array, ...]
    """(n, 2) angles in each window with the best chromosome of the typical search [rad]."""


@dataclass(frozen=True)
class Searches:
    """Both algorithms on the same motion."""

    trials: tuple[str, ...]
    """Names."""
    windows: tuple[Window, ...]
    """What is searched of each trial."""
    noise_error: float
    """What the encoders' noise alone leaves [rad^2]."""
    length: float
    """L [m]."""
    algorithms: tuple[Algorithm, Algorithm]
    """The traditional one and the improved one."""


def search_by_both(bags: Sequence[Path], given: Mapping[str, Any], seeds: int, say: Callable[[str], None]) -> Searches:
    """Search the box of Eq. (9) by both algorithms, over the first 10 s of each trial (Section 4.2).

    Args:
        bags: whose trials are searched jointly.
        given: settings of an identification by name; those of the search replace the paper's of either algorithm.
        seeds: how many searches of each.
        say: called with a line of text after each search.

    Raises:
        OptionError: a setting is not usable.
        BagError: a bag cannot be read.
        TrialError: a bag holds no trial.
        IdentificationError: no trial is long enough.
    """
    by_method = {method: Settings.of({**given, "method": method}) for method in _METHODS}
    settings = by_method[_METHODS[0]]
    trials = load(Job(tuple(bags), (), settings)).fit
    prior, noise = settings.identify.prior, noise_over(trials)
    scales = scales_of(trials, prior.length, prior.gravity)
    windows = [beginning_of(trial.stretches[0], index, PAPER_SPAN, scales.step) for index, trial in enumerate(trials)]
    objective = search_objective(windows, PAPER_SPAN, prior)
    algorithms = []
    for method, its in by_method.items():
        courses = []
        for seed in range(1, seeds + 1):
            generations: list[Progress] = []
            began = time.monotonic()
            genetic_search(objective, *prior.box, its.identify.search, np.random.default_rng(seed), generations.append)
            courses.append(Course(seed, tuple(generations), time.monotonic() - began))
            end = courses[-1].end
            say(
                f"{method.upper()}, seed {seed}: {end.error:.4g} rad² after {end.generation} generations, "
                f"{courses[-1].seconds:.1f} s"
            )
        courses.sort(key=lambda course: course.end.error)
        typical = courses[(len(courses) - 1) // 2]
        simulated = tuple(_simulated(typical.end.best, window, prior) for window in windows)
        algorithms.append(Algorithm(method.upper(), its.identify.search, tuple(courses), typical, simulated))
    return Searches(
        tuple(trial.name for trial in trials),
        tuple(windows),
        float(np.sum(noise**2) * sum(len(window.time) for window in windows)),
        prior.length,
        (algorithms[0], algorithms[1]),
    )


def _simulated(chromosome: Array, window: Window, prior: Prior) -> Array:
    """Return the angles (n, 2) of a window as a chromosome has them [rad]."""
    coefficients = weighted_coefficients(chromosome[None], window.weights, prior)[0]
    return simulate(coefficients, window.start, window.time, window.u, window.grid.step)[:, :2]

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The paper's two algorithms side by side, as tables and figures: its Tables 4 and 5, Figs. 7 to 9 and 13."""

import statistics
from collections.abc import Iterator

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.model.parameters import GROUPS, SYMBOLS, groups_of
from cdp_ident.pipeline.searches import Algorithm, Searches
from cdp_ident.report.document import Table
from cdp_ident.report.figures.curves import file_name, measured_and_simulated
from cdp_ident.report.figures.description import Axis, Figure, Line, Panel
from cdp_ident.report.wording import Model, group_words
from cdp_ident.search.operators import logarithmic_fitness
from cdp_ident.search.options import GeneticOptions

_IN_PAPER = (1, 20, 40, 60, 80, 100, 200, 300, 400, 500)
"""Generations of its tables."""
_GENERATION = Axis("generation")


def shown_generations(last: int) -> list[int]:
    """Return which generations of a search are shown: those of the paper's tables, and its last one."""
    return [*(generation for generation in _IN_PAPER if generation < last), last]


def fitness(errors: Array, options: GeneticOptions) -> Array:
    """Return H(Z) of Eq. (7)."""
    return logarithmic_fitness(errors, options.fitness_offset, options.fitness_error_limit)


def search_tables(searches: Searches) -> list[Table]:
    """Return what the algorithms found, and the chromosomes of a typical search of each by generation."""
    names = tuple(algorithm.name for algorithm in searches.algorithms)
    seeds = len(searches.algorithms[0].courses)
    return [
        Table(
            f"Last best error E(Z) [rad²], {seeds} searches each",
            ("", "median", "smallest", "largest", "simulations", "time of one [s]"),
            tuple(_ends(algorithm) for algorithm in searches.algorithms),
            f"The encoders' noise alone leaves about {searches.noise_error:.3g} rad². Whatever the paper's model lacks "
            "of this rig adds to that.",
        ),
        *(_by_generation(algorithm) for algorithm in searches.algorithms),
        Table(
            "Best chromosomes and base parameters, mean ± spread",
            ("", *names),
            tuple(_spreads(searches)),
            "Searches that follow the motion equally well differ in the nine values, for it depends on the five base "
            "parameters alone.",
        ),
    ]


def _ends(algorithm: Algorithm) -> tuple[str, ...]:
    errors = [course.end.error for course in algorithm.courses]
    seconds = statistics.median(course.seconds for course in algorithm.courses)
    shown = (statistics.median(errors), errors[0], errors[-1])
    simulations = algorithm.typical.end.evaluations
    return algorithm.name, *(f"{error:.4g}" for error in shown), f"{simulations}", f"{seconds:.3g}"


def _by_generation(algorithm: Algorithm) -> Table:
    course = algorithm.typical
    return Table(
        f"Best chromosome of {algorithm.name} by generation, seed {course.seed}",
        ("G", *SYMBOLS, "E(Z) [rad²]", "H(Z)"),
        tuple(
            (
                str(one.generation),
                *(f"{value:.4g}" for value in one.best),
                f"{one.error:.5g}",
                f"{fitness(np.array(one.error), algorithm.options):.3f}",
            )
            for one in (course.generations[generation] for generation in shown_generations(course.end.generation))
        ),
        f"Of the {len(algorithm.courses)} searches the one in the middle, by its last error.",
    )


def _spreads(searches: Searches) -> list[tuple[str, ...]]:
    columns = []
    for algorithm in searches.algorithms:
        best = np.array([course.end.best for course in algorithm.courses])
        values = np.concatenate([best, groups_of(best, searches.length)], axis=1)
        mean, std = values.mean(axis=0), values.std(axis=0)
        columns.append([f"{m:.4g} ± {100 * s / m:.2g} %" if m else "0" for m, s in zip(mean, std, strict=True)])
    names = [*SYMBOLS, *(group_words(group) for group in GROUPS)]
    return [(name, *cells) for name, *cells in zip(names, *columns, strict=True)]


def search_figures(searches: Searches) -> Iterator[Figure]:
    """Yield the evolution of all searches, then each trial as the typical search of each algorithm follows it."""
    first, other = searches.algorithms
    shown = {Model("before", first.name): first, Model("after", other.name): other}
    errors, fitnesses = ([line for pair in shown.items() for line in _lines(*pair, of)] for of in ("E", "H"))
    generations = errors[0].x
    floor = np.full(len(generations), searches.noise_error)
    errors.append(Line("the encoders' noise alone", "noise", generations, floor, dash="dash"))
    yield Figure(
        "evolution",
        "Evolution of the best chromosome",
        f"Best error and its fitness (Eq. 7) after each generation: thin, each of {len(first.courses)} searches, which "
        "differ by the seed; thick, their median. As the paper's Figs. 7, 9 and 13, which show one search each.",
        [
            Panel(_GENERATION, Axis("best error E(Z) [rad²]", logarithmic=True), errors, height=260),
            Panel(_GENERATION, Axis("fitness H(Z)"), fitnesses),
        ],
        shared_x=True,
    )
    for number, (name, window) in enumerate(zip(searches.trials, searches.windows, strict=True)):
        yield measured_and_simulated(
            f"contrast_{number + 1}_{file_name(name)}",
            f"{name}: measured and simulated, and angular errors",
            "One simulation from the trial's first instant with the best chromosome of a typical search of each. "
            "As the paper's Figs. 8, 10, 11 and 12.",
            window.time,
            window.theta,
            {Model(m.key, f"{a.name}, seed {a.typical.seed}"): a.simulated[number] for m, a in shown.items()},
        )


def _lines(model: Model, algorithm: Algorithm, of: str) -> Iterator[Line]:
    """Yield a line for each search and one for their median: of the errors, or of the fitness H."""
    errors = np.array([[one.error for one in course.generations] for course in algorithm.courses])
    generations = np.arange(errors.shape[1], dtype=float)
    every, median = (
        fitness(some, algorithm.options) if of == "H" else some for some in (errors, np.median(errors, axis=0))
    )
    for values in every:
        yield Line(f"{model.label}, each seed", model.key, generations, values, 0.6)
    yield Line(f"{model.label}, median", model.key, generations, median, 3.0)

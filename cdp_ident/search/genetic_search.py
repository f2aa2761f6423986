# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The genetic search, traditional (TGA) and improved (IGA), as the paper has them (Section 3.6)."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.errors import OptionError
from cdp_ident.search import operators
from cdp_ident.search.options import GeneticOptions

Objective = Callable[[Array], Array]

_USELESS = 1e100
"""Error of a chromosome whose motion cannot be computed: worse than any, and sums of it are still finite."""


@dataclass(frozen=True)
class Progress:
    """What the search tells about itself after each generation."""

    generation: int
    evaluations: int
    best: Array
    """(genes,) best chromosome so far."""
    error: float
    """Its error, Eq. (10) [rad^2]."""


@dataclass(frozen=True)
class SearchResult:
    """What the search has found."""

    best: Array
    """(genes,) best chromosome."""
    error: float
    """Its error, Eq. (10) [rad^2]."""
    evaluations: int
    """Chromosomes whose error was computed."""
    history: tuple[float, ...]
    """Best error so far after the first population and after each generation [rad^2]."""
    stopped: str
    """Why the search ended."""
    completed: bool
    """Whether it ended because all its generations were done."""


def genetic_search(
    objective: Objective,
    lower: Array,
    upper: Array,
    options: GeneticOptions,
    rng: np.random.Generator,
    stop: Callable[[Progress], str | None] = lambda progress: None,
) -> SearchResult:
    """Search the box for the chromosome with the smallest error.

    Args:
        objective: returns the errors (n,) of chromosomes (n, genes), all in one call; not finite means useless.
        lower: (genes,) lower limits; a gene whose limits are equal stays as it is.
        upper: (genes,) upper limits.
        options: the algorithm and its settings; see `GeneticOptions`, `IGA` and `TGA`.
        rng: the only source of chance: the same generator state gives the same result.
        stop: called after each generation; a sentence that it returns ends the search and says why.

    Raises:
        OptionError: the box is empty or not finite.
    """
    lower, upper = np.asarray(lower, dtype=float), np.asarray(upper, dtype=float)
    alike = lower.size > 0 and lower.shape == upper.shape
    if not alike or not np.all(np.isfinite([lower, upper])) or np.any(lower > upper):
        raise OptionError("each gene's lower limit of the search must be finite and not above its upper limit")
    search = _Search(objective, lower, upper, options, rng)
    population = rng.uniform(lower, upper, size=(options.population, len(lower)))
    errors = search.errors_of(population)
    best, error = population[np.argmin(errors)].copy(), float(errors.min())
    history = [error]
    reason = stop(Progress(0, search.evaluations, best, error))
    generation = 0
    while reason is None and generation < options.generations:
        generation += 1
        population, errors = search.next_generation(population, errors)
        if errors.min() < error:
            best, error = population[np.argmin(errors)].copy(), float(errors.min())
        history.append(error)
        reason = stop(Progress(generation, search.evaluations, best, error))
    stopped = reason or f"all {generation} generations done"
    return SearchResult(best, error, search.evaluations, tuple(history), stopped, reason is None)


class _Search:
    """The steps of one generation, over the same box with the same settings."""

    def __init__(
        self, objective: Objective, lower: Array, upper: Array, options: GeneticOptions, rng: np.random.Generator
    ):
        self._objective, self._lower, self._upper = objective, lower, upper
        self._options, self._rng = options, rng
        self._array = operators.orthogonal_array(len(lower))
        self.evaluations = 0

    def errors_of(self, chromosomes: Array) -> Array:
        if len(chromosomes) == 0:
            return np.empty(0)
        self.evaluations += len(chromosomes)
        errors = self._objective(chromosomes)
        return np.where(np.isfinite(errors), errors, _USELESS)

    def next_generation(self, population: Array, errors: Array) -> tuple[Array, Array]:
        """Return the next generation and its errors: Steps 3 to 9."""
        fitness = self._fitness(errors)
        x, y = self._cross(population, fitness)
        if self._options.orthogonal_experiments:
            offspring, experimental, experimental_errors = self._experiment(x, y)
        else:
            offspring = np.concatenate([x, y])[: len(population)]
            experimental, experimental_errors = offspring[:0], np.empty(0)
        if not self._options.elitist_survival:
            # Who was not crossed lives on as often as the roulette says.
            uncrossed = operators.roulette(fitness, len(population) - len(offspring), self._rng)
            offspring = np.concatenate([offspring, population[uncrossed]])
        mutants = self._mutate(offspring, population[np.argmin(errors)], operators.population_fitness(fitness))
        if not self._options.elitist_survival:
            offspring[: len(mutants)] = mutants
            return offspring, self.errors_of(offspring)
        # An experiment that turned out better than the combination of its factors' best levels takes its place.
        new = np.concatenate([offspring, mutants])
        new_errors = self.errors_of(new)
        better = np.flatnonzero(experimental_errors < new_errors[: len(experimental_errors)])
        new[better], new_errors[better] = experimental[better], experimental_errors[better]
        candidates = np.concatenate([population, new])
        candidate_errors = np.concatenate([errors, new_errors])
        survivors = np.argsort(candidate_errors, kind="stable")[: len(population)]
        return candidates[survivors], candidate_errors[survivors]

    def _fitness(self, errors: Array) -> Array:
        if self._options.logarithmic_fitness:
            return operators.logarithmic_fitness(
                errors, self._options.fitness_offset, self._options.fitness_error_limit
            )
        return operators.inverse_fitness(errors)

    def _cross(self, population: Array, fitness: Array) -> tuple[Array, Array]:
        pairs = _share(len(population), self._options.crossover_rate / 2)
        x, y = np.split(population[operators.roulette(fitness, 2 * pairs, self._rng)], 2)
        if self._options.hamming_pairing:
            y = operators.renew_close_relatives(x, y, self._lower, self._upper, self._rng)
        points = self._rng.integers(x.shape[1], size=pairs)
        if self._options.variable_precision:
            return operators.variable_precision_crossover(x, y, points, self._lower, self._upper, self._rng)
        return operators.single_point_crossover(x, y, points)

    def _experiment(self, x: Array, y: Array) -> tuple[Array, Array, Array]:
        """Return for each pair the combination of the better levels, the best experiment, and the latter's error."""
        array, pairs = self._array, np.arange(len(x))
        trials = np.where(array[None] == 0, x[:, None], y[:, None])
        errors = self.errors_of(trials.reshape(-1, x.shape[1])).reshape(len(x), len(array))
        best = np.argmin(errors, axis=1)
        combined = np.where(operators.best_levels(array, errors) == 0, x, y)
        return combined, trials[pairs, best], errors[pairs, best]

    def _mutate(self, offspring: Array, best: Array, alikeness: float) -> Array:
        options = self._options
        count = min(_share(options.population, options.mutation_rate), len(offspring))
        if options.feedback_mutation and alikeness > options.feedback_threshold:
            return operators.feedback_mutation(
                best, count, options.feedback_scale, options.feedback_spread, self._lower, self._upper, self._rng
            )
        return operators.uniform_mutation(offspring[:count], self._lower, self._upper, self._rng)


def _share(count: int, rate: float) -> int:
    """Return how many of `count` a rate stands for: one at least, unless the rate is zero."""
    return max(round(count * rate), int(rate > 0))

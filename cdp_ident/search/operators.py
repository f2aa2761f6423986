# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The steps that the genetic algorithms are made of, one function each: the traditional ones, then the improvements.

A chromosome is a row of genes in the box [lower, upper]. Operators that take pairs work on all pairs of a generation
at once: x and y are (pairs, genes). `_TENTHS` are the paper's values of beta.
"""

import numpy as np

from cdp_ident.arrays import Array, Indices

Generator = np.random.Generator

_TENTHS = np.arange(11) / 10.0
_SMALLEST_ERROR = 1e-200
"""Errors below it count as this one, so that logarithms of fitness and sums of it stay finite."""


def roulette(fitness: Array, count: int, rng: Generator) -> Indices:
    """Return indices of `count` chromosomes, each drawn with a probability proportional to its fitness."""
    return np.asarray(rng.choice(len(fitness), size=count, p=fitness / fitness.sum()), dtype=np.int64)


def inverse_fitness(errors: Array) -> Array:
    """Return the traditional algorithm's fitness of errors to be minimised, 1 / E."""
    return 1.0 / np.maximum(errors, _SMALLEST_ERROR)


def single_point_crossover(x: Array, y: Array, points: Indices) -> tuple[Array, Array]:
    """Return pairs that have exchanged all genes from the crossover points (pairs,) on."""
    exchanged = np.arange(x.shape[1]) >= points[:, None]
    return np.where(exchanged, y, x), np.where(exchanged, x, y)


def uniform_mutation(chromosomes: Array, lower: Array, upper: Array, rng: Generator) -> Array:
    """Return the chromosomes with one gene each, chosen at random, drawn anew from its whole range."""
    mutants = chromosomes.copy()
    genes = rng.integers(mutants.shape[1], size=len(mutants))
    mutants[np.arange(len(mutants)), genes] = rng.uniform(lower[genes], upper[genes])
    return mutants


def _on_grid(beta: Array, lower: Array, upper: Array) -> Array:
    """Return L + beta (U - L), which a rounding must not carry beyond U."""
    return np.minimum(lower + beta * (upper - lower), upper)


def renew_close_relatives(x: Array, y: Array, lower: Array, upper: Array, rng: Generator) -> Array:
    """Return y with each chromosome that differs from its partner in one gene at most made anew (Eqs. 2 and 3)."""
    hamming_distance = np.count_nonzero(x != y, axis=1)
    anew = _on_grid(rng.choice(_TENTHS, size=y.shape), lower, upper)
    return np.where((hamming_distance <= 1)[:, None], anew, y)


def variable_precision_crossover(
    x: Array, y: Array, points: Indices, lower: Array, upper: Array, rng: Generator
) -> tuple[Array, Array]:
    """Return pairs crossed by Eq. (4).

    Genes after the crossover point are exchanged. At the point itself the first offspring gets a value between its
    parents', x + beta (y - x), and the second one a value on a grid over the gene's range, L + beta (U - L).
    """
    first, second = single_point_crossover(x, y, points + 1)
    pairs = np.arange(len(x))
    beta = rng.choice(_TENTHS, size=len(x))
    at_x, at_y = x[pairs, points], y[pairs, points]
    first[pairs, points] = np.clip(at_x + beta * (at_y - at_x), lower[points], upper[points])
    second[pairs, points] = _on_grid(beta, lower[points], upper[points])
    return first, second


def orthogonal_array(factors: int) -> Indices:
    """Return the smallest two-level orthogonal array of strength two for so many factors, (experiments, factors).

    It is L_{2^k}(2^{2^k - 1}), of which spare columns are left out: in any two columns each of the four combinations
    of levels 0 and 1 appears equally often. Column c of experiment e is the parity of the bits that e and c + 1 share
    (Hedayat, Sloane and Stufken, Orthogonal Arrays, 1999, Section 3.4).
    """
    bits = int(factors).bit_length()
    experiments = np.arange(1 << bits)
    shared = experiments[:, None] & np.arange(1, factors + 1)
    return np.sum(shared[..., None] >> np.arange(bits) & 1, axis=-1) % 2


def best_levels(array: Indices, errors: Array) -> Indices:
    """Return the better level of each factor, (pairs, factors), from the experiments' errors (pairs, experiments).

    The factors are judged one by one, by the sum of the errors of all experiments at either level: in an orthogonal
    array the other factors' levels are spread evenly over both sums.
    """
    difference = errors @ (2 * array - 1)
    return (difference < 0).astype(np.int64)


def population_fitness(fitness: Array) -> float:
    """Return how alike the population is: its mean fitness over its best one's (Eq. 5)."""
    return float(fitness.mean() / fitness.max())


def feedback_mutation(
    best: Array, count: int, scale: float, spread: float, lower: Array, upper: Array, rng: Generator
) -> Array:
    """Return chromosomes near the best one, mu x + beta nu x (Eq. 6), kept inside the box."""
    beta = rng.choice(_TENTHS, size=(count, len(best)))
    return np.clip(scale * best + beta * spread * best, lower, upper)


def logarithmic_fitness(errors: Array, offset: float, error_limit: float) -> Array:
    """Return H = delta - 10 log10(min(f, C)) (Eq. 7), which narrows the gap between good and poor chromosomes."""
    return offset - 10.0 * np.log10(np.clip(errors, _SMALLEST_ERROR, error_limit))

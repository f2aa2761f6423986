# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.search import operators

TENTHS = np.arange(11) / 10
LOWER, UPPER = np.array([0.0, -1.0, 10.0, 3.0]), np.array([1.0, 1.0, 30.0, 3.0])

seeds = st.integers(0, 2**32 - 1)


def chromosomes(count, rng):
    return rng.uniform(LOWER, UPPER, (count, len(LOWER)))


def betas(values, lower, upper):
    """Return for which beta values are at that share of the way from one to the other (..., 11)."""
    grid = lower[..., None] + TENTHS * (upper - lower)[..., None]
    return np.isclose(values[..., None], grid, rtol=0, atol=1e-12)


def test_roulette_draws_in_proportion_to_fitness_one_over_the_error_of_perfect_chromosomes_too():
    fitness = np.array([1.0, 2.0, 3.0, 4.0])
    drawn = operators.roulette(fitness, 40_000, np.random.default_rng(1))
    np.testing.assert_allclose(np.bincount(drawn) / 40_000, fitness / 10, atol=0.01)
    np.testing.assert_allclose(operators.inverse_fitness(np.array([0.5, 4.0, 1e100])), [2.0, 0.25, 1e-100])
    perfect = operators.inverse_fitness(np.zeros(200))
    assert len(operators.roulette(perfect, 10, np.random.default_rng(1))) == 10
    assert operators.population_fitness(perfect) == pytest.approx(1.0)


def test_single_point_crossover_exchanges_all_genes_from_the_point_on():
    x, y = np.zeros((4, 4)), np.ones((4, 4))
    first, second = operators.single_point_crossover(x, y, np.array([0, 1, 3, 4]))
    np.testing.assert_array_equal(first, [[1, 1, 1, 1], [0, 1, 1, 1], [0, 0, 0, 1], [0, 0, 0, 0]])
    np.testing.assert_array_equal(second, 1 - first)


@given(seed=seeds)
def test_uniform_mutation_draws_one_gene_anew_in_its_range(seed):
    rng = np.random.default_rng(seed)
    before = chromosomes(30, rng)
    original = before.copy()
    after = operators.uniform_mutation(before, LOWER, UPPER, rng)
    np.testing.assert_array_equal(before, original)
    assert np.all(np.count_nonzero(after != before, axis=1) <= 1)
    assert np.all((after >= LOWER) & (after <= UPPER))
    assert np.any(after != before)


@pytest.mark.parametrize(("differing", "renewed"), [(0, True), (1, True), (2, False), (4, False)])
def test_a_partner_that_differs_in_one_gene_at_most_is_made_anew(differing, renewed):
    x = np.tile([0.123, 0.456, 17.7, 3.0], (50, 1))
    y = x.copy()
    y[:, :differing] += 0.01
    result = operators.renew_close_relatives(x, y, LOWER, UPPER, np.random.default_rng(1))
    if renewed:
        assert np.all(betas(result, LOWER, UPPER).any(axis=-1))
        assert len(np.unique(result, axis=0)) > 40
    else:
        np.testing.assert_array_equal(result, y)


def test_each_pair_is_evaluated_by_itself():
    x, y = np.zeros((2, 4)), np.array([[0.0, 0.0, 0.0, 0.5], [0.0, 0.0, 0.4, 0.5]])
    result = operators.renew_close_relatives(x, y, LOWER, UPPER, np.random.default_rng(1))
    assert np.all(betas(result[0], LOWER, UPPER).any(axis=-1))
    np.testing.assert_array_equal(result[1], y[1])


@given(seed=seeds, points=st.lists(st.integers(0, 3), min_size=1, max_size=20))
def test_variable_precision_crossover_is_equation_4(seed, points):
    rng = np.random.default_rng(seed)
    x, y = chromosomes(len(points), rng), chromosomes(len(points), rng)
    first, second = operators.variable_precision_crossover(x, y, np.array(points), LOWER, UPPER, rng)
    for pair, point in enumerate(points):
        np.testing.assert_array_equal(first[pair, :point], x[pair, :point])
        np.testing.assert_array_equal(second[pair, :point], y[pair, :point])
        np.testing.assert_array_equal(first[pair, point + 1 :], y[pair, point + 1 :])
        np.testing.assert_array_equal(second[pair, point + 1 :], x[pair, point + 1 :])
        # One beta serves both offspring.
        of_first = betas(first[pair, point], x[pair, point], y[pair, point])
        assert np.any(of_first & betas(second[pair, point], LOWER[point], UPPER[point]))


def test_every_beta_appears_at_the_crossover_point():
    x, y = np.zeros((2000, 4)), np.tile([1.0, 1.0, 30.0, 3.0], (2000, 1))
    first, _ = operators.variable_precision_crossover(
        x, y, np.zeros(2000, dtype=int), LOWER, UPPER, np.random.default_rng(1)
    )
    np.testing.assert_allclose(np.unique(first[:, 0]), TENTHS)


@given(seed=seeds, limits=st.lists(st.tuples(st.floats(-10, 10), st.floats(0, 10)), min_size=1, max_size=9))
def test_no_operator_leaves_the_box_not_even_by_a_rounding(seed, limits):
    rng = np.random.default_rng(seed)
    lower = np.array([low for low, _ in limits])
    upper = lower + np.array([width for _, width in limits])
    x = np.where(rng.random((30, len(lower))) < 0.3, upper, rng.uniform(lower, upper, (30, len(lower))))
    y = np.where(rng.random((30, len(lower))) < 0.3, lower, rng.uniform(lower, upper, (30, len(lower))))
    points = rng.integers(len(lower), size=30)
    everything = np.concatenate(
        [
            *operators.variable_precision_crossover(x, y, points, lower, upper, rng),
            operators.renew_close_relatives(x, x, lower, upper, rng),
            operators.uniform_mutation(x, lower, upper, rng),
            operators.feedback_mutation(x[0], 20, 0.95, 0.1, lower, upper, rng),
        ]
    )
    assert np.all(everything >= lower)
    assert np.all(everything <= upper)


@pytest.mark.parametrize("factors", range(1, 33))
def test_an_orthogonal_array_has_strength_two_and_as_few_experiments_as_can_be_the_first_parent_first(factors):
    array = operators.orthogonal_array(factors)
    assert array.shape == (2 ** int(np.ceil(np.log2(factors + 1))), factors)
    assert not array[0].any()
    assert np.all(array.sum(axis=0) == len(array) / 2)
    for a, b in itertools.combinations(range(factors), 2):
        combinations = np.bincount(2 * array[:, a] + array[:, b], minlength=4)
        assert np.all(combinations == len(array) / 4)


@given(seed=seeds, factors=st.integers(1, 15))
def test_best_levels_find_the_optimum_of_an_additive_error_and_keep_the_first_of_what_does_not_matter(seed, factors):
    rng = np.random.default_rng(seed)
    array = operators.orthogonal_array(factors)
    cost = rng.normal(size=(5, factors, 2))  # of each pair, factor and level
    errors = np.array([[sum(c[f, level] for f, level in enumerate(row)) for row in array] for c in cost])
    np.testing.assert_array_equal(operators.best_levels(array, errors), cost.argmin(axis=2))
    np.testing.assert_array_equal(operators.best_levels(array, np.ones((2, len(array)))), np.zeros((2, factors)))


def test_population_fitness_is_equation_5():
    assert operators.population_fitness(np.array([1.0, 2.0, 3.0, 4.0])) == pytest.approx(10 / (4 * 4))
    assert operators.population_fitness(np.full(7, 0.3)) == pytest.approx(1.0)


def test_feedback_mutants_are_equation_6():
    best = np.array([0.5, -0.5, 20.0, 3.0])
    mutants = operators.feedback_mutation(best, 500, 0.95, 0.10, LOWER, UPPER, np.random.default_rng(1))
    for gene in range(3):
        expected = np.sort(0.95 * best[gene] + TENTHS * 0.10 * best[gene])
        np.testing.assert_allclose(np.unique(mutants[:, gene].round(12)), expected, atol=1e-11)
    assert np.all(mutants[:, 3] == 3.0)


def test_genes_of_a_feedback_mutant_are_drawn_one_by_one():
    mutants = operators.feedback_mutation(
        np.array([0.5, 0.5]), 500, 0.95, 0.10, np.zeros(2), np.ones(2), np.random.default_rng(1)
    )
    assert abs(np.corrcoef(mutants.T)[0, 1]) < 0.2


def test_logarithmic_fitness_is_equation_7():
    errors = np.array([0.01, 1.0, 10.0, 1000.0, 1001.0, 1e100])
    np.testing.assert_allclose(operators.logarithmic_fitness(errors, 32.0, 1000.0), [52.0, 32.0, 22.0, 2.0, 2.0, 2.0])
    perfect = operators.logarithmic_fitness(np.zeros(3), 32.0, 1000.0)
    assert np.all(np.isfinite(perfect))
    assert np.all(perfect > 32.0)

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.errors import OptionError
from cdp_ident.machine import parallel
from cdp_ident.search.genetic_search import genetic_search
from cdp_ident.search.options import IGA, METHODS, TGA, GeneticOptions
from scenarios.search_problem import LOWER, PAPER_IGA_ERROR, UPPER, twin_objective

IMPROVEMENTS = [field.name for field in fields(IGA) if isinstance(getattr(IGA, field.name), bool)]
SHORT = {"population": 40, "generations": 30}
BOX = np.array([-1.0, 2.0, 0.1, 5.0, -3.0]), np.array([1.0, 4.0, 0.2, 5.0, 8.0])
"""Five genes, the fourth of which is fixed."""


def bowl(chromosomes):
    """Return a smooth error, coupled between genes, with its minimum of 0 in the box."""
    z = (chromosomes - [0.3, 2.7, 0.16, 5.0, 1.0]) / [2.0, 2.0, 0.1, 1.0, 11.0]
    return 100 * np.sum(z**2, axis=1) + 100 * (z[:, 0] + z[:, 1] - z[:, 4]) ** 2


def recorded(error=bowl):
    """Return an objective, and the list of what it is asked for."""
    asked = []

    def objective(chromosomes):
        asked.append(chromosomes.copy())
        return error(chromosomes)

    return objective, asked


def search(objective, options, seed=1, **more):
    return genetic_search(objective, *BOX, replace(options, **SHORT), np.random.default_rng(seed), **more)


@pytest.fixture(scope="module")
def twin_error():
    return twin_objective(np.random.default_rng(0))


def each_switched():
    """Return each algorithm, and each with one of the improvements switched over."""
    for name, method in METHODS.items():
        yield pytest.param(method, id=name)
        for improvement in IMPROVEMENTS:
            switched = replace(method, **{improvement: not getattr(method, improvement)})
            yield pytest.param(switched, id=f"{name} {improvement} {getattr(switched, improvement)}")


@pytest.mark.parametrize("options", each_switched())
def test_every_combination_of_improvements_searches_the_box_with_its_whole_population(options):
    (objective, asked), populations = recorded(), []
    result = search(objective, options, stop=lambda progress: populations.append(progress.evaluations))
    everything = np.concatenate(asked)
    assert len(asked[0]) == SHORT["population"]
    assert np.all((everything >= BOX[0]) & (everything <= BOX[1]))
    assert np.all(everything[:, 3] == 5.0)
    assert result.error < 0.2 * np.median(bowl(asked[0]))
    assert result.evaluations == len(everything) == populations[-1]
    if not options.elitist_survival:
        each_generation = np.diff(populations)
        experiments = np.zeros(1)
        if options.orthogonal_experiments:
            experiments = 8 * round(SHORT["population"] * options.crossover_rate / 2)
        assert np.all(each_generation - experiments == SHORT["population"])


EACH = pytest.mark.parametrize("options", METHODS.values(), ids=METHODS)


@EACH
def test_the_best_of_all_chromosomes_ever_tried_is_returned_and_told_all_the_way(options):
    (objective, tried), seen = recorded(), []
    result = search(objective, options, stop=seen.append)
    assert result.error == bowl(np.concatenate(tried)).min()
    assert bowl(result.best[None])[0] == result.error
    assert [progress.generation for progress in seen] == list(range(SHORT["generations"] + 1))
    assert tuple(progress.error for progress in seen) == result.history
    assert seen[-1].evaluations == result.evaluations
    np.testing.assert_array_equal(seen[-1].best, result.best)
    assert np.all(np.diff(result.history) <= 0)
    assert result.history[-1] < result.history[0]


@EACH
def test_the_same_seed_gives_the_same_result_and_another_one_another(options):
    first, again, other = (search(bowl, options, seed) for seed in (3, 3, 4))
    np.testing.assert_array_equal(first.best, again.best)
    assert first.history == again.history
    assert first.history != other.history


@EACH
def test_the_number_of_cores_does_not_change_the_result(options, monkeypatch, twin_error):
    results = []
    for cores in (1, 2, 3):
        monkeypatch.setattr(parallel, "core_count", lambda cores=cores: cores)
        short = replace(options, population=50, generations=8)
        results.append(genetic_search(twin_error, LOWER, UPPER, short, np.random.default_rng(5)))
    for other in results[1:]:
        np.testing.assert_array_equal(results[0].best, other.best)
        assert results[0].history == other.history


@pytest.mark.parametrize(("ends", "generations"), [(7, 7), (0, 0), (99, SHORT["generations"])])
def test_the_search_ends_when_its_caller_says_so_or_it_is_done_and_says_why(ends, generations):
    def stop(progress):
        return f"{progress.error:.3f} is good enough" if progress.generation == ends else None

    result = search(bowl, IGA, stop=stop)
    assert result.completed == (generations != ends)
    assert result.stopped == ("all 30 generations done" if result.completed else f"{result.error:.3f} is good enough")
    assert len(result.history) == generations + 1
    assert generations or result.evaluations == SHORT["population"]


@pytest.mark.parametrize("useless", [np.nan, np.inf], ids=str)
@EACH
def test_errors_that_are_not_finite_and_errors_of_zero_are_survived(options, useless):
    result = search(lambda chromosomes: np.where(chromosomes[:, 0] < 0, useless, bowl(chromosomes)), options)
    assert result.best[0] >= 0
    assert result.error < 5
    nowhere = search(lambda chromosomes: np.full(len(chromosomes), useless), options)
    assert np.all(np.isfinite(nowhere.best))
    assert len(nowhere.history) == SHORT["generations"] + 1
    assert search(lambda chromosomes: np.zeros(len(chromosomes)), options).error == 0.0


@EACH
@given(
    genes=st.integers(1, 12),
    population=st.integers(4, 31),
    generations=st.sampled_from([0, 5]),
    rates=st.tuples(st.floats(0, 1), st.floats(0, 1)),
)
def test_any_settings_in_range_give_a_result_none_but_the_best_of_the_first_without_generations(
    options, genes, population, generations, rates
):
    sizes = {"population": population, "generations": generations}
    options = replace(options, **sizes, crossover_rate=rates[0], mutation_rate=rates[1])
    objective, asked = recorded(lambda chromosomes: np.sum(chromosomes**2, axis=1))
    result = genetic_search(objective, -np.ones(genes), np.ones(genes), options, np.random.default_rng(1))
    assert result.completed
    assert result.best.shape == (genes,)
    if not (options.elitist_survival and generations):
        assert [len(each) for each in asked] == [population] * (generations + 1)


@EACH
def test_without_crossover_and_mutation_nothing_new_appears(options):
    objective, tried = recorded()
    search(objective, replace(options, crossover_rate=0.0, mutation_rate=0.0))
    first = {tuple(row) for row in tried[0]}
    assert {tuple(row) for later in tried for row in later} == first


@pytest.mark.parametrize(
    ("lower", "upper"),
    [([0.0, 1.0], [1.0, 0.5]), ([0.0], [1.0, 1.0]), ([0.0, np.nan], [1.0, 1.0]), ([0.0, 0.0], [1.0, np.inf]), ([], [])],
    ids=["upside down", "sizes differ", "nan", "infinite", "empty"],
)
def test_a_box_that_cannot_be_searched_is_refused(lower, upper):
    with pytest.raises(OptionError, match="limit of the search"):
        genetic_search(bowl, np.array(lower), np.array(upper), IGA, np.random.default_rng(1))


def test_every_gene_may_be_fixed():
    fixed = np.array([0.3, 2.7, 0.16, 5.0, 2.0])
    result = genetic_search(bowl, fixed, fixed, replace(IGA, **SHORT), np.random.default_rng(1))
    np.testing.assert_array_equal(result.best, fixed)


def test_mutation_is_by_feedback_where_the_population_is_more_alike_than_alpha():
    never = search(bowl, replace(IGA, feedback_mutation=False)).history
    assert search(bowl, replace(IGA, feedback_threshold=1.0)).history == never
    assert search(bowl, replace(IGA, feedback_threshold=0.0)).history != never


def test_feedback_mutants_lie_near_the_best_chromosome_before_them():
    (objective, asked), best = recorded(), []
    search(objective, replace(IGA, feedback_threshold=0.0), stop=lambda progress: best.append(progress.best))
    # A generation asks for its experiments, then for its offspring with the mutant at their end.
    for chromosome, offspring in zip(best[:-1], asked[2::2], strict=True):
        mutant = offspring[-1]
        inside = (mutant > BOX[0]) & (mutant < BOX[1])
        assert np.any(inside)
        np.testing.assert_allclose(mutant[inside] / chromosome[inside], 1.0, atol=0.05 + 1e-12)


def median_error(objective, options, seeds):
    return np.median(
        [genetic_search(objective, LOWER, UPPER, options, np.random.default_rng(seed)).error for seed in seeds]
    )


@pytest.mark.parametrize("seeds", [1, pytest.param(5, marks=pytest.mark.campaign)])
def test_on_a_twin_the_improved_algorithm_is_far_ahead_of_the_traditional_one_after_the_same_work(twin_error, seeds):
    # A generation of the improved one costs 344 evaluations, one of the traditional one 200.
    improved = median_error(twin_error, replace(IGA, generations=40), range(seeds))
    traditional = median_error(twin_error, replace(TGA, generations=70), range(seeds))
    assert improved < traditional / 5


@pytest.mark.campaign
def test_with_the_papers_settings_the_improved_algorithm_beats_the_papers_error_and_the_traditional_one(twin_error):
    improved = median_error(twin_error, IGA, range(10))
    traditional = median_error(twin_error, TGA, range(10))
    assert improved < PAPER_IGA_ERROR
    assert improved < traditional / 3


def test_the_traditional_algorithm_has_the_settings_of_section_4_2():
    assert (TGA.population, TGA.generations, TGA.crossover_rate, TGA.mutation_rate) == (200, 500, 1.0, 0.1)


def test_the_improved_algorithm_has_the_settings_of_section_4_3():
    assert (IGA.population, IGA.generations, IGA.crossover_rate, IGA.mutation_rate) == (200, 500, 0.2, 0.02)
    assert (IGA.feedback_threshold, IGA.feedback_scale, IGA.feedback_spread) == (0.95, 0.95, 0.10)
    assert IGA.fitness_offset == 32.0


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("population", 3),
        ("population", 10**6),
        ("generations", -1),
        ("crossover_rate", 1.1),
        ("mutation_rate", -0.1),
        ("mutation_rate", float("nan")),
        ("feedback_threshold", 2.0),
        ("feedback_scale", -0.5),
        ("feedback_spread", 1.5),
        ("fitness_offset", -1.0),
        ("fitness_error_limit", 0.0),
        ("fitness_error_limit", 1585.0),
        ("fitness_error_limit", float("nan")),
    ],
)
def test_a_setting_without_meaning_is_refused_by_name(name, value):
    with pytest.raises(OptionError, match=rf"search option {name} is {value}"):
        GeneticOptions(**{name: value})


def test_the_limit_of_errors_does_not_matter_to_inverse_fitness():
    assert replace(TGA, fitness_error_limit=1e6).fitness_error_limit == 1e6

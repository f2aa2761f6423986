# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Both algorithms on the same trials: what a search says of itself is so."""

from pathlib import Path

import numpy as np
import pytest

from cdp_ident.pipeline.searches import search_by_both
from cdp_ident.pipeline.searches_page import fitness, search_figures, search_tables, shown_generations
from cdp_ident.report.chapters import best_error

BAGS = Path(__file__).parents[2] / "bags"
SHORT = {"search.population": 20, "search.generations": 25}


@pytest.fixture(scope="module")
def found():
    said = []
    return search_by_both([BAGS / "swing_wide", BAGS / "swing_check"], SHORT, 3, said.append)


def test_the_error_of_the_typical_search_is_that_of_its_simulated_motion(found):
    for algorithm in found.algorithms:
        assert [course.end.error for course in algorithm.courses] == sorted(c.end.error for c in algorithm.courses)
        assert algorithm.typical is algorithm.courses[1]
        left = [window.theta - s for window, s in zip(found.windows, algorithm.simulated, strict=True)]
        assert sum(np.sum(one**2) for one in left) == pytest.approx(algorithm.typical.end.error, rel=1e-6)
    assert all(window.time[-1] == pytest.approx(10.0, abs=0.01) for window in found.windows)
    assert found.noise_error < found.algorithms[1].typical.end.error


def test_each_algorithm_has_the_paper_s_settings_but_for_those_that_are_given(found):
    traditional, improved = (algorithm.options for algorithm in found.algorithms)
    assert (traditional.crossover_rate, improved.crossover_rate) == (1.0, 0.2)
    assert (traditional.generations, improved.generations) == (25, 25)


def test_the_tables_are_those_of_the_paper(found):
    ends, traditional, improved, spread = search_tables(found)
    assert [row[0] for row in ends.rows] == ["TGA", "IGA"]
    assert [row[0] for row in improved.rows] == ["1", "20", "25"]
    last = traditional.rows[-1]
    course = found.algorithms[0].typical
    assert [float(cell) for cell in last[1:10]] == pytest.approx(course.end.best, rel=1e-3)
    assert float(last[10]) == pytest.approx(course.end.error, rel=1e-4)
    assert float(last[11]) == pytest.approx(32 - 10 * np.log10(course.end.error), abs=1e-3)
    assert len(spread.rows) == 9 + 5


def test_the_evolution_has_a_line_for_each_seed_and_their_median(found):
    evolution, *contrasts = search_figures(found)
    assert [figure.name for figure in contrasts] == ["contrast_1_swing_wide", "contrast_2_swing_check"]
    errors, fitnesses = ([line for line in panel.marks if line.colour == "after"] for panel in evolution.panels)
    courses = np.array([[one.error for one in course.generations] for course in found.algorithms[1].courses])
    assert np.array_equal([line.y for line in errors[:3]], courses)
    assert np.array_equal(errors[3].y, np.median(courses, axis=0))
    assert np.array_equal(fitnesses[3].y, fitness(errors[3].y, found.algorithms[1].options))


def test_a_search_shows_the_paper_s_generations_and_its_last():
    assert shown_generations(500) == [1, 20, 40, 60, 80, 100, 200, 300, 400, 500]
    assert shown_generations(2) == [1, 2]
    assert shown_generations(0) == [0]


def test_the_history_of_a_search_in_full_is_shown(read_content):
    assert not list(best_error(read_content))
    read_content["search"] |= {"history": [100.0, 5.0, 0.1], "cut_short": False}
    (figure,) = best_error(read_content)
    assert figure.panels[0].y.logarithmic
    assert np.array_equal(figure.panels[0].marks[0].y, [100.0, 5.0, 0.1])

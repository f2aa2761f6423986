# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
from dataclasses import replace

import pytest

from cdp_ident.errors import OptionError
from cdp_ident.search.options import IGA, TGA, GeneticOptions


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

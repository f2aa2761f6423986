# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a survey of starts says in the units of a question."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.design.questions import Advice, Question
from cdp_ident.design.starts import CandidateTrial, Grid, Survey
from scenarios.weighted import WEIGHT

GRID = Grid.of(90.0)
ALONE = Survey(GRID, np.full((4, 4), -3.0), CandidateTrial(0.0, 1.0), -2.0, -1.0)
WEIGHTED = replace(ALONE, trial=replace(ALONE.trial, weights=(WEIGHT,)), unloaded=replace(ALONE, expected=-1.5))


@pytest.mark.parametrize(
    ("survey", "unloaded"), [(ALONE, np.inf), (WEIGHTED, 1.5), (replace(WEIGHTED, trial=ALONE.trial), np.inf)]
)
def test_without_a_weight_there_is_nothing_to_compare_it_with(survey, unloaded):
    advice = Advice.of(Question("coulomb_friction.outer", "air_drag.outer"), survey, -1.0, deviations_now=0.5)
    assert (advice.expected, advice.worst, advice.expected_unloaded, advice.deviations_now) == (2.0, 1.0, unloaded, 0.5)
    assert np.all(advice.values == 3.0)


def test_beyond_the_most_that_a_trial_tells_anything_with_it_tells_nothing():
    advice = Advice.of(Question("A22"), replace(ALONE, expected=2.0, worst=0.5), 1.0, most=1.0, names=["A22"])
    assert (advice.expected, advice.worst, advice.names) == (np.inf, 0.5, ["A22"])

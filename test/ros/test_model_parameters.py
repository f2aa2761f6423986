# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which of the places that give a model's parameters wins."""

from cdp_ident.model.parameters import NOMINAL
from cdp_ident.ros.model_parameters import own_values

FITTED = {**dict.fromkeys(NOMINAL, 0.5), "groups.c1_over_A22": 0.1, "effects.air_drag.inner.coefficient": 0.001}


def test_a_fitted_model_s_file_wins_over_the_paper_s_pendulum_and_ros_over_the_file():
    assert own_values({}, {}) == NOMINAL
    own = own_values({"groups.c1_over_A22": 0.2, "rate": 2.0, "std.m1": 0.1}, FITTED)
    assert own == FITTED | {"groups.c1_over_A22": 0.2}


def test_a_physical_value_is_not_overruled_by_groups_that_belong_to_another_one():
    own = own_values({"m1": 0.2}, FITTED)
    assert own["m1"] == 0.2
    assert "groups.c1_over_A22" not in own
    assert own["effects.air_drag.inner.coefficient"] == 0.001


def test_a_whole_fitted_model_given_by_ros_keeps_its_groups():
    assert own_values(FITTED, {}) == FITTED

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is known of a rig before its next trial."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.design.knowledge import NEW, covariance_of
from cdp_ident.model.effects.effect import JOINTS
from scenarios.next_swing import ALL_GROUPS, NOISE, swing
from scenarios.weighted import WEIGHT


def information_in(knowledge):
    return knowledge.rows.T @ knowledge.rows


def test_the_next_trial_is_recorded_as_those_before(known):
    assert known.sampling.duration == pytest.approx(10, abs=0.1)
    assert known.sampling.interval == pytest.approx(1 / 200)
    assert known.noise.encoders == pytest.approx([NOISE, np.sqrt(2.0) * NOISE], rel=0.05)
    assert np.all(known.noise.torque < 1e-6)
    assert known.asked == (*ALL_GROUPS, "one_over_A22")


def test_the_information_is_the_inverse_of_the_covariance(known):
    groups = known.covariance[:5, :5]
    scale = np.sqrt(np.diag(groups))
    both = (information_in(known)[:5, :5] * np.outer(scale, scale)) @ (groups / np.outer(scale, scale))
    assert both == pytest.approx(np.eye(5), abs=1e-6)


def test_of_the_zeros_of_a_trial_that_is_not_there_yet_nothing_is_known(known):
    with_zeros = known.with_zeros_of_its_own(JOINTS)
    place = with_zeros.model.zero_places(NEW)
    assert np.all(np.isinf(np.diag(with_zeros.covariance)[place]))
    assert not np.any(information_in(with_zeros)[place])
    rig = with_zeros.model.of_rig
    assert information_in(with_zeros)[np.ix_(rig, rig)] == pytest.approx(information_in(known))
    assert with_zeros.asked == known.asked


def test_of_the_inertia_nothing_is_known_where_no_trial_shows_it(known):
    assert known.model.names[5] == "one_over_A22"
    assert known.values[5] == pytest.approx(1 / known.model.mechanism.inertia)
    assert not known.shows_inertia
    assert not np.any(information_in(known)[5])


def test_a_weight_s_errors_are_known_to_be_within_their_standard_deviations(known):
    with_weights = known.with_zeros_of_its_own(JOINTS).with_weights([WEIGHT, replace(WEIGHT, rod="inner")])
    assert with_weights.model.names[6:9] == (
        "weight_error.mass.50 g",
        "weight_error.outer.300 mm",
        "weight_error.inner.300 mm",
    )
    assert information_in(with_weights)[6:9, 6:9] == pytest.approx(np.eye(3))
    assert not np.any(with_weights.values[6:9])
    assert information_in(with_weights)[:5, :5] == pytest.approx(information_in(known)[:5, :5])
    assert with_weights.model.zeros == (NEW,)
    assert with_weights.asked == known.asked


def test_what_is_known_of_a_weight_that_was_used_stays(swings):
    both = swings.with_one_more(swing(3.6, 3.0, np.random.default_rng(1), weight=WEIGHT))
    again = both.knowledge.with_weights([WEIGHT])
    assert again.shows_inertia
    assert again.model.names == both.fit.model.names
    assert again.values == pytest.approx(both.fit.values)
    assert again.covariance == pytest.approx(both.fit.covariance)


def test_one_value_is_as_uncertain_as_its_standard_deviation(known):
    found, std = known.uncertainty(("c1_over_A22",)), np.sqrt(known.covariance[3, 3])
    assert (found.std, found.size) == (pytest.approx([std]), pytest.approx(std))


def test_several_are_as_uncertain_as_the_determinant_of_their_covariance_says(known):
    part = known.covariance[np.ix_([0, 3], [0, 3])]
    assert known.uncertainty(("A23_over_A22", "c1_over_A22")).size == pytest.approx(np.linalg.det(part) ** (1 / 4))


def test_four_times_the_information_halves_it(known):
    more = known.uncertainty(ALL_GROUPS, np.sqrt(3.0) * known.rows)
    assert more.size == pytest.approx(known.uncertainty(ALL_GROUPS).size / 2)


@pytest.mark.parametrize(
    ("rows", "variances"),
    [(np.diag([2.0, 0.0, 1.0]), [0.25, np.inf, 1.0]), ([[1.0, 1.0, 0.0], [0.0, 0.0, 1.0]], [np.inf, np.inf, 1.0])],
)
def test_what_is_not_seen_is_infinitely_uncertain_and_the_rest_is_not(rows, variances):
    assert np.diag(covariance_of(np.array(rows))) == pytest.approx(variances)

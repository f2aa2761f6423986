# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a trial that is not recorded yet would show, and the best start that a hand can lead both rods to."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.design.knowledge import covariance_of
from cdp_ident.design.starts import HAND, CandidateTrial, Grid, information_of, survey, swing_of
from cdp_ident.errors import IdentificationError
from reference.pendulum import TABLE_5, motion
from reference.weights import with_weight
from scenarios.next_swing import TRUTH, Swings, swing
from scenarios.weighted import INERTIA, WEIGHT

SWING = CandidateTrial(-0.6, 0.9)


@pytest.fixture(scope="module")
def true(known):
    """The rig as it is."""
    return replace(known, values=np.append(TRUTH, 1.0 / INERTIA))


@pytest.fixture(scope="module")
def heavier(true):
    """The same, with a weight that may be clamped to it."""
    return true.with_weights([WEIGHT])


@pytest.mark.parametrize(
    ("weights", "values"),
    [((), TABLE_5), ((WEIGHT,), with_weight(TABLE_5, WEIGHT.rod, WEIGHT.mass, WEIGHT.place, WEIGHT.inertia))],
    ids=["without a weight", "with one"],
)
def test_its_motion_is_the_pendulum_s_from_rest(heavier, weights, values):
    of, states = swing_of(replace(SWING, weights=weights), heavier)
    theta = np.cumsum(of.readings, axis=1)
    for times, angles in ((of.time, theta), (of.node_times, states[:, :2])):
        early = times < 3.0
        expected = motion(values, (np.pi - 0.6, np.pi + 0.9, 0.0, 0.0), times, tolerance=1e-10)[:, :2]
        assert angles[early] == pytest.approx(expected[early], abs=1e-4)


def test_it_is_one_swing_from_node_to_node(true):
    of, states = swing_of(SWING, true)
    assert (of.time[-1], len(of.time)) == (pytest.approx(true.sampling.duration, abs=0.01), pytest.approx(2000, abs=1))
    linear = of.linearised(true.model, true.values, states)
    assert np.abs(linear.gaps).max() < 1e-6
    assert np.abs(linear.residuals).max() < 1e-6


def test_it_is_rounded_as_encoders_do_of_which_readings_that_repeat_count_once(true):
    step = 2.0 * np.pi / 500
    coarse = replace(true, sampling=replace(true.sampling, steps=np.full(2, step)))
    trial = CandidateTrial(0.3, 0.2)
    of, _ = swing_of(trial, coarse)
    counted = of.readings / step
    assert counted[:, 1] == pytest.approx(np.round(counted[:, 1]))
    assert np.any(of.counts < 1.0)
    fine, rounded = (np.trace(covariance_of(information_of(trial, k))[:5, :5]) for k in (true, coarse))
    assert rounded > fine


def test_a_trial_shows_the_inertia_and_what_its_weight_is_wrong_by_where_it_has_one(heavier):
    bare, weighted = (
        np.sum(information_of(replace(SWING, weights=weights), heavier) ** 2, axis=0) for weights in ((), (WEIGHT,))
    )
    assert heavier.model.names[5:] == ("one_over_A22", "weight_error.mass.50 g", "weight_error.outer.300 mm")
    assert np.all(bare[:5] > 0)
    assert not np.any(bare[5:])
    assert np.all(weighted > 0)


def test_rods_that_hang_still_say_nothing(true):
    assert np.abs(information_of(CandidateTrial(0.0, 0.0), true)).max() < 1e-3


def test_a_fit_to_such_a_trial_alone_gets_what_is_foretold(true):
    foretold = np.sqrt(np.diag(covariance_of(information_of(CandidateTrial(1.2, -0.8), true)[:, :5])))
    recorded = swing(np.pi + 1.2, np.pi - 0.8, np.random.default_rng(1))
    got = np.sqrt(np.diag(Swings.of([recorded]).knowledge.covariance)[:5])
    assert got == pytest.approx(foretold, rel=0.1)


def test_unknown_torques_make_it_tell_less(true):
    noisy = replace(true, noise=true.noise.with_torque_of_at_least(0.01))
    less, more = (np.diag(covariance_of(information_of(SWING, k)[:, :5])) for k in (noisy, true))
    assert np.all(less > 4.0 * more)


def test_a_motion_that_cannot_be_computed_is_refused(true):
    with pytest.raises(IdentificationError, match="cannot be computed"):
        swing_of(SWING, replace(true, values=np.full(6, np.nan)))


def test_a_mirrored_trial_tells_the_same(heavier):
    trial = CandidateTrial(0.5, -0.2, (WEIGHT,))
    assert trial.mirrored == CandidateTrial(-0.5, 0.2, (WEIGHT,))
    one, other = (rows.T @ rows for rows in (information_of(each, heavier) for each in (trial, trial.mirrored)))
    assert one == pytest.approx(other, rel=1e-6)


@pytest.mark.parametrize(
    ("grid", "inner", "outer"),
    [
        (Grid.of(90.0), [-90, 0, 90, 180], [-90, 0, 90, 180]),
        (Grid.of(30.0, most_inner=60.0, most_outer=70.0), [-60, -30, 0, 30, 60], [-60, -30, 0, 30, 60]),
        (Grid.of(45.0, most_outer=90.0).thinned, [-90, 0, 90, 180], [-90, 0, 90]),
        (Grid.of(90.0, most_inner=90.0).thinned, [-90, 0, 90], [0, 180]),
    ],
    ids=["half a turn is one to either side", "no rod is led further", "every second, hanging too", "few angles stay"],
)
def test_a_grid_has_the_angles_that_a_hand_can_lead_to(grid, inner, outer):
    assert np.degrees(grid.inner) == pytest.approx(inner)
    assert np.degrees(grid.outer) == pytest.approx(outer)


def test_trials_begin_at_its_places_by_the_inner_rod_s_angle():
    trials = Grid.of(90.0, most_outer=90.0).trials()
    assert [(np.degrees(trial.inner), np.degrees(trial.outer)) for trial in trials[2:5]] == [
        (-90, 90),
        (0, -90),
        (0, 0),
    ]


def test_the_start_with_the_smallest_loss_is_found():
    found = survey(lambda t: (t.inner - 1.0) ** 2 + (t.outer + 0.5) ** 2, Grid.of(15.0))
    assert np.degrees([found.trial.inner, found.trial.outer]) == pytest.approx([60, -30])
    assert found.losses.shape == (24, 24)
    assert found.expected <= found.worst


def test_a_start_that_is_good_at_one_point_alone_is_no_advice():
    def loss(trial):
        spike = abs(trial.inner - np.radians(90)) < np.radians(HAND) / 2 and abs(trial.outer) < 0.01
        return 0.0 if spike else 1.0 + trial.inner**2

    found = survey(loss, Grid.of(30.0))
    assert found.trial.inner == 0.0
    assert found.losses.min() == 0.0


def test_starts_whose_motion_cannot_be_computed_are_not_taken():
    found = survey(lambda t: np.inf if t.inner < 0.6 else t.inner, Grid.of(30.0))
    assert found.trial.inner > 0.6


def test_where_no_start_can_be_computed_none_is_advised():
    with pytest.raises(IdentificationError, match="from no start"):
        survey(lambda trial: np.inf, Grid.of(90.0))

"""What a trial that is not recorded yet would show."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.design.candidate_trial import CandidateTrial, fit_to, information_of
from cdp_ident.errors import IdentificationError
from reference.pendulum import TABLE_5, motion
from reference.weights import with_weight
from scenarios.next_swing import MODEL, NOISE, TRUTH, Swings, swing
from scenarios.weighted import INERTIA, WEIGHT


@pytest.fixture(scope="module")
def true(known):
    """The rig as it is."""
    return replace(known, values=np.append(TRUTH, 1.0 / INERTIA), noise=NOISE)


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
    fit = fit_to(CandidateTrial(2.5, 4.0, weights), heavier)
    times = np.concatenate([window.begin + window.time for window in fit.windows])
    theta = np.concatenate([window.theta for window in fit.windows])
    early = times < 3.0
    expected = motion(values, (2.5, 4.0, 0.0, 0.0), times, tolerance=1e-10)[:, :2]
    assert theta[early] == pytest.approx(expected[early], abs=1e-4)


def test_its_sensitivities_are_how_much_the_angles_change_with_the_values(true):
    fit = fit_to(CandidateTrial(2.5, 4.0), true)
    window, nudge = fit.windows[1], 1e-5 * np.eye(5)[2]
    ahead, behind = (MODEL.predict(TRUTH + change, window.start, window)[0] for change in (nudge, -nudge))
    expected = fit.sensitivities[1][..., MODEL.states + 2]
    assert (ahead - behind) / 2e-5 == pytest.approx(expected, abs=1e-3 * np.max(np.abs(expected)))


def test_a_trial_shows_the_inertia_and_what_its_weight_is_wrong_by_where_it_has_one(heavier):
    bare, weighted = (
        np.diag(information_of(fit_to(CandidateTrial(2.5, 4.0, weights), heavier), NOISE))
        for weights in ((), (WEIGHT,))
    )
    assert heavier.model.names[5:] == ("one_over_A22", "weight_error.mass.50 g", "weight_error.outer.300 mm")
    assert np.all(bare[:5] > 0)
    assert not np.any(bare[5:])
    assert np.all(weighted > 0)


def test_rods_that_hang_still_say_nothing(true):
    assert np.allclose(information_of(fit_to(CandidateTrial(np.pi, np.pi), true), NOISE), 0.0)


def test_a_fit_to_such_a_trial_alone_gets_what_is_foretold_or_somewhat_more(true):
    start = (np.pi + 1.2, np.pi - 0.8)
    foretold = np.sqrt(np.diag(np.linalg.inv(information_of(fit_to(CandidateTrial(*start), true), NOISE)[:5, :5])))
    got = np.sqrt(np.diag(Swings.of([swing(*start, np.random.default_rng(1))]).knowledge.covariance)[:5])
    assert np.all((0.6 * foretold < got) & (got < 1.2 * foretold)), got / foretold


def test_windows_are_as_long_as_a_given_length(true, known):
    fixed = replace(known.sampling, window=1.0)
    fit = fit_to(CandidateTrial(2.5, 4.0), replace(true, sampling=fixed))
    assert [window.duration for window in fit.windows[:-1]] == pytest.approx([1.0] * (len(fit.windows) - 1), abs=0.05)


def test_what_a_model_leaves_of_the_motion_makes_no_window_shorter(true):
    leaving = replace(true, noise=50.0 * NOISE)
    bounds = [[window.first for window in fit_to(CandidateTrial(2.5, 4.0), k).windows] for k in (true, leaving)]
    assert bounds[0] == bounds[1]


def test_a_motion_that_cannot_be_computed_is_refused(true):
    with pytest.raises(IdentificationError, match="cannot be computed"):
        fit_to(CandidateTrial(2.5, 4.0), replace(true, values=np.full(6, np.nan)))


def test_a_mirrored_trial_tells_the_same(heavier):
    trial = CandidateTrial(np.pi + 0.5, np.pi - 0.2, (WEIGHT,))
    assert trial.mirrored == CandidateTrial(pytest.approx(np.pi - 0.5), pytest.approx(np.pi + 0.2), (WEIGHT,))
    one, other = (information_of(fit_to(each, heavier), NOISE) for each in (trial, trial.mirrored))
    assert one == pytest.approx(other, rel=1e-6)

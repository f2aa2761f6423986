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

RNG = np.random.default_rng(0)
KNOWN = Swings.of([swing(3.6, 3.9, RNG)]).knowledge
TRUE = replace(KNOWN, values=np.append(TRUTH, 1.0 / INERTIA), noise=NOISE)
WITH_WEIGHT = TRUE.with_weights([WEIGHT])


def fit_of(theta1, theta2):
    return fit_to(CandidateTrial(theta1, theta2), TRUE)


@pytest.mark.parametrize(
    ("weights", "values"),
    [((), TABLE_5), ((WEIGHT,), with_weight(TABLE_5, WEIGHT.rod, WEIGHT.mass, WEIGHT.place, WEIGHT.inertia))],
    ids=["without a weight", "with one"],
)
def test_its_motion_is_the_pendulum_s_from_rest(weights, values):
    fit = fit_to(CandidateTrial(2.5, 4.0, weights), WITH_WEIGHT)
    times = np.concatenate([window.begin + window.time for window in fit.windows])
    theta = np.concatenate([window.theta for window in fit.windows])
    early = times < 3.0
    expected = motion(values, (2.5, 4.0, 0.0, 0.0), times, tolerance=1e-10)[:, :2]
    assert theta[early] == pytest.approx(expected[early], abs=1e-4)


def test_its_sensitivities_are_how_much_the_angles_change_with_the_values():
    fit = fit_of(2.5, 4.0)
    window, nudge = fit.windows[1], 1e-5 * np.eye(5)[2]
    ahead, behind = (MODEL.predict(TRUTH + change, window.start, window)[0] for change in (nudge, -nudge))
    expected = fit.sensitivities[1][..., MODEL.states + 2]
    assert (ahead - behind) / 2e-5 == pytest.approx(expected, abs=1e-3 * np.max(np.abs(expected)))


def test_a_trial_shows_the_inertia_and_what_its_weight_is_wrong_by_where_it_has_one():
    bare, weighted = (
        np.diag(information_of(fit_to(CandidateTrial(2.5, 4.0, weights), WITH_WEIGHT), NOISE))
        for weights in ((), (WEIGHT,))
    )
    assert WITH_WEIGHT.model.names[5:] == ("one_over_A22", "weight_error.mass.50 g", "weight_error.outer.300 mm")
    assert np.all(bare[:5] > 0)
    assert not np.any(bare[5:])
    assert np.all(weighted > 0)


def test_rods_that_hang_still_say_nothing():
    assert np.allclose(information_of(fit_of(np.pi, np.pi), NOISE), 0.0)


def test_what_is_foretold_is_what_a_fit_to_such_a_trial_alone_gets():
    start = (np.pi + 1.2, np.pi - 0.8)
    foretold = np.sqrt(np.diag(np.linalg.inv(information_of(fit_of(*start), NOISE)[:5, :5])))
    got = np.sqrt(np.diag(Swings.of([swing(*start, RNG)]).knowledge.covariance)[:5])
    assert got == pytest.approx(foretold, rel=0.3)


def test_windows_are_as_long_as_a_given_length():
    fixed = replace(KNOWN.sampling, window=1.0)
    fit = fit_to(CandidateTrial(2.5, 4.0), replace(TRUE, sampling=fixed))
    assert [window.duration for window in fit.windows[:-1]] == pytest.approx([1.0] * (len(fit.windows) - 1), abs=0.05)


def test_what_a_model_leaves_of_the_motion_makes_no_window_shorter():
    leaving = replace(TRUE, noise=50.0 * NOISE)
    bounds = [[window.first for window in fit_to(CandidateTrial(2.5, 4.0), k).windows] for k in (TRUE, leaving)]
    assert bounds[0] == bounds[1]


def test_a_motion_that_cannot_be_computed_is_refused():
    with pytest.raises(IdentificationError, match="cannot be computed"):
        fit_to(CandidateTrial(2.5, 4.0), replace(TRUE, values=np.full(6, np.nan)))


def test_a_mirrored_trial_tells_the_same():
    trial = CandidateTrial(np.pi + 0.5, np.pi - 0.2, (WEIGHT,))
    assert trial.mirrored == CandidateTrial(pytest.approx(np.pi - 0.5), pytest.approx(np.pi + 0.2), (WEIGHT,))
    one, other = (information_of(fit_to(each, WITH_WEIGHT), NOISE) for each in (trial, trial.mirrored))
    assert one == pytest.approx(other, rel=1e-6)

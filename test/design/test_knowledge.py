"""What is known of a rig before its next trial."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.design.knowledge import NEW, Knowledge
from cdp_ident.fit.scales import scales_of
from scenarios.next_swing import ALL_GROUPS, NOISE, PRIOR, Swings, swing

SWINGS = Swings.of([swing(3.6, 3.9, np.random.default_rng(0))])
KNOWN = SWINGS.knowledge
SCALES = scales_of(SWINGS.trials, PRIOR.length, PRIOR.gravity, np.full(2, NOISE))


def test_the_next_trial_is_recorded_as_those_before():
    assert KNOWN.sampling.duration == pytest.approx(10, abs=0.1)
    assert KNOWN.sampling.interval == pytest.approx(1 / 200)
    assert KNOWN.noise == pytest.approx(NOISE, rel=0.05)
    assert KNOWN.asked == ALL_GROUPS


def test_the_information_is_the_inverse_of_the_covariance():
    scale = np.sqrt(np.diag(KNOWN.covariance))
    both = (KNOWN.information * np.outer(scale, scale)) @ (KNOWN.covariance / np.outer(scale, scale))
    assert both == pytest.approx(np.eye(5), abs=1e-6)


def test_of_the_zeros_of_a_trial_that_is_not_there_yet_nothing_is_known():
    with_zeros = KNOWN.with_zeros_of_its_own(True)
    place = with_zeros.model.zero_places(NEW)
    assert np.all(np.isinf(np.diag(with_zeros.covariance)[place]))
    assert not np.any(with_zeros.information[place])
    rig = with_zeros.model.of_rig
    assert with_zeros.information[np.ix_(rig, rig)] == pytest.approx(KNOWN.information)
    assert with_zeros.asked == ALL_GROUPS


def test_a_trial_without_a_weight_says_nothing_of_the_inertia():
    inertia = 0.05
    model = replace(SWINGS.fit.model, inertia_free=True)
    fit = replace(SWINGS.fit, model=model, values=np.append(SWINGS.fit.values, 1 / inertia))
    spread = np.zeros((6, 6))
    spread[:5, :5], spread[5, 5] = KNOWN.covariance, 1.0
    known = Knowledge.of(fit, spread, SCALES)
    assert known.asked == ALL_GROUPS
    assert known.model.mechanism.inertia == pytest.approx(inertia)
    assert known.covariance == pytest.approx(KNOWN.covariance)

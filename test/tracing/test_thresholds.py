"""What chance alone gains, by the number of parameters and of what is tried."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2

from cdp_ident.tracing import thresholds
from cdp_ident.tracing.thresholds import least_gain, least_score


@given(st.floats(1.0, 60.0))
def test_chance_gains_enough_anywhere_no_more_often_than_half_the_level(freedom):
    tried = math.comb(thresholds.forms() + 1, 2)  # effects and pairs of them
    assert tried * chi2.sf(least_gain(freedom), freedom) == pytest.approx(thresholds.FAMILY_LEVEL / 2)


def test_what_is_refitted_need_not_gain_what_is_accepted():
    assert all(least_score(freedom) < least_gain(freedom) for freedom in (1.0, 2.0, 6.0, 20.0))


def test_more_parameters_must_gain_more_and_an_instant_at_any_of_a_million_samples_most():
    assert least_gain(1.0) < least_gain(2.0) < least_gain(6.0)
    assert 4e6 * chi2.sf(thresholds.INSTANT_GAIN, 2.0) < thresholds.FAMILY_LEVEL / 2


def test_who_changes_a_threshold_changes_what_follows_from_it(monkeypatch):
    before = least_gain(1.0)
    monkeypatch.setattr(thresholds, "FAMILY_LEVEL", 1e-4)
    assert least_gain(1.0) > before + 5.0

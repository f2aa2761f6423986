"""Single samples that are far off among small errors, and no others, are spikes."""

import numpy as np
import pytest
from scipy.signal import lfilter

from cdp_ident.fit.spikes import spikes

RNG = np.random.default_rng(0)
WHITE = RNG.normal(size=(2000, 2))


def test_spikes_are_found_wherever_they_are_and_however_many_windows_there_are():
    places = [0, 300, 999, 1000, 1001, 1999]
    errors = 1e-3 * WHITE
    errors[places] = [6e-3, -1e-3]
    (whole,) = spikes([errors])
    assert np.flatnonzero(whole).tolist() == places
    parts = spikes([errors[:1000], errors[1000:]])
    assert np.array_equal(np.concatenate(parts), whole)


def test_one_sample_of_white_noise_in_3000_is_one():
    (found,) = spikes([RNG.normal(size=(300_000, 2))])
    assert np.mean(found) == pytest.approx(1.0 / 3000.0, rel=0.3)


def test_what_lasts_is_no_spike():
    errors = WHITE.copy()
    before = spikes([errors])[0]
    errors[500:520] += 8.0
    assert np.array_equal(spikes([errors])[0][480:540], before[480:540] & (np.abs(np.arange(480, 540) - 509.5) > 10))
    slow = lfilter([1.0], [1.0, -0.95], RNG.normal(size=(200_000, 2)), axis=0)
    assert np.mean(spikes([slow])[0]) < 2e-5


@pytest.mark.parametrize("errors", [np.zeros((20, 2)), np.zeros((1, 2)), np.ones((3, 2))])
def test_of_few_samples_or_none_that_differ_none_is_a_spike(errors):
    assert not spikes([errors])[0].any()

"""The spectrum against scipy's."""

import numpy as np
import pytest
from scipy.signal import welch

from cdp_ident.trial.spectrum import power_spectrum


@pytest.mark.parametrize(("samples", "segment"), [(16, 16), (17, 17), (1000, 64), (1000, 65), (1023, 1000)])
def test_frequencies_and_powers_are_those_of_welch_s_method(samples: int, segment: int) -> None:
    signals = np.random.default_rng(1).normal(1.0, 2.0, size=(samples, 3))
    frequency, power = power_spectrum(signals, 200.0, segment)
    expected_frequency, expected = welch(signals, 200.0, nperseg=segment, axis=0)
    assert frequency == pytest.approx(expected_frequency, rel=1e-14)
    assert power == pytest.approx(expected, rel=1e-10, abs=1e-15)

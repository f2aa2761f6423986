"""Autoregressive processes against scipy's filter."""

import numpy as np
import pytest
from scipy.signal import lfilter

from cdp_ident.fit.linear_filter import carried_on

COEFFICIENTS = ([], [0.9], [1.6, -0.7], [0.5, 0.2, -0.1, 0.1, 0.05, -0.05, 0.02, 0.1])


@pytest.mark.parametrize("shape", [(40,), (40, 2), (40, 2, 3), (3, 2), (4, 2, 0), (0, 2)])
@pytest.mark.parametrize("coefficients", COEFFICIENTS)
def test_a_process_is_what_scipy_s_filter_makes_of_what_is_new(
    coefficients: list[float], shape: tuple[int, ...]
) -> None:
    new = np.random.default_rng(1).normal(size=shape)
    expected = lfilter([1.0], [1.0, *np.negative(coefficients)], new, axis=0) if new.size else new
    assert carried_on(np.array(coefficients), new) == pytest.approx(expected, abs=1e-13)

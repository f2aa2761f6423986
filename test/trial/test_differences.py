# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What neighbouring samples tell of an encoder."""

import numpy as np
import pytest

from cdp_ident.trial.differences import encoder_step, fourth_differences
from scenarios.twin import as_measured, standard_motion


def measured(noise, counts_per_turn=None):
    return as_measured(standard_motion(), np.random.default_rng(0), noise, counts_per_turn)


def test_fourth_differences_show_white_noise_as_it_is_and_nothing_of_a_cubic_at_uneven_times():
    rng = np.random.default_rng(0)
    time = np.cumsum(rng.uniform(0.002, 0.008, 4000))
    cubic = np.column_stack([time**3, 5.0 - time**2])
    assert np.abs(fourth_differences(time, cubic)).max() < 1e-9
    noise = rng.normal(0, 1e-3, cubic.shape)
    assert fourth_differences(time, cubic + noise).std(axis=0) == pytest.approx([1e-3, 1e-3], rel=0.05)
    assert fourth_differences(time, noise[:, 0]) == pytest.approx(fourth_differences(time, noise)[:, 0])


@pytest.mark.parametrize("counts", [500, 4096, 8000])
def test_the_step_of_an_encoder_is_seen(counts):
    found = encoder_step(measured(2e-4, counts)[:, 0])
    assert found == pytest.approx(2 * np.pi / counts, rel=1e-6)


def test_angles_without_steps_have_none():
    assert encoder_step(measured(2e-3)[:, 0]) == 0.0
    assert encoder_step(np.full(100, 0.3)) == 0.0

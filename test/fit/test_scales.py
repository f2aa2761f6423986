# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.scales import scales_of
from cdp_ident.trial.trial import Trial

G = 9.81
WHIRLING = np.array([0.24, 0.3, 0.0, 0.0])


def test_the_paper_s_rig_has_the_paper_s_scales(measured):
    scales = scales_of([measured()], 0.4, G)
    assert scales.step == pytest.approx(0.005, rel=1e-3)
    assert scales.window == pytest.approx(2.5, rel=1e-3)


@pytest.mark.parametrize("length", [0.05, 0.17, 2.0])
def test_the_same_motion_of_another_size_has_the_same_scales_in_its_own_time(measured, length):
    own, other = (scales_of([measured(length=of, rate=40.0 / np.sqrt(of / G))], of, G) for of in (0.4, length))
    shrink = np.sqrt(length / 0.4)
    for name in ("time_unit", "step", "window"):
        assert getattr(other, name) == pytest.approx(shrink * getattr(own, name), rel=1e-3), name
    assert other.together == own.together


def test_a_faster_motion_has_finer_steps_and_shorter_windows(measured):
    own, fast = (
        scales_of([measured(rate=1000.0, start=start)], 0.4, G) for start in (np.array([2.0, 2.6, 0.0, 0.0]), WHIRLING)
    )
    for name in ("step", "window"):
        assert getattr(fast, name) < 0.7 * getattr(own, name), name


def test_a_fast_recording_is_averaged_and_a_slow_one_is_not(measured):
    fast, slow = (scales_of([measured(rate=rate)], 0.4, G) for rate in (2000.0, 100.0))
    assert fast.together == 10
    assert slow.together == 1


def test_too_few_samples_are_told():
    few = Trial("few", np.arange(10) / 100.0, np.zeros((10, 2)))
    with pytest.raises(IdentificationError, match=r"time unit of a rig with L = 0\.4 m"):
        scales_of([few], 0.4, G)

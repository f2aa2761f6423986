"""Single samples that stand out are told; noise, resolution, gaps and knocks are not."""

import numpy as np
import pytest

from cdp_ident.trial.outliers import outlier_notes, outliers

TIME = np.arange(4000) / 500.0


def swing(step=0.0, noise=0.0, seed=0):
    angles = np.column_stack([1.5 * np.sin(6 * TIME), 2.0 * np.cos(11 * TIME)])
    angles += noise * np.random.default_rng(seed).normal(size=angles.shape)
    return np.round(angles / step) * step if step else angles


@pytest.mark.parametrize("angles", [swing(), swing(2 * np.pi / 8000), swing(noise=2e-3), swing(0.02)], ids=str)
def test_a_good_recording_has_none(angles):
    assert outlier_notes(*outliers(TIME, angles)) == []


@pytest.mark.parametrize(("at", "size"), [(1000, 0.009), (2500, -0.02)])
def test_a_sample_that_is_off_is_told_with_its_place_and_size(at, size):
    angles = swing(2 * np.pi / 8000)
    angles[at, 1] += size
    time, found = outliers(TIME, angles)
    assert time == pytest.approx([TIME[at]])
    assert found == pytest.approx([abs(size)], abs=1e-3)
    (note,) = outlier_notes(time, found)
    assert note.startswith("1 samples stand out from their neighbours by up to 0.0")


def test_a_gap_is_none():
    kept = np.r_[0:1000, 1020:4000]
    assert outlier_notes(*outliers(TIME[kept], swing()[kept])) == []


def test_a_knock_and_samples_too_few_are_none():
    angles = swing(2 * np.pi / 8000)
    angles[2000:, 0] += 0.5 * (TIME[2000:] - TIME[2000])
    assert outlier_notes(*outliers(TIME, angles)) == []
    assert outlier_notes(*outliers(TIME[:5], angles[:5])) == []

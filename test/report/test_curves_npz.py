# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is read back is what was written, and what was not written by identify is refused."""

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.errors import ReportError
from cdp_ident.report.curves import Curves, TorqueCurves, TrialCurves, curves_npz, read_curves


def some_curves(samples=7, effects=2, trials=2):
    def angles():
        return np.arange(2.0 * samples).reshape(samples, 2)

    time, index, flags = np.arange(samples) / 200, np.arange(samples), np.arange(samples) % 2 == 0
    trial = TrialCurves(time, time, index, flags, *(angles() for _ in range(5)))
    before, after = (
        TorqueCurves(index, time, *(angles() for _ in range(4)), np.zeros((count, samples, 2)))
        for count in (0, effects)
    )
    return Curves((trial,) * trials, before, after)


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "curves.npz"
    path.write_bytes(curves_npz(some_curves()))
    return path


def arrays_of(path):
    with np.load(path, allow_pickle=False) as content:
        return dict(content)


def test_curves_are_read_as_they_were_written(shown_curves, tmp_path):
    (tmp_path / "curves.npz").write_bytes(curves_npz(shown_curves))
    read = read_curves(tmp_path / "curves.npz", 3, 1)
    for part, written in zip(
        (*read.trials, read.before, read.after),
        (*shown_curves.trials, shown_curves.before, shown_curves.after),
        strict=True,
    ):
        for field in fields(part):
            assert np.array_equal(getattr(part, field.name), getattr(written, field.name), equal_nan=True)


def test_torques_may_be_of_no_sample_where_effects_were_not_looked_for(tmp_path):
    none = np.zeros((0, 2))
    torques = TorqueCurves(np.zeros(0, dtype=np.int64), np.zeros(0), none, none, none, none, np.zeros((0, 0, 2)))
    (tmp_path / "curves.npz").write_bytes(curves_npz(replace(some_curves(), before=torques, after=torques)))
    assert len(read_curves(tmp_path / "curves.npz", 2, 0).after.time) == 0


def test_the_same_curves_give_the_same_bytes():
    assert curves_npz(some_curves()) == curves_npz(some_curves())


@pytest.mark.parametrize(("trials", "effects"), [(3, 2), (2, 1), (2, 3)])
def test_curves_of_another_report_are_refused(path, trials, effects):
    with pytest.raises(ReportError, match=r"does not fit its report\.json"):
        read_curves(path, trials, effects)


@pytest.mark.parametrize(
    ("name", "array", "words"),
    [
        ("format", np.array("cdp_ident/curves/9"), "not of the format"),
        ("format", None, "not of the format"),
        ("trial0.measured", np.zeros((7, 3)), r"not float64 of shape \(7, 2\)"),
        ("trial0.before", np.full((7, 2), "x"), "trial0.before"),
        ("trial1.window", np.zeros(7), "not int64"),
        ("torques_after.effects", np.zeros((2, 6, 2)), "torques_after.effects"),
        ("trial0.time", np.full(7, np.nan), "has no time in it"),
        ("trial1.time", np.full(7, 1e308), "has no time in it"),
        ("trial0.time", np.zeros(0), "trial0.time"),
        ("trial1.run_after", None, "trial1.run_after is missing"),
        ("trial0.cart", np.array([print] * 7, dtype=object), "cannot be read"),  # a pickle, which is not opened
    ],
)
def test_arrays_that_are_not_what_they_should_be_are_refused(path, name, array, words):
    arrays = arrays_of(path) | {name: array}
    np.savez(path, **{key: value for key, value in arrays.items() if value is not None})
    with pytest.raises(ReportError, match=words):
        read_curves(path, 2, 2)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(ReportError, match=r"there is no .*curves\.npz"):
        read_curves(tmp_path / "curves.npz", 1, 0)


def test_a_file_that_unfolds_to_too_much_is_not_unfolded(path, monkeypatch):
    monkeypatch.setattr("cdp_ident.report.curves._LARGEST", 10_000)
    np.savez_compressed(path, zeros=np.zeros(10_000))
    with pytest.raises(ReportError, match="would unfold to"):
        read_curves(path, 2, 2)


@given(st.integers(0, 10_000), st.integers(0, 255))
def test_damage_anywhere_is_refused_or_does_no_harm(tmp_path_factory, place, value):
    data = bytearray(curves_npz(some_curves()))
    data[place % len(data)] = value
    path = tmp_path_factory.mktemp("damaged") / "curves.npz"
    path.write_bytes(data)
    try:
        read = read_curves(path, 2, 2)
    except ReportError:
        return
    assert len(read.trials) == 2


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e308])
def test_what_is_larger_than_anything_measured_is_not_a_number(path, value):
    arrays = arrays_of(path)
    arrays["trial0.measured"] = np.array(arrays["trial0.measured"])
    arrays["trial0.measured"][3, 1] = value
    np.savez(path, **arrays)
    measured = read_curves(path, 2, 2).trials[0].measured
    assert np.flatnonzero(np.isnan(measured)).tolist() == [7]

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Windows are as long as the motion can be followed, by the model that is found."""

from types import SimpleNamespace

import numpy as np
import pytest

from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.model.parameters import SYMBOLS, groups_of
from cdp_ident.pipeline import identify_and_trace as module
from cdp_ident.pipeline.identify_and_trace import identify_and_trace
from reference.pendulum import TABLE_5
from scenarios.twin import TEN_SECONDS, twin

STARTS = ((2.2, 2.6, 0.0, 0.0), (2.4, 3.6, 0.0, 0.0), (1.9, 3.0, 0.0, 0.0))
NOISE = 5e-4
INERTIAS = slice(0, 3)


def by_chance(rng, size=6e-3):
    """Return a torque in the outer joint [N m] that goes up and down by chance, 0.3 to 4 times a second."""
    waves = 30
    frequency, phase = rng.uniform(0.3, 4.0, waves), rng.uniform(0.0, 2.0 * np.pi, waves)

    def torque(time, state):
        outer = size * np.sqrt(2.0 / waves) * np.sum(np.sin(2.0 * np.pi * frequency * time + phase))
        return -outer, outer

    return torque


@pytest.fixture(scope="module")
def trials():
    return [
        twin(
            np.random.default_rng(k),
            start=start,
            times=TEN_SECONDS,
            noise=NOISE,
            torque=by_chance(np.random.default_rng(k)),
            tolerance=1e-8,
            name=f"swing{k}",
        )
        for k, start in enumerate(STARTS)
    ]


@pytest.mark.long
def test_a_motion_with_chance_in_it_is_judged_over_half_a_swing_and_its_values_are_right(trials):
    said = []
    options = IdentifyOptions(named_effects_only=True)
    found, traced = identify_and_trace(trials[:2], trials[2:], options, say=said.append)
    assert any("are too long for this motion" in line for line in said)
    assert traced.longer.duration > 1.5 * found.data.scales.half_swing >= 1.2 * found.data.window
    assert traced.errors["effects"].holdout.rmse < 0.6 * traced.longer.error
    assert not traced.effects  # chance is none of them
    truth = groups_of([TABLE_5[symbol] for symbol in SYMBOLS], TABLE_5["L"])
    off = np.abs(traced.completed.fit.values[INERTIAS] / truth[INERTIAS] - 1.0)
    assert off.max() < 1e-3


@pytest.mark.campaign
def test_windows_whose_length_is_given_keep_it(trials):
    options = IdentifyOptions(window=2.0, named_effects_only=True)
    found, traced = identify_and_trace(trials[:2], trials[2:], options)
    assert traced.longer is None
    assert found.data.window == pytest.approx(2.0, rel=0.1)


def test_where_the_fit_itself_fails_shorter_windows_are_of_no_use(monkeypatch):
    failed = SimpleNamespace(failure="no motion", data=SimpleNamespace(window=4.0))
    monkeypatch.setattr(module, "identify", lambda *_: failed)
    monkeypatch.setattr(module, "trace", lambda *_: SimpleNamespace(failure="no motion"))
    found, _ = identify_and_trace([], [], IdentifyOptions())
    assert found is failed

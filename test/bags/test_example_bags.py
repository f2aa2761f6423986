# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The example bags are what their README says."""

import importlib.util
import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from cdp_ident.bag.reader import read_joint_states
from cdp_ident.demo.recording import RIG, swing_times
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.pipeline.identify import identify
from cdp_ident.rig.emulator.configuration import load_rig
from cdp_ident.rig.emulator.motion import Motion
from cdp_ident.tracing.trace import trace
from cdp_ident.trial.load import load_trial

BAGS = Path(__file__).parents[2] / "bags"
SPEC = importlib.util.spec_from_file_location("make_bags", BAGS / "make_bags.py")
make_bags = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(make_bags)


@cache
def emulated_counts():
    """Return what the joints' encoders count at each sample of the rig's script (n, 2)."""
    rig = load_rig(RIG)
    samples = Motion(rig.coefficients(), rig.script, 1 / rig.rate, rig.effects).advance(round(60 * rig.rate))
    joints = np.column_stack([samples[:, 1], samples[:, 2] - samples[:, 1]])
    counts = np.array([rig.encoders.inner_counts_per_turn, rig.encoders.outer_counts_per_turn])
    return np.round(joints * counts / math.tau)


@pytest.mark.parametrize(("place", "name"), enumerate(make_bags.NAMES))
def test_they_are_recordings_of_the_rig_beside_which_they_stand(place, name):
    recording = read_joint_states(BAGS / name, "joint_states")
    assert recording.joints == ("cart_joint", "inner_joint", "outer_joint")
    counts = recording.positions[:, 1:] * 8000 / math.tau
    made = emulated_counts()
    begins = np.flatnonzero(np.all(np.abs(made[: len(made) - len(counts)] - counts[0]) < 0.01, axis=1))
    errors = [np.abs(made[begin : begin + len(counts)] - counts).max() for begin in begins]
    # One count: they were recorded when the emulator's dry friction was smooth near rest.
    assert min(errors) < 1.01
    between_releases = 15.0  # [s] in the script
    assert begins[int(np.argmin(errors))] / 200 == pytest.approx(7.6 + between_releases * place, abs=0.3)


@pytest.mark.parametrize("name", make_bags.NAMES)
def test_they_are_small_complete_and_another_reader_reads_them(name):
    assert sum(file.stat().st_size for file in (BAGS / name).iterdir()) < 1_000_000
    with AnyReader([BAGS / name]) as reader:
        facts = reader.readers[0].custom_data
        assert reader.message_count == int(facts["samples"]) + 13  # diagnostics, once a second
    assert (facts["samples_lost"], facts["cart_at_rest"], facts["warnings"]) == ("0", "true", "")


@pytest.mark.parametrize("name", make_bags.NAMES)
def test_the_free_swing_is_found_in_them(name):
    trial = load_trial(BAGS / name)
    assert 1.0 <= trial.start <= 1.3
    assert trial.start + trial.duration == pytest.approx(13.0, abs=0.1)
    assert trial.duration < min(swing_times(RIG))


def test_one_alone_shows_it_too_and_nothing_else(outcome_alone):
    assert [effect.active.effect.key for effect in outcome_alone.trace.effects] == ["coulomb_friction.outer"]


@pytest.mark.campaign
@pytest.mark.parametrize("name", make_bags.NAMES[1:])
def test_any_other_alone_shows_it_too_and_nothing_else(name):
    found = trace(identify([load_trial(BAGS / name)], [], IdentifyOptions()))
    assert [effect.active.effect.key for effect in found.effects] == ["coulomb_friction.outer"]


def test_identify_names_what_is_hidden_in_them_and_nothing_else(outcome):
    found = outcome.trace
    (effect,) = found.effects
    assert effect.active.effect.key == "coulomb_friction.outer"
    assert effect.rmse_holdout_before > 10 * effect.rmse_holdout_after
    assert not found.unexplained.significant

"""The example bags are what their README says."""

import importlib.util
import json
from pathlib import Path

import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from cdp_ident.bag.reader import read_joint_states
from cdp_ident.trial.load import load_trial

BAGS = Path(__file__).parents[2] / "bags"
SPEC = importlib.util.spec_from_file_location("make_bags", BAGS / "make_bags.py")
make_bags = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(make_bags)


@pytest.mark.parametrize("name", make_bags.STARTS)
def test_the_script_makes_them_anew(name):
    recording = read_joint_states(BAGS / name, "joint_states")
    made = make_bags.positions(make_bags.STARTS[name])
    one_count = 2 * np.pi / make_bags.COUNTS_PER_TURN
    assert recording.joints == ("cart_joint", "inner_joint", "outer_joint")
    assert np.abs(recording.positions - made).max() <= 1.01 * one_count
    assert np.mean(recording.positions == made) > 0.99


@pytest.mark.parametrize("name", make_bags.STARTS)
def test_they_are_small_and_another_reader_reads_them(name):
    assert sum(file.stat().st_size for file in (BAGS / name).iterdir()) < 1_000_000
    with AnyReader([BAGS / name]) as reader:
        assert reader.message_count == 3600
        truth = json.loads(reader.readers[0].custom_data["truth"])
    assert truth == make_bags.TRUTH
    readme = (BAGS / "README.md").read_text()
    assert all(f"{symbol} {value:g}" in readme.replace("\n", " ") for symbol, value in truth.items())


@pytest.mark.parametrize("name", make_bags.STARTS)
def test_the_free_swing_is_found_in_them(name):
    trial = load_trial(BAGS / name)
    assert 4.0 <= trial.start <= 4.3
    assert trial.start + trial.duration == pytest.approx(3599 / 200)

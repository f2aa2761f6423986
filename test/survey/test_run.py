# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a survey has to do."""

import pytest

from cdp_ident.bag.writer import BagWriter
from cdp_ident.errors import OptionError
from cdp_ident.survey.run import plan

NOON = 1_717_156_800_000_000_000
WEIGHT = "trials.one.added.outer"


@pytest.fixture
def trials(tmp_path):
    for number, name in enumerate(("one", "two")):
        with BagWriter(tmp_path / "trials" / name) as writer:
            writer.write("/joint_states", "sensor_msgs/msg/JointState", NOON + number, b"\0\1\0\0" + bytes([number]))
            writer.close()
    return tmp_path / "trials"


def keys(trials, given):
    return {task.piece.name: task.key for task in plan([trials], trials / "out", "bag", given).tasks}


def test_a_weight_concerns_the_piece_of_its_bag_alone(trials):
    plain, weighted = keys(trials, {}), keys(trials, {WEIGHT: [0.2, 0.3]})
    assert plain["one"] != weighted["one"]
    assert plain["two"] == weighted["two"]


def test_a_weight_of_a_bag_that_is_not_there_is_refused(trials):
    with pytest.raises(OptionError, match=r"bag of a weight .*'three'"):
        plan([trials], trials / "out", "bag", {"trials.three.added.outer": [0.2, 0.3]})


def test_the_configuration_is_checked_before_any_bag_is_read(tmp_path):
    with pytest.raises(OptionError, match="unknown key"):
        plan([tmp_path / "nowhere"], tmp_path / "out", "day", {"seeed": 2})

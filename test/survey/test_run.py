# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bags are grouped by rig and into pieces; what a survey has to do, and what is kept of a finished piece."""

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from cdp_ident.bag.writer import BagWriter
from cdp_ident.errors import OptionError
from cdp_ident.report.folder import REPORT
from cdp_ident.survey.run import RECORD, Piece, SurveyedBag, Task, finished, pieces_of, plan, surveyed
from scenarios.fleet import NOON

WEIGHT = "trials.one.added.outer"
HOUR = 3_600_000_000_000
TRIALS = Path("/trials")


def write(folder, stamp=NOON, **custom):
    with BagWriter(folder) as writer:
        writer.write("/joint_states", "sensor_msgs/msg/JointState", stamp, b"\0\1\0\0" + bytes(folder.name, "utf-8"))
        writer.close(custom)
    return folder


def rigs(bags):
    found, _ = surveyed(bags, "joint_states")
    return {bag.path.name: (bag.rig, bag.named_by) for bag in found}


def bag(name, rig="/rig1/driver", start=NOON):
    return SurveyedBag(TRIALS / name, rig, "recorder", start, (f"sum of {name}",))


def test_the_recorder_s_name_groups_bags_wherever_they_are(tmp_path):
    one = write(tmp_path / "a" / "one", rig_name="/rig1/driver")
    two = write(tmp_path / "b" / "two", rig_name="/rig1/driver")
    assert rigs([one, two]) == {"one": ("/rig1/driver", "recorder"), "two": ("/rig1/driver", "recorder")}


def test_a_bag_without_a_name_is_of_the_rig_of_its_neighbours_or_called_as_the_folder(tmp_path):
    bags = [
        write(tmp_path / "a" / "named", rig_name="/rig1/driver"),
        write(tmp_path / "a" / "salvaged"),
        write(tmp_path / "mixed" / "first", rig_name="/rig2/driver"),
        write(tmp_path / "mixed" / "second", rig_name="/rig3/driver"),
        write(tmp_path / "mixed" / "third"),
        write(tmp_path / "bench" / "own"),
    ]
    found = rigs(bags)
    assert found["salvaged"] == ("/rig1/driver", "neighbours")
    assert found["third"] == ("mixed", "folder")
    assert found["own"] == ("bench", "folder")


def test_copies_and_what_cannot_be_read_are_left_out_with_the_reason(tmp_path):
    one = write(tmp_path / "one")
    shutil.copytree(one, tmp_path / "two")
    (tmp_path / "three").mkdir()
    (tmp_path / "three" / "three_0.mcap").write_bytes(b"no recording")
    found, left_out = surveyed([one, tmp_path / "two", tmp_path / "three"], "joint_states")
    assert [bag.name for bag in found] == ["one"]
    assert [bag.bag.rpartition("/")[2] for bag in left_out] == ["two", "three"]
    assert "the same bag as" in left_out[0].reason
    assert "not an MCAP file" in left_out[1].reason


def test_pieces_are_days_or_bags_in_the_order_of_time():
    bags = [bag("late", start=NOON + 30 * HOUR), bag("b"), bag("a", start=NOON + HOUR), bag("other", "/rig2/driver")]
    days = list(pieces_of(bags, "day"))
    assert [(piece.rig, [bag.name for bag in piece.bags]) for piece in days] == [
        ("/rig1/driver", ["b", "a"]),
        ("/rig1/driver", ["late"]),
        ("/rig2/driver", ["other"]),
    ]
    assert all(re.fullmatch(r"2024-0\d-\d\d", piece.name) for piece in days)
    assert [piece.name for piece in pieces_of(bags, "bag")] == ["b", "a", "late", "other"]


def test_bags_of_one_name_have_folders_of_their_own():
    one, two = bag("one"), replace(bag("one", start=NOON + HOUR), path=TRIALS / "elsewhere" / "one")
    first, second = pieces_of([one, two], "bag")
    assert first.folder != second.folder


@pytest.mark.parametrize("rig", ["../../etc", "/", "..", "a b/\u202e\n", "x" * 300, "rig1_driver", "/rig1/driver"])
def test_a_folder_s_name_is_one_whatever_the_rig_s(rig):
    (piece,) = pieces_of([bag("one", rig)], "day")
    assert re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9._-]{8,80}", piece.folder)
    assert piece.folder != Piece(f"{rig}.", piece.name, piece.bags).folder


def test_a_piece_is_another_with_other_bags_or_another_configuration():
    (piece,) = pieces_of([bag("one"), bag("two")], "day")
    keys = {
        piece.key({"L": 0.4, "seed": 1}),
        piece.key({"L": 0.5, "seed": 1}),
        replace(piece, bags=piece.bags[:1]).key({"L": 0.4, "seed": 1}),
        replace(piece, bags=(replace(piece.bags[0], checksums=("other",)), piece.bags[1])).key({"L": 0.4, "seed": 1}),
        replace(piece, bags=(replace(piece.bags[0], custom_data={"added": "{}"}), piece.bags[1])).key(
            {"L": 0.4, "seed": 1}
        ),
    }
    assert len(keys) == 5
    assert piece.key({"seed": 1, "L": 0.4}) in keys


@pytest.fixture
def trials(tmp_path):
    for number, name in enumerate(("one", "two")):
        write(tmp_path / "trials" / name, NOON + number)
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


@pytest.mark.parametrize("place", ["bag", "reason", "failure"])
def test_what_a_record_says_commands_no_terminal(report_folder, tmp_path, place):
    hostile = "\x1b]0;owned\x07 \u202e and so on"
    record = {"schema": "cdp_ident/piece/1", "key": "key", "failure": "", "left_out": [{"bag": "one", "reason": "bad"}]}
    of = record if place == "failure" else record["left_out"][0]
    of[place] = hostile
    shutil.copy(report_folder / REPORT, tmp_path)
    (tmp_path / RECORD).write_text(json.dumps(record))
    found = finished(Task(Piece("rig", "day", ()), tmp_path, {}, "key"))
    assert found is not None
    said = " ".join([found.problem, found.left_out[0].bag, found.left_out[0].reason])
    assert said.isprintable()
    assert "owned" in said

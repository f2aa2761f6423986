# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Trials to bags, read back by a reader of others."""

import contextlib
import os
import resource
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml
from rosbags.highlevel import AnyReader

from cdp_ident.bag.joint_state import MESSAGE_TYPE, serialize_joint_state, typestore
from cdp_ident.bag.metadata import OFFERED_QOS_PROFILES
from cdp_ident.errors import RigError
from cdp_ident.model.parameters import NOMINAL, physical_coefficients
from cdp_ident.rig.emulator.motion import Hold, LetGo, Motion, MoveCart, Wait
from cdp_ident.rig.recording.facts import RecorderOptions
from cdp_ident.rig.recording.recorder import ARMED, IDLE, RECORDING, Recorder, Surroundings

EPOCH_NS = 1_760_000_000_000_000_000
PERIOD_NS = 5_000_000
NAMES = ["cart_joint", "inner_joint", "outer_joint"]
OFFERED = {
    "/joint_states": {**OFFERED_QOS_PROFILES[0], "reliability": "best_effort"},
    "/diagnostics": OFFERED_QOS_PROFILES[0],
}
HEAVY = physical_coefficients(NOMINAL | {"c1": 0.1, "c2": 0.05})
TRIAL = (Wait(1.0), Hold(1.5, 1.5, 1.0), Wait(1.0), LetGo(), Wait(15.0))


class Bench:
    """A recorder that is fed with a script's motion at 200 Hz."""

    def __init__(self, folder, *script, **options):
        self.said = []
        self.warned = []
        self.states = []
        self.bags = []
        self.sent = []
        self.motion = Motion(HEAVY, script or TRIAL, PERIOD_NS * 1e-9)
        self.now_ns = EPOCH_NS
        self.recorder = Recorder(
            RecorderOptions(folder, **options),
            Surroundings(
                say=self.said.append,
                warn=self.warned.append,
                on_state=self.states.append,
                on_bag=self.bags.append,
                drivers=lambda: {"/rig1/driver"},
                offered=lambda topic: [OFFERED[topic]],
            ),
        )

    def run(self, seconds, silent=False):
        for cart, theta1, theta2 in self.motion.advance(round(seconds * 200))[:, :3]:
            self.now_ns += PERIOD_NS
            if not silent:
                self.sent.append((self.now_ns, theta1))
                raw = serialize_joint_state(NAMES, [cart, theta1, theta2 - theta1], self.now_ns)
                self.recorder.take("/joint_states", MESSAGE_TYPE, self.now_ns, raw)
            if self.now_ns % 250_000_000 == 0:
                self.recorder.tick(self.now_ns)


def read(bag):
    with AnyReader([bag], default_typestore=typestore()) as reader:
        messages = [reader.deserialize(raw, connection.msgtype) for connection, _, raw in reader.messages()]
    return [
        (message.header.stamp.sec * 10**9 + message.header.stamp.nanosec, message.position[1]) for message in messages
    ]


def custom_data(bag):
    return dict(yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]["custom_data"])


@contextlib.contextmanager
def files_of_at_most(size):
    """Let the disk take no file that is larger [bytes]."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.fixture
def fill_disk(tmp_path, monkeypatch):
    """Leave no space on the disk."""
    usage = shutil.disk_usage(tmp_path)._replace(free=1000)
    return lambda: monkeypatch.setattr(shutil, "disk_usage", lambda _: usage)


def test_an_armed_recorder_records_one_trial_from_before_the_release_to_the_rest(tmp_path):
    bench = Bench(tmp_path)
    bench.recorder.arm()
    bench.run(18.0)
    (bag,) = bench.bags
    assert bench.states == [IDLE, ARMED, RECORDING, IDLE]
    recorded = read(bag)
    first = bench.sent.index(recorded[0])
    assert recorded == bench.sent[first : first + len(recorded)]
    facts = custom_data(bag)
    released = int(facts["released_at_ns"])
    assert released - recorded[0][0] == pytest.approx(1e9, abs=2e7)
    assert 3.0 < (released - EPOCH_NS) * 1e-9 < 3.4
    assert facts["ended"] == "the pendulum came to rest"
    assert np.ptp([angle for _, angle in recorded[-200:]]) <= 0.011
    assert facts["samples"] == str(len(recorded))
    assert facts["cart_at_rest"] == "true"


CATCHES = (Wait(1.0), *3 * (Hold(1.5, 1.5, 0.7), Wait(0.7), LetGo(), Wait(2.0)), Wait(15.0))


def test_a_catch_ends_a_trial_and_the_next_release_begins_another(tmp_path):
    bench = Bench(tmp_path, *CATCHES, rearm=True)
    bench.run(28.0)
    assert [custom_data(bag)["ended"] for bag in bench.bags] == [
        *2 * ["the pendulum was caught"],
        "the pendulum came to rest",
    ]
    assert [custom_data(bag)["started"] for bag in bench.bags] == 3 * ["by release"]


@pytest.mark.parametrize("held", [0.95, 1.0, 1.05])
def test_the_release_after_a_catch_is_not_lost_however_long_the_hand_holds(tmp_path, held):
    swing = (Hold(1.5, 1.5, 0.7), Wait(held), LetGo(), Wait(2.0))
    bench = Bench(tmp_path, Wait(1.0), *4 * swing, Wait(15.0), rearm=True)
    bench.run(1.0 + 4 * (2.7 + held) + 12.0)
    assert [custom_data(bag)["started"] for bag in bench.bags] == 4 * ["by release"]


def test_a_gap_is_noted_and_the_swing_goes_on(tmp_path):
    bench = Bench(tmp_path, shortest=1.0)
    bench.recorder.arm()
    bench.run(4.0)
    bench.run(1.05, silent=True)
    bench.run(13.0)
    (bag,) = bench.bags
    facts = custom_data(bag)
    assert facts["ended"] == "the pendulum came to rest"
    assert facts["longest_gap_s"] == "1.055"
    assert facts["warnings"].startswith("210 of ")
    assert facts["warnings"].endswith("samples are lost, the longest gap is 1.055 s")


def test_not_rearmed_only_the_first_of_several_swings_is_recorded(tmp_path):
    bench = Bench(tmp_path, *CATCHES)
    bench.recorder.arm()
    bench.run(28.0)
    assert [custom_data(bag)["ended"] for bag in bench.bags] == ["the pendulum was caught"]


def test_a_clock_that_is_set_back_leaves_nothing_behind_in_memory(tmp_path):
    bench = Bench(tmp_path)
    bench.run(3.0)
    bench.now_ns -= 3_600_000_000_000
    before = len(bench.sent)
    bench.run(3.0)
    bag = bench.recorder.start(bench.now_ns)
    bench.recorder.stop()
    assert read(bag) == bench.sent[-201:]
    assert len(bench.sent) == before + 600


def test_messages_from_before_a_start_are_kept_up_to_a_size(tmp_path, monkeypatch):
    monkeypatch.setattr("cdp_ident.rig.recording.recorder._MOST_BYTES", 10_000)
    bench = Bench(tmp_path)
    bench.run(3.0)
    bag = bench.recorder.start(bench.now_ns)
    bench.recorder.stop()
    kept = read(bag)
    assert 0 < len(kept) < 100
    assert kept == bench.sent[-len(kept) :]


def test_a_bag_s_folder_is_told_absolutely(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    bench = Bench(Path("trials"))
    bench.run(0.1)
    bench.recorder.start(bench.now_ns)
    bench.recorder.stop()
    (bag,) = bench.bags
    assert bag.is_absolute()
    assert bag.parent == tmp_path / "trials"


def test_start_and_stop_by_hand_record_what_is_between_and_a_moment_before(tmp_path):
    bench = Bench(tmp_path)
    bench.run(2.0)
    bag = bench.recorder.start(bench.now_ns)
    bench.run(3.0)
    assert bench.recorder.stop() == bag
    assert read(bag) == bench.sent[199:]
    assert custom_data(bag)["started"] == "by hand"


def test_a_moving_cart_lost_samples_and_a_short_trial_are_said_and_kept_as_metadata(tmp_path):
    bench = Bench(tmp_path, Hold(1.5, 1.5, 1.0), Wait(1.0), LetGo(), Wait(0.5), MoveCart(0.05, 0.5), Wait(9.0))
    bench.recorder.arm()
    bench.run(2.8)
    bench.run(0.1, silent=True)
    bench.run(1.0)
    bag = bench.recorder.stop()
    assert bag is not None
    warnings = custom_data(bag)["warnings"]
    for words in ("not zero-input: the cart moved by 0.05 m", "20 of", "too short"):
        assert words in warnings
        assert any(words in warned for warned in bench.warned)


def test_when_joint_states_stop_the_trial_ends(tmp_path):
    bench = Bench(tmp_path)
    bench.recorder.arm()
    bench.run(5.0)
    assert bench.recorder.state == RECORDING
    bench.run(6.0, silent=True)
    assert custom_data(bench.bags[0])["ended"] == "no joint states came any more"


def test_what_cannot_be_done_now_is_refused_with_the_reason(tmp_path):
    bench = Bench(tmp_path)
    with pytest.raises(RigError, match="nothing to stop"):
        bench.recorder.stop()
    with pytest.raises(RigError, match="no joint states"):
        bench.recorder.start(EPOCH_NS)
    bench.run(0.1)
    bench.recorder.start(bench.now_ns)
    with pytest.raises(RigError, match="already"):
        bench.recorder.start(bench.now_ns)
    with pytest.raises(RigError, match="being recorded"):
        bench.recorder.arm()


def test_disarmed_it_records_nothing(tmp_path):
    bench = Bench(tmp_path)
    bench.recorder.arm()
    bench.run(0.5)
    assert bench.recorder.stop() is None
    bench.run(17.0)
    assert bench.bags == []
    assert list(tmp_path.iterdir()) == []


def test_joint_states_without_the_pendulums_joints_are_told_once(tmp_path):
    bench = Bench(tmp_path)
    for stamp in range(3):
        bench.recorder.take("/joint_states", MESSAGE_TYPE, stamp, serialize_joint_state(["elbow"], [1.0], stamp))
    (warned,) = bench.warned
    assert "no positions of inner_joint and outer_joint" in warned


def test_a_folder_that_is_none_is_told_at_once(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(RigError, match="nothing can be recorded in"):
        Bench(tmp_path / "file")


def test_too_little_space_refuses_to_arm(tmp_path, fill_disk):
    bench = Bench(tmp_path)
    fill_disk()
    with pytest.raises(RigError, match="only 0 MB are free"):
        bench.recorder.arm()


def test_a_disk_that_is_too_full_to_arm_again_is_said(tmp_path, fill_disk):
    bench = Bench(tmp_path, rearm=True)
    bench.run(6.0)
    assert bench.recorder.state == RECORDING
    fill_disk()
    bench.recorder.stop()
    assert len(bench.bags) == 1
    assert "only 0 MB are free" in bench.recorder.problem
    assert any("only 0 MB are free" in warned for warned in bench.warned)


def test_a_folder_that_went_away_is_made_anew_and_said(tmp_path):
    bench = Bench(tmp_path / "trials")
    (tmp_path / "trials").rmdir()
    bench.recorder.arm()
    assert bench.said == 2 * [f"made {tmp_path / 'trials'}, which was not there"]


def test_a_disk_that_takes_no_more_is_said_at_once_and_what_was_written_is_completed_at_the_next_start(tmp_path):
    bench = Bench(tmp_path)
    bench.run(1.0)
    bag = bench.recorder.start(bench.now_ns)
    bench.run(2.0)
    (file,) = bag.glob("*.mcap")
    with files_of_at_most(file.stat().st_size + 1000):
        bench.run(1.0)
    assert bench.recorder.state == IDLE
    assert any("cannot be written: File too large" in warned for warned in bench.warned)
    assert "File too large" in bench.recorder.problem
    again = Bench(tmp_path)
    assert any("completed a bag" in said for said in again.said)
    kept = read(bag)
    first = bench.sent.index(kept[0])
    assert kept == bench.sent[first : first + len(kept)]
    assert kept[0][0] <= EPOCH_NS + PERIOD_NS * 2
    assert kept[-1][0] >= EPOCH_NS + 2_700_000_000


def test_a_bag_that_is_removed_while_it_is_recorded_is_said_at_once(tmp_path):
    bench = Bench(tmp_path)
    bench.run(1.0)
    shutil.rmtree(bench.recorder.start(bench.now_ns))
    bench.run(0.5)
    assert bench.recorder.state == IDLE
    assert "it was removed meanwhile; recording stops" in bench.recorder.problem
    assert len(bench.warned) == 1


@pytest.mark.parametrize("by_hand", [True, False])
def test_a_disk_that_does_not_take_the_first_samples_is_no_success(tmp_path, by_hand):
    bench = Bench(tmp_path)
    if not by_hand:
        bench.recorder.arm()
    bench.run(0.5)
    with files_of_at_most(1000):
        if by_hand:
            with pytest.raises(RigError, match="File too large"):
                bench.recorder.start(bench.now_ns)
        else:
            bench.run(8.0)
    assert bench.recorder.state == IDLE
    assert "File too large" in bench.recorder.problem
    assert RECORDING not in bench.states
    assert not any("recording" in said for said in bench.said)


@pytest.mark.parametrize("position", [1e308, -1e308, float("inf"), float("nan")])
def test_a_position_that_no_pendulum_has_changes_nothing(tmp_path, position):
    bench = Bench(tmp_path)
    bench.recorder.arm()
    bench.run(2.5)
    for place in range(3):
        positions = [position if at == place else 3.0 for at in range(3)]
        raw = serialize_joint_state(NAMES, positions, bench.now_ns)
        bench.recorder.take("/joint_states", MESSAGE_TYPE, bench.now_ns, raw)
    assert bench.recorder.state == ARMED
    bench.run(15.0)
    assert len(bench.bags) == 1


@pytest.mark.parametrize("name", ["../x", "/x", "a/b", "..", "", "a\nb", "漢" * 70])
def test_a_name_that_leads_out_of_the_folder_is_refused(tmp_path, name):
    with pytest.raises(RigError, match="is no name for bags"):
        Bench(tmp_path, name=name)


def test_a_bag_of_the_longest_name_is_recorded(tmp_path):
    bench = Bench(tmp_path, name="x" * 200)
    bench.recorder.arm()
    bench.run(17.5)
    assert len(bench.bags) == 1


def test_bags_that_cannot_be_read_do_not_keep_it_from_starting(tmp_path):
    (tmp_path / "odd").mkdir()
    (tmp_path / "odd/metadata.yaml").write_text("")
    os.mkfifo(tmp_path / "odd/odd_0.mcap")
    (warning,) = Bench(tmp_path).warned
    assert warning == f"left as it is: {tmp_path}/odd cannot be read: it is not a regular file"


def test_a_folder_that_nobody_may_enter_any_more_is_said(tmp_path):
    bench = Bench(tmp_path / "bags")
    bench.recorder.arm()
    shutil.rmtree(tmp_path / "bags")
    (tmp_path / "bags").write_text("")
    bench.run(17.5)
    assert bench.recorder.state == IDLE
    assert "Not a directory" in bench.recorder.problem


START = """
import sys
from pathlib import Path
from cdp_ident.rig.recording.recorder import Recorder, Surroundings
from cdp_ident.rig.recording.facts import RecorderOptions
sys.stdin.readline()
recorder = Recorder(RecorderOptions(Path(sys.argv[1])), Surroundings(print))
recorder._last_sample_ns = 10**18
recorder.start(10**18)
sys.stdin.readline()
recorder.close()
"""


@pytest.mark.parametrize("attempt", range(3))
def test_three_recorders_started_together_complete_old_bags_once_and_leave_each_other_s_alone(tmp_path, attempt):
    left = Bench(tmp_path, Wait(60))
    left.run(1.0)
    bag = left.recorder.start(left.now_ns)
    left.run(1.0)
    left.recorder._trial.writer._stream.close()  # as a kill leaves it
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", START, str(tmp_path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        for _ in range(3)
    ]
    for process in processes:
        process.stdin.write("\n")
        process.stdin.flush()
    said = [process.communicate("\n", timeout=300)[0] for process in processes]
    assert [process.returncode for process in processes] == [0, 0, 0]
    assert "".join(said).count("completed a bag") == 1
    assert len(read(bag)) > 200
    bags = [folder for folder in tmp_path.iterdir() if folder.is_dir()]
    assert len(bags) == 4
    assert all((folder / "metadata.yaml").is_file() for folder in bags)

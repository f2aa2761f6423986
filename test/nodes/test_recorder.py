"""Emulator, driver and recorder together."""

import signal
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from rosbags.highlevel import AnyReader

from cdp_ident.bag.joint_state import typestore

Start = Callable[..., Any]
TRIAL = """
parameters: {c1: 0.1, c2: 0.05}
script: [wait: 3, hold: {theta1: 1.8, theta2: 1.8, within: 0.6}, wait: 0.6, let_go, wait: 8]
repeat: 100
"""


def stamps(bag: Path) -> Any:
    with AnyReader([bag], default_typestore=typestore()) as reader:
        messages: list[Any] = [
            reader.deserialize(raw, connection.msgtype)
            for connection, _, raw in reader.messages()
            if connection.topic == "/joint_states"
        ]
    return np.array([message.header.stamp.sec * 10**9 + message.header.stamp.nanosec for message in messages])


@pytest.fixture
def start_recorder(start: Start, tmp_path: Path) -> Start:
    def start_one(*parameters: str) -> Any:
        given = [f"folder:={tmp_path / 'trials'}", *parameters]
        return start("recorder", "--ros-args", *(word for parameter in given for word in ("-p", parameter)))

    return start_one


def test_a_trial_from_the_rig_to_the_bag(
    listener: Any, start_recorder: Start, start_driver: Start, start_emulator: Start, tmp_path: Path
) -> None:
    recorder = start_recorder("shortest:=1.0")
    start_driver()
    listener.wait_for(lambda: listener.states == ["idle"])
    success, message = listener.call("/recorder/start")
    assert not success
    assert "no joint states" in message
    start_emulator("--delay", "0.01", rig=TRIAL)
    assert listener.call("/recorder/arm") == (True, "armed")
    listener.wait_for(lambda: listener.bags)
    (bag,) = listener.bags
    assert listener.states == ["idle", "armed", "recording", "idle"]

    recorded = stamps(bag)
    assert np.diff(recorded) == pytest.approx(5e6, rel=0.005)
    assert set(recorded) <= {
        state.header.stamp.sec * 10**9 + state.header.stamp.nanosec for state in listener.joint_states
    }
    content = yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    topics = {entry["topic_metadata"]["name"] for entry in content["topics_with_message_count"]}
    assert topics == {"/joint_states", "/diagnostics"}
    facts = content["custom_data"]
    assert facts["ended"] == "the pendulum came to rest"
    assert (facts["cart_at_rest"], facts["samples_lost"]) == ("true", "0")
    assert "emulator" in facts["rig"]
    assert facts["warnings"] == "the zero is uncertain: none was ever taken"

    success, message = listener.call("/recorder/start")
    assert success
    heard = len(listener.joint_states)
    listener.wait_for(lambda: len(listener.joint_states) > heard + 200)
    assert recorder.end(signal.SIGTERM) == 0
    assert len(stamps(Path(message))) > 100


def test_killed_it_loses_nothing_older_than_a_second_and_the_next_start_completes_the_bag(
    listener: Any, start_recorder: Start, start_driver: Start, start_emulator: Start, tmp_path: Path
) -> None:
    start_driver()
    start_emulator()
    listener.wait_for(lambda: len(listener.joint_states) > 300)
    killed: list[tuple[Path, int]] = []
    for delay in (1.3, 2.4):
        recorder = start_recorder()
        while not (listener.call("/recorder/start")[0] or "started" in recorder.said):
            time.sleep(0.1)
        time.sleep(delay)
        (bag,) = (folder for folder in (tmp_path / "trials").iterdir() if folder not in [bag for bag, _ in killed])
        killed.append((bag, time.time_ns()))
        recorder.end(signal.SIGKILL)
        assert not (bag / "metadata.yaml").exists()
    last = start_recorder()
    listener.wait_for(lambda: "completed" in last.said)
    sent = {state.header.stamp.sec * 10**9 + state.header.stamp.nanosec for state in listener.joint_states}
    for bag_folder, when in killed:
        recorded = stamps(bag_folder)
        assert recorded[-1] > when - 1_000_000_000
        expected = np.array(sorted(stamp for stamp in sent if recorded[0] <= stamp <= recorded[-1]))
        assert np.array_equal(recorded, expected)


def test_a_folder_that_cannot_be_is_one_line_and_exit_code_2(start: Start, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    recorder = start("recorder", "--ros-args", "-p", f"folder:={tmp_path / 'file'}")
    assert recorder.exit_code() == 2
    assert recorder.said.count("\n") == 1
    assert "nothing can be recorded" in recorder.said

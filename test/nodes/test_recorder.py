# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Emulator, driver and recorder together."""

import json
import math
import signal
import time
from pathlib import Path

import numpy as np
import pytest
import yaml
from rclpy.duration import Duration
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rosbags.highlevel import AnyReader
from sensor_msgs.msg import JointState

from cdp_ident.bag.joint_state import typestore
from cdp_ident.model.weights import Weight
from cdp_ident.nodes.recorder import main
from cdp_ident.trial.load import load_trial
from cdp_ident.trial.options import TrialOptions

pytestmark = pytest.mark.waits

TRIAL = """
rate: 100
parameters: {c1: 0.1, c2: 0.05}
script: [wait: 3, hold: {theta1: 1.8, theta2: 1.8, within: 0.6}, wait: 0.6, let_go, wait: 8]
repeat: 100
"""


JOINTS = {"rig1": ("upper", "lower"), "rig2": ("inner_joint", "outer_joint")}


def stamps(bag):
    with AnyReader([bag], default_typestore=typestore()) as reader:
        messages = [
            reader.deserialize(raw, connection.msgtype)
            for connection, _, raw in reader.messages()
            if connection.topic == "/joint_states"
        ]
    return np.array([message.header.stamp.sec * 10**9 + message.header.stamp.nanosec for message in messages])


def information(bag):
    """Return what a bag's metadata say of each topic, and of the trial."""
    content = yaml.safe_load((Path(bag) / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
    return {entry["topic_metadata"]["name"]: entry for entry in content["topics_with_message_count"]}, content[
        "custom_data"
    ]


@pytest.fixture
def start_recorder(start, tmp_path):
    def start_one(*parameters):
        given = [f"folder:={tmp_path / 'trials'}", *parameters]
        return start("recorder", "--ros-args", *(word for parameter in given for word in ("-p", parameter)))

    return start_one


def test_a_trial_with_weights_from_the_rig_to_the_bag(listener, start_recorder, start_driver, start_emulator, tmp_path):
    recorder = start_recorder("shortest:=1.0", "added.inner:=[0.08, 0.25]")
    assert listener.set_parameter("/recorder", "added.outer", [0.05, 0.3])[0]
    assert listener.set_parameter("/recorder", "added_std.outer", [1e-4, 5e-4])[0]
    start_driver()
    listener.wait_for(lambda: listener.states == ["idle"])
    success, message = listener.call("/recorder/start")
    assert not success
    assert "no joint states" in message
    heavy = TRIAL.replace("c1: 0.1, c2: 0.05", "c1: 0.2, c2: 0.1")  # it comes to rest soon, though with weights
    start_emulator("--delay", "0.01", rig=f"added: {{inner: [0.08, 0.25], outer: [0.05, 0.3]}}\n{heavy}")
    assert listener.call("/recorder/arm") == (True, "armed")
    listener.wait_for(lambda: listener.bags)
    (bag,) = map(Path, listener.bags)
    assert listener.states == ["idle", "armed", "recording", "idle"]

    recorded = stamps(bag)
    assert np.diff(recorded) == pytest.approx(1e7, rel=0.005)
    assert set(recorded) <= {
        state.header.stamp.sec * 10**9 + state.header.stamp.nanosec for state in listener.joint_states
    }
    topics, facts = information(bag)
    assert topics.keys() == {"/joint_states", "/time_reference", "/diagnostics"}
    assert facts["ended"] == "the pendulum came to rest"
    assert (facts["cart_at_rest"], facts["samples_lost"]) == ("true", "0")
    assert "emulator" in facts["rig"]
    assert facts["warnings"] == "the zero is uncertain: none was ever taken"
    assert load_trial(bag).weights == (
        Weight("inner", 0.08, 0.25, 0.0, 8e-4, 1e-3),
        Weight("outer", 0.05, 0.3, 0.0, 1e-4, 5e-4),
    )

    success, message = listener.call("/recorder/start")
    assert success
    heard = len(listener.joint_states)
    listener.wait_for(lambda: len(listener.joint_states) > heard + 150)
    assert recorder.end(signal.SIGTERM) == 0
    assert len(stamps(Path(message))) > 100


def test_an_impossible_weight_is_refused_and_none_is_the_default(listener, start_recorder):
    start_recorder()
    assert listener.get_parameter("/recorder", "added.outer") == [0.0, 0.0]
    for value in ([-0.05, 0.3], [0.05], [math.nan, 0.3]):
        accepted, reason = listener.set_parameter("/recorder", "added.outer", value)
        assert not accepted
        assert "recorder.added.outer is" in reason


def test_a_recorder_with_an_impossible_weight_does_not_start(refused, tmp_path):
    said = refused(main, "--ros-args", "-p", f"folder:={tmp_path / 'trials'}", "-p", "added.outer:=[0.05]")
    assert "recorder.added.outer is [0.05]; expected [mass in kg, place in m]" in said


def test_two_rigs_side_by_side_are_recorded_each_with_its_own_state(listener, start, start_emulator, tmp_path):
    (tmp_path / "rigs.yaml").write_text(
        f"/**/driver: {{ros__parameters: {{zero_file: {tmp_path / 'none.yaml'}}}}}\n"
        "/**/recorder: {ros__parameters: {rearm: true, shortest: 1.0}}\n"
        "/**: {ros__parameters: {other_nodes_key: 3}}\n"
        "/rig1/driver: {ros__parameters: {inner_joint: upper, outer_joint: lower}}\n"
        "/rig1/recorder: {ros__parameters: {inner_joint: upper, outer_joint: lower}}\n"
    )
    states, bags = ({rig: listener.words(f"/{rig}/recorder/{topic}") for rig in JOINTS} for topic in ("state", "bag"))
    for rig in JOINTS:
        common = ("-r", f"__ns:=/{rig}", "--params-file", str(tmp_path / "rigs.yaml"))
        start("driver", "--ros-args", *common, "-p", f"port:={tmp_path / rig}")
        start("recorder", "--ros-args", *common, "-p", f"folder:={tmp_path / 'trials' / rig}")
    listener.wait_for(lambda: all("armed" in heard for heard in states.values()))
    for rig in states:
        start_emulator(rig=TRIAL.replace("rate: 100", "rate: 50"), link=rig)
    listener.wait_for(lambda: all(bags.values()))
    for rig, (bag, *_) in bags.items():
        topics, facts = information(bag)
        assert topics.keys() == {f"/{rig}/joint_states", f"/{rig}/time_reference", "/diagnostics"}
        assert (facts["rig_name"], json.loads(facts["rig"])["port"]) == (f"/{rig}/driver", str(tmp_path / rig))
        trial = load_trial(Path(bag), TrialOptions(inner_joint=JOINTS[rig][0], outer_joint=JOINTS[rig][1]))
        assert trial.clock is not None
        # On a busy machine, batches arrive late and the rate is known less well.
        assert abs(trial.clock.fast) < 8.0 * trial.clock.std < 1.0


@pytest.mark.parametrize("end", ["stop", signal.SIGTERM])
def test_a_recorder_that_is_behind_takes_what_waits_before_it_ends(listener, start_recorder, end):
    recorder = start_recorder()
    publisher = listener.node.create_publisher(JointState, "joint_states", 5000)
    message = JointState(name=["inner_joint", "outer_joint"], position=[3.0, 0.0])
    sent = 0

    def publish(count):
        nonlocal sent
        for _ in range(count):
            sent += 1
            message.header.stamp.nanosec = 1000 * sent
            publisher.publish(message)

    def begin():
        publish(1)
        time.sleep(0.1)
        return bool(listener.call("/recorder/start")[0])

    listener.wait_for(begin)
    publish(4000)
    if end == "stop":
        assert listener.call("/recorder/stop")[0]
    else:
        assert publisher.wait_for_all_acked(Duration(seconds=30))
        assert recorder.end(end) == 0
    (bag,) = (Path(line.rpartition("recording ")[2]) for line in recorder.said.splitlines() if "started: " in line)
    assert stamps(bag).tolist()[-4000:] == [1000 * (sent - back) for back in range(3999, -1, -1)]


def test_a_recorder_that_hears_nothing_says_so_and_who_is_there(listener, start_recorder):
    recorder = start_recorder("rearm:=true")
    recorder.wait_until_it_says("armed: no joint states come on /joint_states: no node publishes them")
    publisher = listener.node.create_publisher(JointState, "joint_states", 10)
    message = JointState(name=["inner_joint", "outer_joint"], position=[3.0, 0.0])

    def latest():
        return next((status.message for status in listener.statuses[::-1] if status.name == "/recorder"), "")

    listener.wait_for(lambda: "though /listener publishes them" in latest())
    publisher.publish(message)
    listener.wait_for(lambda: latest() == "armed")
    assert recorder.said.count("no joint states come") == 1


def test_a_best_effort_publisher_is_heard_and_what_it_offers_is_recorded(listener, start_recorder, tmp_path):
    recorder = start_recorder()
    profile = QoSProfile(depth=10, reliability=ReliabilityPolicy.BEST_EFFORT)
    publisher = listener.node.create_publisher(JointState, "joint_states", profile)
    listener.wait_for(lambda: "does not make sure that its messages arrive" in recorder.said)

    def publish():
        message = JointState(name=["inner_joint", "outer_joint"], position=[3.0, 0.0])
        message.header.stamp = listener.node.get_clock().now().to_msg()
        publisher.publish(message)
        return bool(listener.call("/recorder/start")[0])

    listener.wait_for(publish)
    publish()
    time.sleep(0.5)
    _, bag = listener.call("/recorder/stop")
    topic = information(bag)[0]["/joint_states"]
    (offered,) = topic["topic_metadata"]["offered_qos_profiles"]
    assert offered["reliability"] == "best_effort"
    assert topic["message_count"] > 0
    assert "[WARN]" in recorder.said


def test_qos_overrides_are_honoured_or_refused(listener, start_driver):
    start_driver("qos_overrides./joint_states.publisher.reliability:=best_effort")
    listener.wait_for(lambda: listener.node.get_publishers_info_by_topic("/joint_states"))
    (info,) = listener.node.get_publishers_info_by_topic("/joint_states")
    assert info.qos_profile.reliability == ReliabilityPolicy.BEST_EFFORT
    wrong = start_driver("qos_overrides./joint_states.publisher.reliability:=sometimes")
    assert wrong.popen.wait(timeout=90) == 2
    assert wrong.said.count("\n") == 1
    assert "sometimes" in wrong.said


def test_the_next_start_completes_the_bag_of_a_killed_one(
    listener, start_recorder, start_driver, start_emulator, tmp_path
):
    """How little is lost is in test_kill.py."""
    start_driver()
    start_emulator(rig="{rate: 100, script: [wait: 1000]}")
    recorder = start_recorder()
    listener.wait_for(lambda: listener.call("/recorder/start")[0] or "started" in recorder.said)
    ((file,),) = (list(bag.glob("*.mcap")) for bag in (tmp_path / "trials").iterdir())
    for _ in range(2):
        before = file.stat().st_size
        listener.wait_for(lambda before=before: file.stat().st_size > before)
    recorder.end(signal.SIGKILL)
    assert not (file.parent / "metadata.yaml").exists()
    last = start_recorder()
    listener.wait_for(lambda: "completed" in last.said)
    assert len(stamps(file.parent)) > 10

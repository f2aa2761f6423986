# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The simulator as a process, over DDS: replays, a free motion, and a shadow of the emulated rig."""

import signal
import time
from pathlib import Path

import numpy as np
import pytest
import rclpy.qos
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from cdp_ident.configuration.fitted_model import fitted_model, read_fitted_model
from cdp_ident.configuration.parameter_file import parameter_file
from cdp_ident.diagnosis.evaluation import start_of
from cdp_ident.fit.windows import DEFAULT_WINDOW
from cdp_ident.model.motions import simulate
from cdp_ident.model.parameters import NOMINAL
from cdp_ident.model.time_grid import DEFAULT_STEP
from cdp_ident.nodes.simulator import main
from cdp_ident.replay.scene import MotionStream
from cdp_ident.trial.load import load_trial
from scenarios.clean_bags import write_clean_bags

pytestmark = pytest.mark.waits


BAG = Path(__file__).parents[2] / "bags/swing_folded"
SLOWLY = ("-p", "frequency:=100.0")
"""What is shown when matters in most tests, not how smoothly, and each message takes its time."""
PERIOD_NS = 10_000_000
FITTED = NOMINAL | {
    "std.m1": 0.01,
    "determined.m1": False,
    "groups.A23_over_A22": 0.1532,
    "groups.A33_over_A22": 0.1003,
    "groups.a1_over_A22": 2.641,
    "groups.c1_over_A22": 0.09,
    "groups.c2_over_A22": 0.02,
    "effects.coulomb_friction.outer.torque": 0.001,
    "effects.time_offset.outer.delay": 0.004,
}


class Viewer:
    """What a person's tools would see of the simulator."""

    def __init__(self, listener):
        self.listener = listener
        self.simulated = []
        self.measured = []
        self.errors = []
        self.clock = []
        self.states = listener.words("/simulator/state")
        node, depth = listener.node, rclpy.qos.QoSProfile(depth=20000)
        for topic, into in (
            ("simulated/joint_states", self.simulated),
            ("measured/joint_states", self.measured),
            ("simulated/error", self.errors),
        ):
            node.create_subscription(JointState, topic, into.append, depth)
        node.create_subscription(Clock, "/clock", lambda message: self.clock.append(nanoseconds(message.clock)), depth)

    def wait_for_state(self, words):
        self.listener.wait_for(lambda: self.states and words in self.states[-1])

    def new_frames(self, count=5):
        """Wait for so many frames more, and return them."""
        before = len(self.simulated)
        self.listener.wait_for(lambda: len(self.simulated) >= before + count)
        return self.simulated[before:]


@pytest.fixture
def viewer(listener):
    return Viewer(listener)


@pytest.fixture(scope="module")
def trial():
    return load_trial(BAG)


@pytest.fixture
def fitted(tmp_path):
    path = tmp_path / "fitted.yaml"
    path.write_text(parameter_file(FITTED))
    return path


def nanoseconds(stamp):
    return int(stamp.sec) * 10**9 + int(stamp.nanosec)


def stamps(messages):
    return np.array([nanoseconds(message.header.stamp) for message in messages])


def positions(messages):
    return np.array([message.position for message in messages])


def library_s_own(model, trial, times):
    """Return inner and outer joint (n, 2) [rad] of the simulation that reports judge by, at any times."""
    index = model.trial(trial.name)
    start = start_of(model.motion, model.values, trial, index, DEFAULT_WINDOW)
    theta = MotionStream(model, start, index).readings(times)
    return np.diff(theta, axis=1, prepend=0.0)


def measured_at(trial, times):
    theta = np.column_stack([np.interp(times, trial.time, column) for column in trial.theta.T])
    return np.diff(theta, axis=1, prepend=0.0)


# Replay


def test_a_replay_beside_a_running_identify_is_the_library_s_own_simulation(start, viewer, tmp_path):
    write_clean_bags(tmp_path / "bags", swing=6.0)
    bag, out = tmp_path / "bags/swing_wide", tmp_path / "out"
    start("simulator", "--bag", str(bag), "--ros-args", "-p", "source:=/identify", "-p", "rate:=4.0", *SLOWLY)
    viewer.wait_for_state("waiting for the parameters of /identify")
    assert viewer.simulated == []  # nothing is shown before there are parameters
    (tmp_path / "quick.yaml").write_text(
        "identify: {ros__parameters: {search.generations: 3, named_effects_only: true}}"
    )
    start("identify", "--bag", str(bag), "--out", str(out), "--config", str(tmp_path / "quick.yaml"))
    viewer.wait_for_state("playing")
    trial, model = load_trial(bag), read_fitted_model(out / "fitted.yaml", "simulator")
    viewer.new_frames(200)
    count = min(len(viewer.simulated), len(viewer.measured), len(viewer.errors))
    simulated, measured, errors = (m[:count] for m in (viewer.simulated, viewer.measured, viewer.errors))

    assert simulated[0].name == measured[0].name == ["cart_joint", "inner_joint", "outer_joint"]
    assert errors[0].name == ["inner_joint", "outer_joint"]
    for messages in (simulated, measured, errors):
        assert np.all(np.diff(stamps(messages)) == PERIOD_NS)
        assert np.array_equal(stamps(messages), stamps(simulated))
    # At four times the speed the trial takes fewer frames than were waited for at least; then it begins anew.
    whole = int(trial.duration * 100 / 4) + 1
    times = np.arange(count) % whole * 4 * 0.01
    expected = library_s_own(model, trial, times[:whole])[np.arange(count) % whole]
    assert np.abs(positions(simulated)[:, 1:] - expected).max() < 1e-9
    assert np.abs(positions(measured)[:, 1:] - measured_at(trial, times)).max() < 1e-3
    assert np.array_equal(positions(errors), positions(simulated)[:, 1:] - positions(measured)[:, 1:])
    assert np.abs(positions(errors)[:50]).max() < 0.01


def test_it_follows_another_node_s_parameters_and_takes_none_from_elsewhere(start, viewer, trial, fitted):
    listener = viewer.listener
    slow = ("-p", "frequency:=50.0")  # what is shown when matters here, not how smoothly
    follow = ("-p", "source:=/elsewhere/simulator", "-p", "rate:=20.0")
    start("simulator", "--bag", str(BAG), "--ros-args", *follow, *slow)
    viewer.wait_for_state("waiting for the parameters of /elsewhere/simulator")

    def shows(model):
        (beginning,) = library_s_own(model, trial, np.zeros(1))
        return any(
            np.allclose(frame, beginning, rtol=0, atol=1e-9) for frame in positions(viewer.new_frames(33))[:, 1:]
        )

    other = start("simulator", "--fitted", str(fitted), "--ros-args", "-r", "__ns:=/elsewhere", *slow)
    viewer.wait_for_state("playing")
    assert shows(fitted_model(FITTED, "test"))
    assert listener.set_parameter("/simulator", "m1", 0.2)[0] is False
    assert listener.set_parameter("/elsewhere/simulator", "groups.c1_over_A22", 0.2) == (True, "")
    listener.wait_for(lambda: shows(fitted_model(FITTED | {"groups.c1_over_A22": 0.2}, "test")))
    other.end(signal.SIGKILL)
    # Without effects, and without warning.
    start("simulator", "--ros-args", "-r", "__ns:=/elsewhere", "-p", "m1:=0.15", *slow)
    listener.wait_for(lambda: listener.get_parameter("/simulator", "m1") == 0.15)
    listener.wait_for(lambda: shows(fitted_model(NOMINAL | {"m1": 0.15}, "test")))
    assert "effects.coulomb_friction.outer.torque" not in listener.parameter_names("/simulator")


def test_once_with_a_clock_is_every_frame_in_the_motion_s_own_time(start, viewer, trial, fitted):
    rate = 5.0
    parameters = ["-p", "clock:=true", "-p", f"rate:={rate}", "-p", "frequency:=100.0"]
    simulator = start("simulator", "--bag", str(BAG), "--fitted", str(fitted), "--once", "--ros-args", *parameters)
    assert simulator.exit_code() == 0
    assert "finished" in simulator.said
    times = np.arange(int(trial.duration * 100 / rate) + 1) * rate / 100
    viewer.listener.wait_for(lambda: len(viewer.simulated) == len(times))
    expected = library_s_own(read_fitted_model(fitted, "simulator"), trial, times)
    assert np.abs(positions(viewer.simulated)[:, 1:] - expected).max() < 1e-9
    assert np.all(np.diff(stamps(viewer.simulated)) == 50_000_000)
    assert viewer.clock == stamps(viewer.simulated).tolist()


def test_without_a_clock_it_says_that_it_waits_for_one(start, listener):
    simulator = start("simulator", "--ros-args", "-p", "use_sim_time:=true")
    listener.wait_for(lambda: "waiting for a clock: use_sim_time is true" in simulator.said)


def test_it_pauses_resumes_begins_anew_loops_and_changes_its_rate(start, viewer, trial, fitted):
    listener = viewer.listener
    (beginning,) = library_s_own(read_fitted_model(fitted, "simulator"), trial, np.zeros(1))

    def beginnings(frames):
        return sum(np.allclose(frame, beginning, rtol=0, atol=1e-9) for frame in positions(frames)[:, 1:])

    start("simulator", "--bag", str(BAG), "--ros-args", "--params-file", str(fitted), "-p", "rate:=0.5", *SLOWLY)
    slow = stamps(viewer.new_frames(20))
    assert np.all(np.diff(slow) == PERIOD_NS)
    assert listener.call("/simulator/pause") == (True, "paused")
    viewer.wait_for_state("paused")
    time.sleep(0.3)  # what was on its way has come
    shown = len(viewer.simulated)
    time.sleep(0.3)
    assert len(viewer.simulated) == shown
    assert listener.call("/simulator/resume") == (True, "playing")
    viewer.new_frames()
    before, after = positions(viewer.simulated)[shown - 1 : shown + 1]
    assert np.abs(after - before).max() < 0.15  # goes on from where it was: a frame on, and not a third of a second

    begun = len(viewer.simulated)
    assert listener.call("/simulator/reset") == (True, "playing")
    listener.wait_for(lambda: beginnings(viewer.simulated[begun:]))  # behind what was on its way before the reset
    viewer.new_frames()
    assert beginnings(viewer.simulated[begun:]) == 1

    fast = len(viewer.simulated)
    assert listener.set_parameter("/simulator", "rate", 50.0) == (True, "")
    viewer.new_frames(75)
    assert beginnings(viewer.simulated[fast:]) >= 2
    assert np.all(np.diff(stamps(viewer.simulated[fast:])) == PERIOD_NS)  # from end to beginning too
    assert listener.set_parameter("/simulator", "loop", False) == (True, "")
    viewer.wait_for_state("finished")
    assert listener.call("/simulator/reset") == (True, "playing")
    viewer.wait_for_state("finished")
    assert listener.set_parameter("/simulator", "rate", 0.0)[0] is False


# Free


def test_a_free_motion_goes_on_with_new_parameters_and_begins_anew_from_a_new_start(start, viewer):
    listener = viewer.listener
    given = {"start.inner": 1.0, "start.outer_speed": 0.5, "effects.air_drag.inner.coefficient": 0.001}
    given["velocities"] = True
    start("simulator", "--ros-args", *(word for name, value in given.items() for word in ("-p", f"{name}:={value}")))
    viewer.new_frames()  # by then we hear all that comes
    assert listener.call("/simulator/reset") == (True, "playing")
    viewer.new_frames(150)
    model = fitted_model(NOMINAL | {"effects.air_drag.inner.coefficient": 0.001}, "test")
    torques = model.motion.acting(model.values, model.trial())
    states = simulate(
        model.coefficients, np.array([1.0, 1.0, 0.0, 0.5]), np.arange(100) * 0.005, None, DEFAULT_STEP, torques
    )
    expected = np.diff(states[:, :2], axis=1, prepend=0.0)
    shown = positions(viewer.simulated)[:, 1:]
    begin = max(np.flatnonzero(np.all(shown == expected[0], axis=1)))
    assert np.abs(shown[begin : begin + 100] - expected).max() < 1e-9
    assert viewer.measured == viewer.errors == []
    velocities = np.array([frame.velocity for frame in viewer.simulated[begin + 10 : begin + 100]])[:, 1:]
    speeds = np.diff(states[10:, 2:4], axis=1, prepend=0.0)
    assert np.abs(velocities - speeds).max() < 0.01 * np.abs(speeds).max()

    assert listener.set_parameter("/simulator", "groups.c1_over_A22", 3.0) == (True, "")
    assert listener.get_parameter("/simulator", "c1") == NOMINAL["c1"]
    assert listener.set_parameter("/simulator", "m1", 0.2) == (True, "")  # and its groups with it
    assert listener.get_parameter("/simulator", "groups.c1_over_A22") != 3.0
    changed, reason = listener.set_parameter("/simulator", "m1", -0.2)
    assert (changed, reason) == (False, "the parameters: m1 is -0.2; expected a number, 0 to 1e+12")
    assert listener.get_parameter("/simulator", "m1") == 0.2

    joined = positions(viewer.simulated[begin:])[:, 1:]
    assert np.abs(np.diff(joined, axis=0)).max() < 0.1  # no jump so far: it went on from where it was
    shown_before = len(viewer.simulated)
    assert listener.set_parameter("/simulator", "start.inner", 3.0) == (True, "")
    listener.wait_for(lambda: any(frame.position[1] == 3.0 for frame in viewer.simulated[shown_before:]))


# Shadow

RIG = """
rate: 100
parameters: {c1: 0.05, c2: 0.01}
script: [wait: 3, hold: {theta1: 1.8, theta2: 1.8, within: 0.6}, wait: 0.8, let_go, wait: 4,
         hold: {theta1: 2.0, theta2: 2.0, within: 0.6}, wait: 20]
"""


def test_a_shadow_runs_beside_the_rig_from_the_release_until_it_is_caught(start, start_emulator, start_driver, viewer):
    listener = viewer.listener
    start("simulator", "--ros-args", "-p", "mode:=shadow", "-p", "c1:=0.05", "-p", "c2:=0.01")
    viewer.wait_for_state("waits for a release")
    start_driver()
    start_emulator(rig=RIG)
    listener.wait_for(lambda: "/driver/zero_hanging" in dict(listener.node.get_service_names_and_types()))
    listener.wait_for(lambda: listener.call("/driver/zero_hanging")[0])
    viewer.wait_for_state("runs beside the rig: the pendulum was let go")
    viewer.wait_for_state("waits for a release: the pendulum was caught")
    listener.wait_for(lambda: min(len(viewer.simulated), len(viewer.errors)) > 250)
    count = min(len(viewer.simulated), len(viewer.errors))  # more may be on the way
    simulated, errors = viewer.simulated[:count], viewer.errors[:count]
    beside = stamps(simulated)
    assert np.array_equal(beside, stamps(errors))
    listener.wait_for(lambda: set(beside.tolist()) <= set(stamps(listener.joint_states).tolist()))
    rig = {nanoseconds(message.header.stamp): message.position for message in listener.joint_states}
    # The rig's own spacing, and no sample is left out.
    assert np.abs(np.diff(beside) - PERIOD_NS).max() < 0.002 * PERIOD_NS
    measured = np.array([rig[stamp] for stamp in beside.tolist()])
    difference = positions(simulated)[:, 1:] - measured[:, 1:]
    assert np.abs(positions(errors) - difference).max() < 1e-12
    assert np.abs(difference[:300]).max() < 0.01


# What is wrong is told


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--bag", "nowhere"], "there is no bag nowhere"),
        (["--ros-args", "-p", "mm1:=1.0"], "did you mean 'm1'?"),
        (["--bag", str(BAG), "--once", "--ros-args", "-p", "c2:=1000.0"], "cannot be computed"),
        (["--ros-args", "-p", "effects.coulomb_friction.outer.torque:=-1.0"], "torque is -1.0"),
        (["--fitted", "fitted.yaml", "--ros-args", "-p", "source:=/x"], "source and --fitted are both given"),
        (["--bag", str(BAG), "--ros-args", "-p", "trial.zeros:=hanging"], "did you mean 'trial.zero'?"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(arguments, words, refused):
    assert words in refused(main, *arguments)

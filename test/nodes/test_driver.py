# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The driver against the emulated rig: real processes, a real pseudo-terminal, real DDS."""

import math
import signal
import time

import numpy as np
import pytest
from std_msgs.msg import Float64

from cdp_ident.configuration.parameter_file import parameter_file
from cdp_ident.model.parameters import NOMINAL
from cdp_ident.nodes.driver import main
from cdp_ident.nodes.emulator import main as emulate

pytestmark = pytest.mark.waits

OK, WARN, ERROR, STALE = range(4)
HANGING = "{rate: 100, script: [wait: 1000]}"
"""What is asked of most nodes does not depend on the rate, and each message takes its time."""
PERIOD_NS = 1e7
SWING = "{rate: 200, script: [hold: {theta1: 2.0, theta2: 2.0, within: 0.5}, wait: 0.5, let_go, wait: 1000]}"


def stamps(listener):
    return np.array([state.header.stamp.sec * 10**9 + state.header.stamp.nanosec for state in listener.joint_states])


def uneven(listener, period_ns):
    """Return between how many samples the stamps keep not the device's spacing, but for restarts of the clock's fit.

    On a busy machine the emulator itself may be so late that the fit has to start anew.
    """
    off = np.abs(np.diff(stamps(listener)) / period_ns - 1.0) > 0.005
    return int(np.sum(off)) - listener.count("clock fits begun anew")


def test_the_drivers_life_with_a_good_rig(listener, start_driver, start_emulator, tmp_path):
    driver = start_driver()
    listener.wait_for(lambda: listener.level() == ERROR)
    assert "no port" in listener.diagnostics[-1].message

    start_emulator("--delay", "0.015", rig=HANGING)
    listener.wait_for(lambda: len(listener.joint_states) > 300)
    state = listener.joint_states[0]
    assert list(state.name) == ["cart_joint", "inner_joint", "outer_joint"]
    assert list(state.position) == pytest.approx([0.0, math.pi, 0.0])
    assert (len(state.velocity), len(state.effort)) == (0, 0)
    assert uneven(listener, PERIOD_NS) <= 0
    assert abs(stamps(listener)[-1] * 1e-9 - time.time()) < 60.0
    listener.wait_for(lambda: listener.level() == WARN)
    assert "zero_hanging" in listener.diagnostics[-1].message

    success, message = listener.call("/driver/zero_hanging")
    assert success, message
    listener.wait_for(lambda: listener.level() == OK)
    assert listener.value("zero") == "taken"
    assert listener.value("counts per turn") == "8000, 8000"
    assert listener.count("lost") == 0
    # A busy computer brings samples late and then many at once.
    listener.wait_for(lambda: float(listener.value("rate [Hz]")) == pytest.approx(100, rel=0.2))
    assert "closed" not in driver.said
    assert "no greeting" not in driver.said

    changed, reason = listener.set_parameter("/driver", "baud", 9600)
    assert not changed
    assert "read-only" in reason

    assert driver.end(signal.SIGTERM) == 0
    assert "Traceback" not in driver.said
    listener.diagnostics.clear()
    start_driver()
    listener.wait_for(lambda: listener.level() == OK)  # with the zero that was kept


def test_damage_on_the_line_is_counted_and_never_published(listener, start_driver, start_emulator):
    start_driver("codec:=text")
    start_emulator("--codec", "text", "--flips", "0.0005", "--losses", "0.0005", "--bursts", "1", rig=SWING)
    listener.wait_for(lambda: listener.count("lost") > 20 and len(listener.joint_states) > 800)
    assert listener.count("bad checksum") > 0
    assert listener.count("malformed") > 0
    assert listener.count("device resets") == 0
    positions = np.array([state.position for state in listener.joint_states])
    assert np.abs(np.diff(positions, axis=0)).max() < 0.5
    steps = np.diff(stamps(listener)) / 5e6
    assert np.round(steps) == pytest.approx(steps, abs=0.05)
    assert any(status.level[0] == WARN and "lost" in status.message for status in listener.diagnostics)


def test_resets_roll_over_and_replugging_under_another_name_are_lived_through_and_no_zero_taken_while_it_swings(
    listener, start_driver, start_emulator, tmp_path
):
    start_driver(port="tty*")
    start_emulator(
        *("--first-count", "2147483600", "--first-time", "4294000000", "--reset-at", "2.5", "--unplug-at", "4.5"),
        *("--unplugged-for", "1.2", "--replug-as", str(tmp_path / "ttyB")),
        rig=SWING.replace("theta1: 2.0", "theta1: 3.6").replace("rate: 200", "rate: 100"),
    )
    listener.wait_for(lambda: listener.count("device resets") == 1)
    listener.wait_for(
        lambda: listener.value("times unplugged") == "1" and listener.value("port") == str(tmp_path / "ttyB")
    )
    seen = len(listener.joint_states)
    listener.wait_for(lambda: len(listener.joint_states) > seen + 150)
    assert listener.count("lost") > 100  # while it was unplugged
    positions = np.array([state.position for state in listener.joint_states])
    assert np.sum(np.abs(np.diff(positions, axis=0)).max(axis=1) > 0.3) <= 2  # the reset; being unplugged
    assert np.all(np.diff(stamps(listener)) > 0)
    success, message = listener.call("/driver/zero_hanging")
    assert not success
    assert "moved by" in message


def test_a_silent_rig_is_stale(listener, start_driver, start_emulator):
    start_driver()
    start_emulator("--stall-every", "4", "--stall-for", "3", rig=HANGING)
    listener.wait_for(lambda: any(status.level[0] == STALE for status in listener.diagnostics))
    listener.wait_for(lambda: len(listener.joint_states) > 600)
    assert listener.count("lost") == 0
    assert listener.count("clock fits begun anew") == 0


def test_a_wrong_codec_is_told_in_the_log_too(start_driver, start_emulator):
    start_emulator("--codec", "text").wait_until_it_says("the rig is at")
    start_driver().wait_until_it_says("are codec and baud right?")


@pytest.mark.campaign
def test_a_kilohertz_comes_through_without_loss(listener, start_driver, start_emulator):
    start_driver()
    start_emulator("--delay", "0.005", rig="{rate: 1000, script: [wait: 1000]}")
    listener.wait_for(lambda: len(listener.joint_states) > 5000)
    assert listener.count("lost") == 0
    assert uneven(listener, 1e6) <= 0


class Cart:
    """The cart of a rig, as who commands it sees it."""

    RIG = "{rate: 100, drive: {speed: 0.2, rail: 2.0}, script: [wait: 1000]}"

    def __init__(self, listener):
        self.listener, self.commands = listener, listener.node.create_publisher(Float64, "cart_command", 10)

    @property
    def positions(self):
        return [state.position[0] for state in self.listener.joint_states[-50:]]

    def drive(self, acceleration):
        """Send a command; return whether it is off the middle."""
        self.commands.publish(Float64(data=acceleration))
        return bool(self.positions) and abs(self.positions[-1]) > 0.03

    def wait_until_it_rests(self):
        self.listener.joint_states.clear()
        self.listener.wait_for(lambda: len(self.positions) == 50 and np.ptp(self.positions) == 0.0)
        assert abs(self.positions[-1]) < 1.9, "it was stopped by the rail's end"


def test_a_commanded_cart_stops_when_the_commands_stop_or_the_driver_is_killed(listener, start_driver, start_emulator):
    start_emulator(rig=Cart.RIG)
    driver, cart = start_driver("cart_sign:=-1"), Cart(listener)
    listener.wait_for(lambda: cart.drive(0.5))
    assert cart.positions[-1] > 0.0
    cart.wait_until_it_rests()
    listener.wait_for(lambda: not cart.drive(-0.5))
    driver.end(signal.SIGKILL)
    start_driver("cart_sign:=-1")
    cart.wait_until_it_rests()
    rest = cart.positions[-1]
    for acceleration in (math.nan, math.inf):
        for _ in range(20):
            cart.drive(acceleration)
            time.sleep(0.01)
    assert cart.positions[-1] == rest


def test_a_commanded_cart_stops_when_the_line_is_lost(listener, start_driver, start_emulator):
    start_driver()
    cart = Cart(listener)
    listener.wait_for(lambda: listener.level() == ERROR)
    start_emulator("--unplug-at", "3", rig=Cart.RIG)
    listener.wait_for(lambda: cart.drive(0.1) and listener.value("times unplugged") == "1")
    cart.wait_until_it_rests()


def test_faster_than_real_time_stamps_are_the_rigs_time_and_velocities_come_on_request(
    listener, start_driver, start_emulator, tmp_path
):
    fitted = tmp_path / "fitted.yaml"
    fitted.write_text(parameter_file(NOMINAL, []), encoding="utf-8")
    start_driver("use_sim_time:=true", f"velocity_model:={fitted}")
    start_emulator("--speed", "4", rig=HANGING)
    listener.wait_for(lambda: len(listener.joint_states) > 500)
    assert uneven(listener, PERIOD_NS) <= 0
    assert listener.count("lost") == 0
    assert list(listener.joint_states[-1].velocity) == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)


@pytest.mark.parametrize(
    ("parameter", "words"),
    [
        ("inner_sign:=0", "inner_sign"),
        ("velocity_model:=missing.yaml", "missing.yaml"),
        ("inner_joint:=''", "inner_joint"),
    ],
)
def test_a_wrong_parameter_is_one_line_and_exit_code_2(refused, tmp_path, parameter, words):
    assert words in refused(main, "--ros-args", "-p", f"zero_file:={tmp_path / 'zero.yaml'}", "-p", parameter)


def test_a_damaged_zero_file_is_one_line_and_exit_code_2(refused, tmp_path):
    (tmp_path / "zero.yaml").write_text("nonsense")
    given = ("-p", f"port:={tmp_path / 'tty'}", "-p", f"zero_file:={tmp_path / 'zero.yaml'}")
    assert "zero.yaml" in refused(main, "--ros-args", *given)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--rig", "nowhere.yaml"], "nowhere.yaml cannot be read"),
        (["--flips", "2"], "not a number from 0 to 1"),
        (["--speed", "0"], "not a number from 0.001 to 1000"),
        (["--seed", "-1"], "-1 is not a number from 0 to 4294967295"),
        (["--first-count", "2147483648"], "2147483648 is not a number from -2147483648 to 2147483647"),
        ([], "something else is there"),
    ],
)
def test_wrong_arguments_are_told_with_exit_code_2(tmp_path, arguments, words, refused):
    (tmp_path / "tty").write_text("mine")
    assert words in refused(emulate, "--link", str(tmp_path / "tty"), *arguments)
    assert (tmp_path / "tty").read_text() == "mine"


def test_a_port_that_cannot_come_back_ends_it_in_one_line(start_emulator, tmp_path):
    (tmp_path / "mine").write_text("mine")
    emulator = start_emulator("--unplug-at", "0.1", "--unplugged-for", "0.1", "--replug-as", str(tmp_path / "mine"))
    assert emulator.exit_code() == 2
    assert "something else is there" in emulator.said
    assert "Traceback" not in emulator.said
    assert (tmp_path / "mine").read_text() == "mine"


@pytest.mark.campaign  # it compiles
def test_ctrl_c_while_it_compiles_is_not_lost(start, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    emulator = start("emulator", "--link", str(tmp_path / "rig"), "--ros-args", "--log-level", "debug")
    emulator.wait_until_it_says("emulator")  # the node is made
    assert not (tmp_path / "rig").exists()
    assert emulator.end() == 0
    assert "Traceback" not in emulator.said
    assert not (tmp_path / "rig").is_symlink()

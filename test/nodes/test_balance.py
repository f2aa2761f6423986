# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The example that balances a rig: real processes, a real pseudo-terminal, real DDS, and a rig with hidden friction.

Its time runs slower than the wall's, that a busy machine be quick enough, but in the campaign.
"""

import importlib.util
import itertools
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from cdp_ident.configuration.parameter_file import parameter_file
from reference.pendulum import TABLE_5

pytestmark = pytest.mark.waits

ROOT = Path(__file__).parents[2]
EXAMPLES, BAGS = ROOT / "examples", ROOT / "bags"
EXAMPLE = (str(EXAMPLES / "balance.py"),)
RIG = f"""
parameters: {TABLE_5}
effects: {{coulomb_friction: {{outer: {{torque: 0.002}}}}}}
drive: {{}}
script: [wait: 0.5, hold: {{theta1: %s, theta2: %s, within: 0.5}}, wait_for_command, %s]
"""
SLOWLY = ("--speed", "0.125")
PULLED_AWAY = "let_go, wait: 2, hold: {theta1: 0.8, theta2: 0.8, within: 0.1}"


@pytest.fixture
def start_balance(start, tmp_path):
    """Start the controller that is designed on a fitted model, by default the rig's own but for its friction."""

    def start_one(*options, words="hold the rods upright", fitted=None):
        (tmp_path / "fitted.yaml").write_text(parameter_file(TABLE_5))
        balance = start(str(fitted or tmp_path / "fitted.yaml"), *options, program=EXAMPLE)
        balance.wait_until_it_says(words)
        return balance

    return start_one


def wait_until_the_cart_rests(listener):
    """Wait for 100 samples without motion; return where that is [m]."""
    listener.joint_states.clear()

    def positions():
        return [state.position[0] for state in listener.joint_states[-100:]]

    listener.wait_for(lambda: len(positions()) == 100 and np.ptp(positions()) == 0.0)
    return positions()[-1]


def test_it_stands_stops_when_the_rods_are_pulled_away_and_takes_over_again(
    listener, start_driver, start_emulator, start_balance
):
    start_driver("use_sim_time:=true")
    balance = start_balance()
    again = "wait: 0.5, hold: {theta1: 0.03, theta2: -0.03, within: 0.5}, wait_for_command, let_go, wait: 1000"
    start_emulator(*SLOWLY, rig=RIG % (-0.05, 0.05, f"{PULLED_AWAY}, {again}"))
    balance.wait_until_it_says("the rods fell")
    (stopped,) = [line for line in balance.said.splitlines() if "stopped" in line]
    assert float(stopped.split("stopped after ")[1].split()[0]) > 2.0
    assert abs(wait_until_the_cart_rests(listener)) < 0.5
    listener.wait_for(lambda: balance.said.count("balancing") == 2)
    balance.end(signal.SIGKILL)
    assert abs(wait_until_the_cart_rests(listener)) < 0.5


def test_it_stops_at_the_rail_s_end_where_a_hand_holds_the_rods(listener, start_driver, start_emulator, start_balance):
    start_driver("use_sim_time:=true")
    balance = start_balance("--seconds", "60")
    start_emulator(*SLOWLY, rig=RIG % (-0.03, 0.05, "wait: 1000"))
    assert balance.exit_code() == 3
    assert "the cart is at the rail's end" in balance.said
    assert 0.45 < abs(wait_until_the_cart_rests(listener)) <= 0.5 + 1e-5


def test_a_lost_line_stops_cart_and_controller(listener, start_driver, start_emulator, start_balance):
    start_driver("use_sim_time:=true")
    balance = start_balance("--seconds", "60")
    start_emulator(*SLOWLY, "--unplug-at", "3", "--unplugged-for", "1", rig=RIG % (0.04, 0.04, "let_go, wait: 1000"))
    assert balance.exit_code() == 3
    assert "samples are missing" in balance.said
    assert abs(wait_until_the_cart_rests(listener)) < 0.5


def test_samples_that_the_line_has_kept_do_not_tell_that_the_rods_are_held(listener, start_balance):
    commands, samples = [], listener.node.create_publisher(JointState, "joint_states", 1000)
    listener.node.create_subscription(Float64, "cart_command", commands.append, 10)
    balance = start_balance()
    listener.wait_for(lambda: samples.get_subscription_count() == 2)  # the listener itself, too

    def publish(count, spacing):
        for _ in range(count):
            message = JointState(name=["cart_joint", "inner_joint", "outer_joint"], position=[0.0, 0.0, 0.0])
            message.header.stamp.sec, message.header.stamp.nanosec = divmod(next(stamps), 10**9)
            samples.publish(message)
            time.sleep(spacing)

    stamps = itertools.count(10**9, 5 * 10**6)
    balance.popen.send_signal(signal.SIGSTOP)
    publish(65, spacing=0.0)  # five more than tell that rods are held
    listener.wait_for(lambda: len(listener.joint_states) == 65)
    balance.popen.send_signal(signal.SIGCONT)  # now they come at once, however busy the machine is
    time.sleep(0.3)
    assert (balance.said.count("balancing"), commands) == (0, [])
    publish(70, spacing=0.005)
    listener.wait_for(lambda: "balancing" in balance.said and commands)


@pytest.mark.campaign
@pytest.mark.skipif(importlib.util.find_spec("casadi") is None, reason="CasADi is not installed")
def test_it_swings_hanging_rods_up_as_planned_and_stands(start_driver, start_emulator, start_balance, tmp_path):
    (tmp_path / "known.yaml").write_text(parameter_file(TABLE_5))
    plan = tmp_path / "swing_up.json"
    program = [sys.executable, str(EXAMPLES / "swing_up.py"), str(tmp_path / "known.yaml"), "--out", str(plan)]
    subprocess.run(program, check=True, stdout=subprocess.DEVNULL)
    start_driver("use_sim_time:=true")
    balance = start_balance("--follow", str(plan), "--seconds", "5", words="let the rods hang")
    led = "hold: {theta1: 2.5, theta2: 2.5, within: 1}, hold: {theta1: 3.14159, theta2: 3.14159, within: 2}"
    rig = f"{{parameters: {TABLE_5}, drive: {{}}, script: [{led}, wait_for_command, let_go, wait: 1000]}}"
    start_emulator(*SLOWLY, rig=rig)
    assert balance.exit_code() == 0, balance.said


@pytest.mark.parametrize(
    ("model", "options", "words"),
    [(TABLE_5, ["--follow"], "plan.json is no file of swing_up.py"), ({"m1": 0.1}, [], "m2")],
    ids=["plan", "model"],
)
def test_a_file_that_is_no_plan_or_no_model_is_one_line_and_exit_code_2(start, tmp_path, model, options, words):
    (tmp_path / "fitted.yaml").write_text(parameter_file(model))
    (tmp_path / "plan.json").write_text("{}")
    given = [word for option in options for word in (option, str(tmp_path / "plan.json"))]
    balance = start(str(tmp_path / "fitted.yaml"), *given, program=EXAMPLE)
    assert balance.exit_code() == 2
    (line,) = balance.said.splitlines()
    assert words in line


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """Return the model that is identified from the example bags, of the same rig."""
    out, bags = tmp_path_factory.mktemp("found"), [str(BAGS / name) for name in ("swing_wide", "swing_folded")]
    identify = [sys.executable, "-m", "cdp_ident", "identify", "--bag", *bags, "--out", str(out), "--once", "--force"]
    subprocess.run(identify, check=True, stdout=subprocess.DEVNULL)
    return out / "fitted.yaml"


@pytest.mark.campaign
@pytest.mark.parametrize("seed", range(20))
def test_it_stands_for_a_minute_in_real_time_from_starts_within_three_degrees(
    start_driver, start_emulator, start_balance, found, seed
):
    lean = np.radians(np.random.default_rng(seed).uniform(-3.0, 3.0, 2))
    start_driver()
    balance = start_balance("--seconds", "60", fitted=found)
    start_emulator(rig=RIG % (*lean, "let_go, wait: 1000"))
    assert balance.exit_code() == 0, balance.said

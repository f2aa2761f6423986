# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The commands of docs/tutorial.md, run one after the other as a reader would."""

import os
import re
import shutil
import signal
import subprocess
import time
from pathlib import Path

import pytest

from cdp_ident.configuration.parameter_file import read_parameter_file

ROOT = Path(__file__).parents[2]
DOCUMENT = (
    (ROOT / "docs/tutorial.md")
    .read_text(encoding="utf-8")
    .replace("wait: 12.5", "wait: 6.5")  # all three: quicker
    .replace("longest:=12.0", "longest:=6.0")
    .replace("rate: 200.0", "rate: 100.0")
)
_INERTIA = 0.1296 * 0.2007**2 + 0.0007 + (0.1154 + 0.2192) * 0.4**2
"""A22 of the rig that the tutorial describes [kg m^2]."""
PATIENCE = 300.0
"""Longest wait for anything [s]: the machine may be busy, and may have to compile first."""
WITHOUT_ROS = shutil.which("ros2") is None
BLOCKS = re.findall(r"```sh\n(.*?)```", DOCUMENT, re.DOTALL)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Return the reader's folder, with the rig's file that the page has, and nothing else."""
    folder = tmp_path_factory.mktemp("home") / "tutorial"
    rig = re.search(r"```yaml\n(.*?)```", DOCUMENT, re.DOTALL)
    assert rig
    folder.mkdir()
    (folder / "rig.yaml").write_text(rig[1])
    return folder


@pytest.fixture(scope="module")
def shell(folder):
    """Return what starts commands in a terminal that was set up as the page says.

    Without ROS, that terminal knows nothing of the package beforehand. What is left running is ended with the test.
    What the package has compiled for this user is there as it is for a reader, who has built it.
    """
    cache = os.environ.get("XDG_CACHE_HOME") or str(Path("~/.cache").expanduser())
    environment = {**os.environ, "HOME": str(folder.parent), "XDG_CACHE_HOME": cache}
    place = BLOCKS[WITHOUT_ROS].replace("~/ros2_ws/", f"{ROOT}/").replace("~/cdp_ident", str(ROOT))
    if WITHOUT_ROS:
        environment["PATH"] = os.defpath
        for name in ("PYTHONPATH", "AMENT_PREFIX_PATH", "COLCON_PREFIX_PATH", "VIRTUAL_ENV"):
            environment.pop(name, None)
    started = []

    def start(commands):
        if WITHOUT_ROS:
            commands = re.sub(r"(?m)^ros2 (service|param) .*$", "", commands)
            commands = commands.replace("ros2 run cdp_ident", "python3 -m cdp_ident")
        process = subprocess.Popen(
            ["bash", "-e", "-c", f"{place}\ncd ~/tutorial\n{commands}\nwait"], env=environment, text=True,
            start_new_session=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip
        started.append(process)
        return process

    yield start
    for process in started:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGTERM)
            process.communicate(timeout=PATIENCE)


@pytest.mark.waits
def test_it_leads_from_wiring_to_a_controller_that_stands(folder, shell):
    *_, new_folder, nodes, zero, identify, suggest, heavier, again, linearize, balance, live = BLOCKS
    assert new_folder == "mkdir ~/tutorial\ncd ~/tutorial\n"

    def record(commands, trials, zero=""):
        *before, driver, recorder, rig = commands.splitlines()
        do("\n".join(before))
        running = shell(f"{driver}\n{recorder}")
        # A reader sees that both are there; the rig's script begins when it is switched on.
        _wait_until(lambda: "bag" in _topics(), running)
        rig_running = shell(rig)
        if zero:
            _wait_until(lambda: shell(zero).wait(PATIENCE) == 0, running)  # it is refused until samples come
        _wait_until(lambda: len(list(folder.glob("trials/*/metadata.yaml"))) >= trials, running)
        for process in (rig_running, running):
            os.killpg(process.pid, signal.SIGTERM)
            process.communicate(timeout=PATIENCE)

    def do(commands):
        done = shell(commands)
        output, _ = done.communicate(timeout=3 * PATIENCE)
        assert done.returncode == 0, f"{commands}{output}"
        return output

    def fitted():
        return read_parameter_file(folder / "found/fitted.yaml", "identify").taken()

    record(nodes, 3, zero)
    do(identify)
    assert fitted()["effects.coulomb_friction.outer.torque"] == pytest.approx(0.002, rel=0.5)
    assert not fitted()["determined.A22"]
    assert "it is determined then, to ± 0." in do(suggest)
    record(heavier, 4)
    do(again)
    do(linearize)
    output = do(balance)
    assert fitted()["effects.coulomb_friction.outer.torque"] == pytest.approx(0.002, rel=0.03)
    assert fitted()["determined.A22"]
    assert fitted()["A22"] == pytest.approx(_INERTIA, rel=0.01)
    assert "balanced for" in output
    # Slower than real time, that a busy machine be quick enough, but with the page's samples.
    for word, other in (
        ("rig.yaml >", "rig.yaml | sed s/100.0/200.0/ >"),
        ("driven.yaml &", "driven.yaml --speed 0.25 &"),
        ("zero.yaml &", "zero.yaml -p use_sim_time:=true &"),
        ("--seconds 60", "--seconds 3 || true"),
    ):
        assert word in live
        live = live.replace(word, other)
    assert "balanced for 3.0 s" in do(f"{live}kill %1 %2")


def _topics():
    """Return the names of the recorder's topics, once it is there."""
    import rclpy  # noqa: PLC0415 - the context lives as long as the question

    context = rclpy.Context()
    rclpy.init(context=context)
    node = rclpy.create_node("reader", context=context)
    time.sleep(0.5)
    names = [name for name, _ in node.get_topic_names_and_types() if name.startswith("/recorder/")]
    node.destroy_node()
    rclpy.shutdown(context=context)
    return " ".join(names)


def _wait_until(condition, running):
    deadline = time.monotonic() + PATIENCE
    while not condition():
        assert running.poll() is None, running.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.1)

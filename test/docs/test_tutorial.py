"""The commands of docs/tutorial.md, run one after the other as a reader would."""

import os
import re
import shutil
import signal
import stat
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

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
ROS2 = """\
#!{python}
# ROS's command line is not on PyPI: this does what the tutorial asks of it.
import os, sys
what, arguments = sys.argv[1:3], sys.argv[3:]
if what == ["run", "cdp_ident"]:
    os.execv(sys.executable, [sys.executable, "-m", "cdp_ident", *arguments])
assert what == ["service", "call"] and arguments[1:] == ["std_srvs/srv/Trigger"], sys.argv
import rclpy
from std_srvs.srv import Trigger
rclpy.init()
node = rclpy.create_node("caller")
client = node.create_client(Trigger, arguments[0])
assert client.wait_for_service({patience})
answer = client.call_async(Trigger.Request())
rclpy.spin_until_future_complete(node, answer, timeout_sec={patience})
print(answer.result())
sys.exit(0 if answer.result().success else 1)
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the reader's folder, with the rig's file and the package's examples."""
    folder = tmp_path_factory.mktemp("tutorial")
    rig = re.search(r"```yaml\n(.*?)```", DOCUMENT, re.DOTALL)
    assert rig
    (folder / "rig.yaml").write_text(rig[1])
    (folder / "examples").symlink_to(ROOT / "examples")
    if shutil.which("ros2") is None:
        command = folder / "bin/ros2"
        command.parent.mkdir()
        command.write_text(ROS2.format(python=sys.executable, patience=PATIENCE))
        command.chmod(command.stat().st_mode | stat.S_IXUSR)
    return folder


@pytest.fixture(scope="module")
def shell(folder: Path) -> Iterator[Callable[[str], "subprocess.Popen[str]"]]:
    """Return what starts commands in a shell; all that they left running is ended with the test."""
    path = os.pathsep.join([str(folder / "bin"), str(Path(sys.executable).parent), os.environ["PATH"]])
    python = os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")])
    environment = {**os.environ, "PATH": path, "PYTHONPATH": python}
    started: list[subprocess.Popen[str]] = []

    def start(commands: str) -> subprocess.Popen[str]:
        process = subprocess.Popen(
            ["bash", "-e", "-c", f"{commands}\nwait"], cwd=folder, env=environment, start_new_session=True, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        )  # fmt: skip
        started.append(process)
        return process

    yield start
    for process in started:
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGTERM)
            process.communicate(timeout=PATIENCE)


@pytest.mark.waits
def test_it_leads_from_wiring_to_a_controller_that_stands(
    folder: Path, shell: Callable[[str], "subprocess.Popen[str]"]
) -> None:
    nodes, zero, identify, suggest, heavier, *then = re.findall(r"```sh\n(.*?)```", DOCUMENT, re.DOTALL)

    def record(commands: str, trials: int, zero: str = "") -> None:
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

    def do(commands: str) -> str:
        done = shell(commands)
        output, _ = done.communicate(timeout=3 * PATIENCE)
        assert done.returncode == 0, f"{commands}{output}"
        return output

    def fitted() -> dict[str, Any]:
        return read_parameter_file(folder / "found/fitted.yaml", "identify").taken()

    record(nodes, 3, zero)
    do(identify)
    assert fitted()["effects.coulomb_friction.outer.torque"] == pytest.approx(0.002, rel=0.5)
    assert not fitted()["determined.A22"]
    assert "it is determined then, to ± 0." in do(suggest)
    record(heavier, 4)
    output = [do(commands) for commands in then][-1]
    assert fitted()["effects.coulomb_friction.outer.torque"] == pytest.approx(0.002, rel=0.03)
    assert fitted()["determined.A22"]
    assert fitted()["A22"] == pytest.approx(_INERTIA, rel=0.01)
    assert "balanced for" in output


def _topics() -> str:
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


def _wait_until(condition: Callable[[], bool], running: "subprocess.Popen[str]") -> None:
    deadline = time.monotonic() + PATIENCE
    while not condition():
        assert running.poll() is None, running.communicate()
        assert time.monotonic() < deadline
        time.sleep(0.1)

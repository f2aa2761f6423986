# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The shared ends of every node, tried on a real process."""

import os
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import pytest

SCRIPT = textwrap.dedent(
    """
    import sys
    from cdp_ident.command_line import ArgumentParser, entry_point
    from cdp_ident.configuration.described import Described
    from cdp_ident.ros.node import parse_arguments, run_node

    class Body:
        exit_code = None

        def __init__(self, node, parameters, once):
            self.rate = parameters.declare("rate", 10.0, "how often", unit="Hz", minimum=1.0, maximum=1000.0)
            self.codec = parameters.declare("codec", "binary", "the codec", choices=("binary", "text"))
            parameters.declare("signs", [1.0, 1.0], "the signs", minimum=-1.0, maximum=1.0)
            parameters.declare("count", 3, "a number", minimum=0, changeable=True)
            self.parameters, self.node, self.once = parameters, node, once
            node.create_timer(0.05, self.tick)
            self.said = False

        def tick(self):
            if not self.said:
                from rclpy.parameter import Parameter
                changes = {"rate": 5.0, "count": 7, "use_sim_time": True}
                results = self.node.set_parameters([Parameter(name, value=value) for name, value in changes.items()])
                print("outside", [result.successful for result in results], results[0].reason, flush=True)
                self.parameters.show([Described("rate", 9.0, "how often")])
                print("ready", self.parameters.get("rate"), self.parameters.get("count"), flush=True)
                self.said = True
                if self.once:
                    self.exit_code = 7

        def close(self):
            print("closed", flush=True)

    @entry_point
    def main(arguments):
        parser = ArgumentParser("probe", "A probe.")
        parser.add_argument("--once", action="store_true")
        options = parse_arguments(parser, arguments)
        return run_node("probe", lambda node, parameters: Body(node, parameters, options.once), arguments)

    if __name__ == "__main__":
        sys.exit(main())
    """
)
ROOT = Path(__file__).parents[2]
PATIENCE = 300.0


def start(*arguments):
    command = [sys.executable, "-c", SCRIPT, *arguments]
    return subprocess.Popen(command, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE, cwd=ROOT)


def refused(capfd, *arguments):
    """Return the one line with which it ends in this process."""
    scope = {"__name__": "probe"}
    exec(SCRIPT, scope)
    assert scope["main"](arguments) == 2
    (line,) = capfd.readouterr().err.splitlines()
    return line


@pytest.mark.parametrize("numbers", [(signal.SIGINT,), (signal.SIGTERM,), (signal.SIGINT,) * 5])
def test_a_signal_and_any_more_of_them_end_the_node_cleanly(numbers):
    with start() as process:
        assert process.stdout.readline().startswith("outside")
        process.stdout.readline()
        for number in numbers:
            process.send_signal(number)
        output, errors = process.communicate(timeout=PATIENCE)
    assert (process.returncode, errors) == (0, "")
    assert output.endswith("closed\n")


def test_a_node_that_is_asked_to_end_until_it_has_ended_ends_cleanly():
    with start() as process:
        assert process.stdout.readline().startswith("outside")
        while process.poll() is None:
            process.send_signal(signal.SIGINT)
            time.sleep(0.01)
        _, errors = process.communicate(timeout=PATIENCE)
    assert (process.returncode, errors) == (0, "")


def test_a_node_ends_by_itself_with_its_own_exit_code_and_keeps_parameters_from_outside_writes():
    with start("--once") as process:
        output, errors = process.communicate(timeout=PATIENCE)
    assert (process.returncode, errors) == (7, "")
    outside, ready, closed = output.splitlines()
    assert outside.startswith("outside [False, True, False] Trying to set a read-only parameter: rate")
    assert (ready, closed) == ("ready 9.0 7", "closed")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["-p", "rat:=3.0"], ["'rat'", "did you mean 'rate'?"]),
        (["-p", "rate:=0.5"], ["'rate'", "0.5", "at least 1 and at most 1000 Hz", "how often"]),
        (["-p", "rate:= "], ["'rate'", "without a value"]),
        (["-p", "qos_overrides./joint_states.publisher.depth:= "], ["without a value"]),
        (["-p", "use_sim_time:=maybe"], ["'use_sim_time'", "BOOL"]),
        (["-p", "rate:=fast"], ["'rate'", "like its default, 10.0"]),
        (["-p", "codec:=morse"], ["'codec'", "one of: binary, text"]),
        (["-p", "signs:=[1.0, 3.0]"], ["'signs'", "3.0", "at most 1"]),
        (["-p", "rate:=.nan"], ["'rate'", "nan"]),
        (["--params-file", "/does/not/exist.yaml"], ["/does/not/exist.yaml"]),
        (["--nonsense"], ["--nonsense"]),
        (["-r", "__node:=a b"], ["a b"]),
    ],
)
def test_what_ros_is_told_wrongly_ends_as_one_line_and_exit_code_2(capfd, arguments, words):
    line = refused(capfd, "--ros-args", *arguments)
    for word in words:
        assert word in line


def test_a_pipe_in_place_of_a_parameter_file_is_refused_at_once(capfd, tmp_path):
    os.mkfifo(tmp_path / "pipe.yaml")
    assert "it is not a regular file" in refused(capfd, "--ros-args", "--params-file", str(tmp_path / "pipe.yaml"))


def test_without_a_home_it_ends_as_one_line(capfd, monkeypatch):
    for name in ("HOME", "ROS_HOME", "ROS_LOG_DIR"):
        monkeypatch.delenv(name, raising=False)
    assert "ROS_LOG_DIR" in refused(capfd)

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Nodes as processes, and a node of the test's own that listens to them."""

import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
import rclpy
import rclpy.executors
import rclpy.qos
from diagnostic_msgs.msg import DiagnosticArray
from rcl_interfaces.srv import GetParameters, ListParameters, SetParametersAtomically
from rclpy.parameter import Parameter, parameter_value_to_python
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import Trigger

from cdp_ident.ros.topics import latched

ROOT = Path(__file__).parents[2]
PATIENCE = 300.0
"""Longest wait for anything [s]: the machine may be busy, and may have to compile first."""


class Process:
    """One node, started as a user would."""

    def __init__(self, log, *arguments, program=("-m", "cdp_ident")):
        self.log = log
        with log.open("w") as output:
            self.popen = subprocess.Popen(
                [sys.executable, *program, *arguments], stdout=output, stderr=output, cwd=ROOT
            )

    @property
    def said(self):
        """Everything it printed so far."""
        return self.log.read_text()

    def wait_until_it_says(self, words, *, once_more=False):
        """Wait until it has printed something, or printed it once more; if it ends without, tell what it said."""
        enough = self.said.count(words) + 1 if once_more else 1
        deadline = time.monotonic() + PATIENCE
        while self.said.count(words) < enough:
            assert self.popen.poll() is None, f"it ended: {self.said}"
            assert time.monotonic() < deadline, f"it did not say {words!r} within {PATIENCE:g} s: {self.said}"
            time.sleep(0.02)

    def exit_code(self):
        """Wait until it ends by itself."""
        return self.popen.wait(timeout=PATIENCE)

    def end(self, number=signal.SIGINT):
        """Send a signal, wait for the end and return the exit code."""
        if self.popen.poll() is None:
            self.popen.send_signal(number)
        return self.exit_code()


class Listener:
    """Hears what the nodes publish, and calls their services."""

    def __init__(self):
        self.context = rclpy.Context()
        rclpy.init(context=self.context)
        self.node = rclpy.create_node("listener", context=self.context)
        self.joint_states = []
        self.diagnostics = []
        self.statuses = []
        reliable = rclpy.qos.QoSProfile(depth=20000)
        self.node.create_subscription(JointState, "joint_states", self.joint_states.append, reliable)
        self.node.create_subscription(DiagnosticArray, "/diagnostics", self._take_diagnostics, 100)
        self.states, self.bags = self.words("/recorder/state"), self.words("/recorder/bag")
        self.executor = rclpy.executors.SingleThreadedExecutor(context=self.context)
        self.executor.add_node(self.node)
        self.stopping = False
        self.thread = threading.Thread(target=self._spin)
        self.thread.start()

    def words(self, topic):
        """Return what a latched topic says, as it comes."""
        heard = []
        self.node.create_subscription(String, topic, lambda word: heard.append(word.data), latched(10))
        return heard

    def _take_diagnostics(self, message):
        self.statuses += message.status
        self.diagnostics += [status for status in message.status if status.name == "/driver"]

    def _spin(self):
        while not self.stopping:
            self.executor.spin_once(timeout_sec=0.05)

    def close(self):
        """End listening."""
        self.stopping = True
        self.thread.join()
        self.node.destroy_node()
        rclpy.shutdown(context=self.context)

    def wait_for(self, condition):
        """Wait until a condition holds."""
        deadline = time.monotonic() + PATIENCE
        while not condition():
            assert time.monotonic() < deadline, f"it did not happen within {PATIENCE:g} s"
            time.sleep(0.02)

    def call(self, service):
        """Call a Trigger service."""
        response = self._call(Trigger, service, Trigger.Request())
        return response.success, response.message

    def set_parameter(self, node, name, value):
        """Ask a node to change a parameter."""
        request = SetParametersAtomically.Request(parameters=[Parameter(name, value=value).to_parameter_msg()])
        result = self._call(SetParametersAtomically, f"{node}/set_parameters_atomically", request).result
        return result.successful, result.reason

    def get_parameter(self, node, name):
        """Return the present value of a node's parameter."""
        return self.get_parameters(node, [name])[name]

    def get_parameters(self, node, names):
        """Return the present values of several of a node's parameters, asked for at once."""
        values = self._call(GetParameters, f"{node}/get_parameters", GetParameters.Request(names=names)).values
        return {name: parameter_value_to_python(value) for name, value in zip(names, values, strict=True)}

    def parameter_names(self, node):
        """Return the names of a node's parameters."""
        return list(self._call(ListParameters, f"{node}/list_parameters", ListParameters.Request()).result.names)

    def _call(self, kind, service, request):
        client = self.node.create_client(kind, service)
        try:
            assert client.wait_for_service(timeout_sec=PATIENCE)
            return self.answer(lambda: client.call_async(request))
        finally:
            self.node.destroy_client(client)

    def answer(self, ask):
        """Return a service's answer; ask again where a request went to a node that was killed but not yet forgotten.

        A slow answer to the first request is still the answer: asked once more, a node may say that it is busy.
        """
        deadline = time.monotonic() + PATIENCE
        futures = []
        while time.monotonic() < deadline:
            futures.append(ask())
            ask_again = time.monotonic() + 3.0
            while time.monotonic() < ask_again:
                for future in futures:
                    if future.done():
                        return future.result()
                time.sleep(0.02)
        raise AssertionError(f"no service answered within {PATIENCE:g} s")

    def level(self):
        """Return the level of the latest diagnostics."""
        return self.diagnostics[-1].level[0] if self.diagnostics else None

    def value(self, key):
        """Return a value of the latest diagnostics."""
        return (
            next((value.value for value in self.diagnostics[-1].values if value.key == key), "")
            if self.diagnostics
            else ""
        )

    def count(self, key):
        """Return a counter of the latest diagnostics."""
        return int(self.value(key) or 0)


@pytest.fixture
def listener():
    result = Listener()
    yield result
    result.close()


@pytest.fixture
def start(tmp_path):
    """Start nodes; whatever still runs at the end is stopped, and must stop cleanly."""
    processes = []

    def start_one(*arguments, **program):
        processes.append(Process(tmp_path / f"log{len(processes)}", *arguments, **program))
        return processes[-1]

    yield start_one
    for process in processes:
        process.popen.send_signal(signal.SIGINT)
    codes = []
    for process in processes:
        try:
            codes.append(process.exit_code())
        except subprocess.TimeoutExpired:
            process.popen.kill()
            process.popen.wait()
            codes.append(-1)
    assert all(code in (0, 2, 3, -signal.SIGKILL) for code in codes), [process.said for process in processes]


@pytest.fixture
def refused(capfd):
    """Run in this process a node that must not start; return the one line with which it ends."""

    def run(main, *arguments):
        assert main(arguments) == 2
        (line,) = [line for line in capfd.readouterr().err.splitlines() if not line.startswith("[INFO]")]
        assert re.match(r"\w+: error: ", line)
        return line

    return run


def of_ros(*parameters):
    """Return parameters as ROS's arguments."""
    return ["--ros-args", *(word for parameter in parameters for word in ("-p", parameter))]


@pytest.fixture
def start_driver(start, tmp_path):
    """Start a driver for the port tmp_path/tty whose zero is kept in tmp_path/zero.yaml."""

    def start_one(*parameters, port="tty"):
        given = [f"port:={tmp_path / port}", f"zero_file:={tmp_path / 'zero.yaml'}", *parameters]
        return start("driver", *of_ros(*given))

    return start_one


@pytest.fixture
def start_emulator(start, tmp_path):
    """Start an emulator behind tmp_path/tty; `rig` is its YAML file's text."""

    def start_one(*options, rig="{script: [wait: 1000]}", link="tty"):
        (tmp_path / "rig.yaml").write_text(rig)
        return start("emulator", "--link", str(tmp_path / link), "--rig", str(tmp_path / "rig.yaml"), *options)

    return start_one

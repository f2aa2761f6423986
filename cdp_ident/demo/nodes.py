# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Nodes as processes that do not outlive the program that started them, and one more that talks with them."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from types import FrameType
from typing import Any

import rclpy
import rclpy.executors
import rclpy.signals
from std_msgs.msg import String
from std_srvs.srv import Trigger

from cdp_ident.errors import CdpIdentError
from cdp_ident.ros.model_parameters import ParameterSource
from cdp_ident.ros.topics import latched

_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_ENDING = 15.0
"""Longest wait for a node to end after it was asked to [s]."""
_PATIENCE = 60.0
"""Longest wait for anything that is not said to take longer [s]."""
_ANSWER = 5.0
"""A service that has not answered for so long is asked again [s]."""


class Nodes:
    """Runs nodes of this package while a `with` block lasts; at its end, whatever the reason, all are stopped.

    Inside the block they are heard and called as by any other node, and a signal to end (Ctrl-C, SIGTERM, SIGHUP) is
    noticed at the next `check` or while something is waited for, which raises `KeyboardInterrupt`; so nothing is
    interrupted half-way, neither a start nor the stopping.
    """

    def __init__(self, logs: Path) -> None:
        """What the nodes print goes to a file each in the folder `logs`."""
        self._logs = logs
        self._running: dict[str, subprocess.Popen[bytes]] = {}
        self._asked_to_end = False

    def __enter__(self) -> "Nodes":
        self._logs.mkdir(parents=True, exist_ok=True)
        with ExitStack() as ends:
            for number in _SIGNALS:
                if signal.getsignal(number) is not signal.SIG_IGN:
                    ends.callback(signal.signal, number, signal.signal(number, self._note))
            rclpy.init(args=[], signal_handler_options=rclpy.signals.SignalHandlerOptions.NO)
            ends.callback(rclpy.try_shutdown)
            self._node = rclpy.create_node("client")
            self._executor = rclpy.executors.SingleThreadedExecutor()
            self._executor.add_node(self._node)
            ends.callback(self._stop_all)
            self._ends = ends.pop_all()
        return self

    def __exit__(self, *raised: object) -> None:
        self._ends.close()

    def _note(self, _number: int, _frame: FrameType | None) -> None:
        self._asked_to_end = True

    def _stop_all(self) -> None:
        for name in reversed(tuple(self._running)):
            with suppress(CdpIdentError):
                self.stop(name)

    def start(self, name: str, *arguments: str, logged: bool = True) -> None:
        """Start a node; one that is not `logged` prints where this program does."""
        output = self._log(name).open("wb") if logged else None
        try:
            # A session of its own: Ctrl-C is for this program, which then stops the nodes in order.
            self._running[name] = subprocess.Popen(
                [sys.executable, "-m", "cdp_ident", name, *arguments],
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=output,
                start_new_session=True,
            )
        finally:
            if output:
                output.close()

    def check(self) -> None:
        """Raise `CdpIdentError` where a node has ended by itself, `KeyboardInterrupt` where the program is to end."""
        if self._asked_to_end:
            raise KeyboardInterrupt
        for name, process in self._running.items():
            if process.poll() is not None:
                raise self._failure(name, process.returncode)

    def stop(self, name: str) -> None:
        """Ask a node to end and wait for it. Raises `CdpIdentError` where it did not end well."""
        process = self._running.pop(name)
        process.terminate()
        try:
            code = process.wait(_ENDING)
        except subprocess.TimeoutExpired:
            process.kill()
            code = process.wait()
        if code != 0:
            raise self._failure(name, code)

    def _log(self, name: str) -> Path:
        return self._logs / f"{name}.log"

    def _failure(self, name: str, code: int) -> CdpIdentError:
        sentence = f"the node {name} ended with exit code {code}"
        log = self._log(name)
        if not log.exists():
            return CdpIdentError(f"{sentence}; what it said stands above")
        said = log.read_text(errors="replace").splitlines()
        return CdpIdentError(f"{sentence}: {said[-1] if said else 'it said nothing'} (all of it: {log})")

    def hear(self, topic: str) -> list[str]:
        """Subscribe to a latched topic of strings; what comes is appended to the list that is returned."""
        heard: list[str] = []
        self._node.create_subscription(String, topic, lambda message: heard.append(message.data), latched(10))
        return heard

    def wait_for(self, what: str, condition: Callable[[], Any], patience: float = _PATIENCE) -> None:
        """Wait until a condition holds. Raises `CdpIdentError` if it does not within `patience` [s]."""
        deadline = time.monotonic() + patience
        while not condition():
            self.check()
            if time.monotonic() > deadline:
                raise CdpIdentError(f"{what} did not happen within {patience:.0f} s")
            self._executor.spin_once(timeout_sec=0.05)

    def trigger(self, service: str) -> str:
        """Call a Trigger service, again while it refuses or does not answer, and return its message.

        Raises `CdpIdentError` where it goes on so.
        """
        client = self._node.create_client(Trigger, service)
        try:
            self.wait_for(f"the start of the service {service}", client.service_is_ready)
            deadline, why = time.monotonic() + _PATIENCE, ""
            while time.monotonic() < deadline:
                future, answer_by = client.call_async(Trigger.Request()), time.monotonic() + _ANSWER
                self.wait_for("an answer", lambda: future.done() or time.monotonic() > answer_by)  # noqa: B023
                if future.done() and future.result().success:
                    return str(future.result().message)
                why = f"refuses: {future.result().message}" if future.done() else "does not answer"
                time.sleep(0.2)
            raise CdpIdentError(f"{service} {why}, for {_PATIENCE:.0f} s")
        finally:
            self._node.destroy_client(client)

    def parameters(self, node: str, prefixes: Sequence[str]) -> dict[str, Any]:
        """Return the values of the model that a node serves whose names begin with one of the prefixes, by name."""
        served: list[dict[str, Any]] = []
        ParameterSource(self._node, node, served.append)
        self.wait_for(f"an answer of {node}", lambda: served)
        return {name: value for name, value in sorted(served[0].items()) if name.startswith(tuple(prefixes))}


def own_domain() -> None:
    """Let this program and the nodes that it starts find only each other, not a rig that runs on this network."""
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    os.environ["ROS_DOMAIN_ID"] = str(os.getpid() % 100 + 1)

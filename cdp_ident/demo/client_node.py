# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A node that hears what the others publish, calls their services and reads their parameters, as any node would."""

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import rclpy
import rclpy.executors
import rclpy.signals
from rcl_interfaces.srv import GetParameters, ListParameters
from rclpy.parameter import parameter_value_to_python
from std_msgs.msg import String
from std_srvs.srv import Trigger

from cdp_ident.errors import CdpIdentError
from cdp_ident.ros.topics import latched

_PATIENCE = 60.0
"""Longest wait for anything that is not said to take longer [s]."""
_ANSWER = 5.0
"""A service that has not answered for so long is asked again [s]."""


class ClientNode:
    """The node, to be made by `client_node`; it lives only while one of its methods waits."""

    def __init__(self, node: Any, check: Callable[[], None]) -> None:
        self._node, self._check = node, check
        self._executor = rclpy.executors.SingleThreadedExecutor()
        self._executor.add_node(node)

    def hear(self, topic: str) -> list[str]:
        """Subscribe to a latched topic of strings; what comes is appended to the list that is returned."""
        heard: list[str] = []
        self._node.create_subscription(String, topic, lambda message: heard.append(message.data), latched(10))
        return heard

    def wait_for(self, what: str, condition: Callable[[], Any], patience: float = _PATIENCE) -> None:
        """Wait until a condition holds. Raises `CdpIdentError` if it does not within `patience` [s]."""
        deadline = time.monotonic() + patience
        while not condition():
            self._check()
            if time.monotonic() > deadline:
                raise CdpIdentError(f"{what} did not happen within {patience:.0f} s")
            self._executor.spin_once(timeout_sec=0.05)

    def trigger(self, service: str) -> str:
        """Call a Trigger service, again while it refuses, and return its message.

        Raises `CdpIdentError` where it goes on to refuse.
        """
        deadline = time.monotonic() + _PATIENCE
        while True:
            answer = self._call(Trigger, service, Trigger.Request())
            if answer.success:
                return str(answer.message)
            if time.monotonic() > deadline:
                raise CdpIdentError(f"{service} refuses: {answer.message}")
            self._check()
            time.sleep(0.2)

    def parameters(self, node: str, prefixes: Sequence[str]) -> dict[str, Any]:
        """Return the values of a node's parameters whose names begin with one of the prefixes."""
        listed = self._call(ListParameters, f"{node}/list_parameters", ListParameters.Request())
        names = sorted(name for name in listed.result.names if name.startswith(tuple(prefixes)))
        answer = self._call(GetParameters, f"{node}/get_parameters", GetParameters.Request(names=names))
        return {name: parameter_value_to_python(value) for name, value in zip(names, answer.values, strict=True)}

    def _call(self, kind: Any, service: str, request: Any) -> Any:
        client = self._node.create_client(kind, service)
        try:
            deadline = time.monotonic() + _PATIENCE
            self.wait_for(f"the start of the service {service}", client.service_is_ready)
            while time.monotonic() < deadline:
                future, answer_by = client.call_async(request), time.monotonic() + _ANSWER
                self.wait_for("an answer", lambda: future.done() or time.monotonic() > answer_by)  # noqa: B023
                if future.done():
                    return future.result()
            raise CdpIdentError(f"{service} did not answer within {_PATIENCE:.0f} s")
        finally:
            self._node.destroy_client(client)


@contextmanager
def client_node(check: Callable[[], None]) -> Iterator[ClientNode]:
    """Make a client_node for a `with` block; `check` is called while it waits, and may raise."""
    rclpy.init(args=[], signal_handler_options=rclpy.signals.SignalHandlerOptions.NO)
    try:
        yield ClientNode(rclpy.create_node("client"), check)
    finally:
        rclpy.try_shutdown()

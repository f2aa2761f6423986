# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The fitted model that another node serves, read over its parameter services and followed as it changes."""

import time
from collections.abc import Callable
from functools import partial
from typing import Any

from rcl_interfaces.msg import ParameterEvent, ParameterType
from rcl_interfaces.srv import GetParameters, ListParameters
from rclpy.parameter import parameter_value_to_python
from std_msgs.msg import String

from cdp_ident.configuration.fitted_model import describes_model
from cdp_ident.ros.qos import latched
from cdp_ident.ros.steady_timer import call_every

_LOOK_SECONDS = 0.1
"""How often it is looked whether there is something to ask for [s]."""
_ANSWER_SECONDS = 5.0
"""A node that has not answered for so long [s] is asked again: it may have been started anew."""


class ParameterSource:
    """Reads a node's model as soon as it serves one, and again whenever its parameters change."""

    def __init__(self, node: Any, source: str, take: Callable[[dict[str, Any]], None]) -> None:
        """`source` is the other node's full name; `take` is given its parameters that describe the model, by name."""
        self._node, self._source, self._take = node, source, take
        self._list = node.create_client(ListParameters, f"{source}/list_parameters")
        self._get = node.create_client(GetParameters, f"{source}/get_parameters")
        self._changed = True
        self._asked_at: float | None = None
        self._answers: list[tuple[Any, Any]] = []
        """The clients that were asked, and what they will answer."""
        node.create_subscription(ParameterEvent, "/parameter_events", self._note_event, 1000)
        node.create_subscription(String, f"{source}/state", self._note, latched())
        call_every(node, _LOOK_SECONDS, self._look)

    def _note_event(self, event: Any) -> None:
        if event.node == self._source:
            self._changed = True

    def _note(self, _message: Any) -> None:
        # A node that comes, or whose result is ready, may have done so before its events could be heard.
        self._changed = True

    def _look(self) -> None:
        now = time.monotonic()
        if self._asked_at is not None and now - self._asked_at > _ANSWER_SECONDS:
            for client, answer in self._answers:
                client.remove_pending_request(answer)
            self._asked_at, self._changed = None, True
        if self._changed and self._asked_at is None and self._list.service_is_ready() and self._get.service_is_ready():
            self._changed, self._asked_at = False, now
            self._answers.clear()
            self._ask(self._list, ListParameters.Request(), partial(self._listed, now))

    def _ask(self, client: Any, request: Any, take: Callable[[Any], None]) -> None:
        answer = client.call_async(request)
        self._answers.append((client, answer))
        answer.add_done_callback(take)

    def _listed(self, asked_at: float, future: Any) -> None:
        if asked_at == self._asked_at:
            names = [name for name in future.result().result.names if describes_model(name)]
            self._ask(self._get, GetParameters.Request(names=names), partial(self._got, asked_at, names))

    def _got(self, asked_at: float, names: list[str], future: Any) -> None:
        if asked_at != self._asked_at:
            return
        self._asked_at = None
        values = future.result().values
        if len(values) != len(names) or any(value.type == ParameterType.PARAMETER_NOT_SET for value in values):
            self._changed = True  # in between they became others
        elif not self._changed:
            self._take({n: parameter_value_to_python(value) for n, value in zip(names, values, strict=True)})

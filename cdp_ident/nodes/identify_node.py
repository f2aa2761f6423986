"""The ROS side of `identify`: parameters, the service to identify again, and the state."""

import threading
from collections.abc import Sequence
from typing import Any

from std_msgs.msg import String
from std_srvs.srv import Trigger

from cdp_ident.command_line import EXIT_INTERRUPTED
from cdp_ident.configuration.fitted_model import fitted_parameters
from cdp_ident.configuration.keys import KEYS, Scalar
from cdp_ident.configuration.settings import Settings
from cdp_ident.errors import CdpIdentError
from cdp_ident.pipeline.identifier import NODE_NAME, Identifier
from cdp_ident.pipeline.interruption import Interruption
from cdp_ident.report.contents import Section
from cdp_ident.report.outcome import LoadedJob
from cdp_ident.report.terminal import summary
from cdp_ident.ros.node import run_node
from cdp_ident.ros.parameters import Parameters, Shown
from cdp_ident.ros.qos import latched

_SECONDS_BETWEEN_LOOKS = 1.0
_LONGEST_GOODBYE = 5.0
"""How long the end of the program waits for an identification that runs [s]."""


class IdentifyNode:
    """The identification on its node: a thread identifies, all ROS callbacks run in the main thread."""

    exit_code: int | None = None

    def __init__(self, node: Any, parameters: Parameters, identifier: Identifier, once: bool) -> None:
        self._node, self._parameters, self._identifier, self._once = node, parameters, identifier, once
        self._given = parameters.given(KEYS.__contains__)
        waits_for = identifier.waits_for
        loaded = None if waits_for else identifier.load(self._given)
        self._shown: set[str] = set()
        self._show(loaded.job.settings if loaded else identifier.settings(self._given), None)
        parameters.start()
        self._interruption = Interruption()
        self._interruption.install()
        self._outcome: tuple[LoadedJob, Section] | Exception | None = None
        self._serves = False
        self._state = node.create_publisher(String, "~/state", latched())
        node.create_service(Trigger, "~/identify_again", self._again)
        self._done = node.create_guard_condition(self._take_outcome)
        self._closing = False
        self._thread = threading.Thread()
        if loaded:
            self._start(loaded)
        else:
            self._state.publish(String(data=f"waiting for a first trial in {waits_for}"))
        node.create_timer(_SECONDS_BETWEEN_LOOKS, self._look)

    def close(self) -> None:
        """End: an identification that still runs is given up."""
        self._closing = True
        self._interruption.given_up = True
        if self._thread.is_alive():
            if not self._serves:
                self.exit_code = EXIT_INTERRUPTED
            self._thread.join(_LONGEST_GOODBYE)
        self._interruption.remove()

    def _again(self, _request: Any, response: Any) -> Any:
        if self._thread.is_alive() or self._outcome is not None:
            response.success, response.message = False, "an identification is running: wait until ~/state is ready"
        else:
            self._start(None)
            response.success, response.message = True, "identifying: ~/state tells when it is done"
        return response

    def _look(self) -> None:
        """Identify anew when another bag has come into the folder that is watched."""
        if not self._thread.is_alive() and self._outcome is None and self._identifier.has_new:
            self._start(None)

    def _start(self, loaded: LoadedJob | None) -> None:
        self._state.publish(String(data="identifying"))
        self._thread = threading.Thread(target=self._identify, args=(loaded,), name="identification", daemon=True)
        self._thread.start()

    def _identify(self, loaded: LoadedJob | None) -> None:
        try:
            loaded = loaded or self._identifier.load(self._given)
            self._outcome = (loaded, self._identifier.finish(loaded, self._interruption))
        except Exception as error:  # noqa: BLE001 - raised again where the node's life is decided about
            self._outcome = error
        if not self._closing:
            self._done.trigger()

    def _take_outcome(self) -> None:
        outcome, self._outcome = self._outcome, None
        if isinstance(outcome, Exception):
            waits = self._serves or self._identifier.waits_for is not None
            if not waits or not isinstance(outcome, CdpIdentError):
                raise outcome
            self._state.publish(String(data=f"failed: {outcome}"))
            self._node.get_logger().error(f"{outcome}; the parameters are still those of before")
        elif outcome is not None:
            loaded, report = outcome
            self._show(loaded.job.settings, report)
            self._serves = True
            self._state.publish(String(data=f"ready: {summary(report)}"))
            if self._once:
                self.exit_code = 0
            else:
                self._node.get_logger().info(f"{self._node.get_fully_qualified_name()} serves the fitted parameters")

    def _show(self, settings: Settings, report: Section | None) -> None:
        """Make the settings in effect, and the fitted values once there are any, the node's parameters."""
        shown = {name: _setting(name, value) for name, value in settings.values().items()}
        if report is not None:
            shown |= {
                fitted.name: Shown(fitted.value, fitted.description, fitted.unit, fitted.minimum)
                for fitted in fitted_parameters(report)
            }
        self._parameters.show(shown, gone=self._shown - shown.keys())
        self._shown = set(shown)


def _setting(name: str, value: Scalar) -> Shown:
    key = KEYS[name]
    return Shown(value, key.description, key.unit, key.minimum, choices=key.choices)


def run_identify_node(identifier: Identifier, once: bool, arguments: Sequence[str]) -> int:
    """Run the node until it is told to end, or `once` until it has identified; return the exit code."""

    def make(node: Any, parameters: Parameters) -> IdentifyNode:
        return IdentifyNode(node, parameters, identifier, once)

    return run_node(NODE_NAME, make, arguments)

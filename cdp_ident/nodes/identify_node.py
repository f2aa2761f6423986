# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The ROS side of `identify`: parameters, the service to identify again, and the state."""

import threading
from dataclasses import replace
from typing import Any

from std_msgs.msg import String

from cdp_ident.bag.device_messages import Health, Level
from cdp_ident.command_line import EXIT_INTERRUPTED
from cdp_ident.configuration.fitted_model import fitted_parameters
from cdp_ident.configuration.settings import Settings, description_of, is_key, is_result
from cdp_ident.errors import CdpIdentError, OptionError
from cdp_ident.outside_text import shown, utf_8
from cdp_ident.pipeline.identifier import BAGS, Identifier
from cdp_ident.pipeline.interruption import Interruption
from cdp_ident.report.outcome import LoadedJob
from cdp_ident.report.schema import Section
from cdp_ident.report.wording import summary
from cdp_ident.ros.node import call_every, diagnose, serve
from cdp_ident.ros.parameters import Parameters
from cdp_ident.ros.topics import latched
from cdp_ident.user_input import user_path

_SECONDS_BETWEEN_LOOKS = 1.0
_LONGEST_GOODBYE = 5.0
"""How long the end of the program waits for an identification that runs [s]."""


class IdentifyNode:
    """The identification on its node: a thread identifies, all ROS callbacks run in the main thread."""

    exit_code: int | None = None

    def __init__(self, node: Any, parameters: Parameters, identifier: Identifier, once: bool) -> None:
        self._node, self._parameters, self._identifier, self._once = node, parameters, identifier, once
        self._bags = [utf_8(bag) for bag in identifier.request.bags] or [""]  # ROS has no empty list of strings
        """What the parameter was whose bags are fitted."""
        parameters.declare(
            BAGS,
            self._bags,
            "what is fitted jointly, beside bags of --watch; changed, by ~/identify_again",
            changeable=True,
        )
        self._take_bags()
        self._given = parameters.given(is_key)
        waits_for = identifier.waits_for
        self._waits = waits_for is not None
        loaded = None if waits_for else identifier.load(self._given)
        self._shown: set[str] = set()
        self._show(loaded.job.settings if loaded else identifier.settings(self._given), None)
        parameters.will_show(is_result)
        parameters.start()
        self._interruption = Interruption()
        self._interruption.install()
        self._found: tuple[Settings, Section] | None = None
        """What is to be served as soon as the main thread comes to it."""
        self._outcome: Section | BaseException | None = None
        self._serves = False
        self._states = node.create_publisher(String, "~/state", latched())
        self._state, self._level = "", Level.OK
        identifier.warn = lambda sentence: node.get_logger().warning(sentence)
        serve(node, "~/identify_again", self._again)
        serve(node, "~/cancel", self._cancel)
        diagnose(node, self._report)
        self._done = node.create_guard_condition(self._take_outcome)
        self._closing = False
        self._thread = threading.Thread()
        if loaded:
            self._start(loaded)
        else:
            self._say(f"waiting for a first trial in {waits_for}")
        call_every(node, _SECONDS_BETWEEN_LOOKS, self._look)

    def close(self) -> None:
        """End: an identification that still runs is given up."""
        self._closing = True
        self._interruption.given_up = True
        if self._thread.is_alive():
            if not self._serves:
                self.exit_code = EXIT_INTERRUPTED
            self._thread.join(_LONGEST_GOODBYE)
        self._interruption.remove()

    def _again(self) -> str:
        if self._thread.is_alive() or self._outcome is not None:
            raise OptionError("an identification is running: wait until ~/state is ready")
        self._start(None)
        return "identifying: ~/state tells when it is done"

    def _take_bags(self) -> None:
        """Go on with the bags that the parameter names, where it has become another: their names may not be UTF-8."""
        if (bags := list(self._parameters.get(BAGS))) != self._bags:
            self._bags = bags
            self._identifier.take_bags(tuple(user_path(bag) for bag in bags if bag))

    def _cancel(self) -> str:
        if not self._interruption.cancel():
            raise OptionError("no search is running")
        return "the search ends: its best so far is fitted, reported and served"

    def _say(self, state: str, level: Level = Level.OK) -> None:
        self._state, self._level = state, level
        self._states.publish(String(data=utf_8(state)))

    def _report(self) -> Health:
        return Health(self._level, self._state, {"serves a result": str(self._serves).lower()})

    def _look(self) -> None:
        """Say how far the search is; identify anew when another bag has come into the folder that is watched."""
        if (doing := self._identifier.doing) and (state := f"identifying: {doing}") != self._state:
            self._say(state)
        if not self._thread.is_alive() and self._outcome is None and self._identifier.has_new:
            self._start(None)

    def _start(self, loaded: LoadedJob | None) -> None:
        self._say("identifying")
        self._thread = threading.Thread(target=self._identify, args=(loaded,), name="identification", daemon=True)
        self._thread.start()

    def _identify(self, loaded: LoadedJob | None) -> None:
        try:
            if loaded is None:
                self._take_bags()
                loaded = self._identifier.load(self._given)
            with self._interruption.identifying():
                result = self._identifier.identify(loaded, self._interruption)
                if not result.failure:
                    self._found = (loaded.job.settings, result.report)
                    self._tell()
                self._identifier.write(result)
            self._outcome = result.report
        except BaseException as error:  # noqa: BLE001 - raised again where the node's life is decided about
            self._outcome = error
        self._tell()

    def _tell(self) -> None:
        if not self._closing:
            self._done.trigger()

    def _take_outcome(self) -> None:
        found, self._found = self._found, None
        if found is not None:
            self._show(*found)
            self._serves = True
            for warning in found[1]["warnings"]:
                self._node.get_logger().warning(shown(f"{warning['name']}: {warning['message']}"))
            if not self._once:
                self._node.get_logger().info(f"{self._node.get_fully_qualified_name()} serves the fitted parameters")
        outcome, self._outcome = self._outcome, None
        if outcome is None:
            return
        ends = self._once or self._interruption.ends
        if isinstance(outcome, BaseException):
            waits = (self._serves or self._waits) and not ends
            if not waits or not isinstance(outcome, CdpIdentError):
                raise outcome
            self._say(f"failed: {shown(outcome)}", Level.ERROR)
            self._node.get_logger().error(f"{shown(outcome)}; the parameters are those found last")
        else:
            self._say(f"ready: {summary(outcome)}", Level.WARN if outcome["warnings"] else Level.OK)
            if ends:
                self.exit_code = 0

    def _show(self, settings: Settings, report: Section | None) -> None:
        """Make the settings in effect, and the fitted values once there are any, the node's parameters."""
        values = [replace(description_of(name), value=value) for name, value in settings.values().items()]
        values += fitted_parameters(report) if report else ()
        names = {shown.name for shown in values}
        self._parameters.show(values, gone=self._shown - names)
        self._shown = names

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Records free-swing trials as rosbag2 bags, one bag a trial."""

from collections.abc import Callable, Sequence
from typing import Any

from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import JointState, TimeReference
from std_msgs.msg import String

from cdp_ident.bag import joint_state
from cdp_ident.bag.device_messages import DIAGNOSTICS, TIME_REFERENCE, Health, Level
from cdp_ident.command_line import ArgumentParser, entry_point
from cdp_ident.model.weights import ADDED, ADDED_STD, DESCRIPTIONS, NAMES, NOTHING, RODS, Weight, weights_of
from cdp_ident.outside_text import shown, utf_8
from cdp_ident.rig.recording.facts import RecorderOptions
from cdp_ident.rig.recording.recorder import FLUSH_NS, Recorder, Surroundings
from cdp_ident.ros.node import call_every, diagnose, parse_arguments, run_node, serve
from cdp_ident.ros.parameters import Parameters
from cdp_ident.ros.topics import Subscription, latched, offered

DESCRIPTION = """\
Record free-swing trials. Armed, it waits until the pendulum is held away from hanging and let go, records until it is
at rest or caught, and writes one rosbag2 bag (MCAP) a trial: the joint states, the device's own times and the
diagnostics from a moment before the release on, and what is known of the trial as metadata, weights on its rods among
it (parameters added.inner and added.outer, to be set before it begins). It warns when a trial is of little use: not
zero-input, samples lost, too short. Killed in the middle, it completes the bag at its next start.

subscribes  joint_states (sensor_msgs/JointState), time_reference (sensor_msgs/TimeReference)
            /diagnostics (diagnostic_msgs/DiagnosticArray)
publishes   ~/state (std_msgs/String, latched)  idle, armed or recording
            ~/bag (std_msgs/String, latched)    folder of the last finished bag
            /diagnostics (diagnostic_msgs/DiagnosticArray)  once a second
serves      ~/arm    (std_srvs/Trigger)  wait for the release
            ~/start  (std_srvs/Trigger)  record now, release or not
            ~/stop   (std_srvs/Trigger)  end the trial, or the waiting for one"""

EXAMPLE = """\
example:
  ros2 run cdp_ident recorder --ros-args -p folder:=bags -p rearm:=true"""


_SAID_AFTER = 5
"""So many seconds of silence are said in the log, too: a rig's first samples take some."""


class RecorderNode:
    """The recorder on its node."""

    exit_code: int | None = None

    def __init__(self, node: Any, parameters: Parameters) -> None:
        self._node = node
        self._clock = node.get_clock()
        options = parameters.declare_fields(RecorderOptions())
        weights = _declare_weights(parameters)
        parameters.start()
        self._state = node.create_publisher(String, "~/state", latched())
        self._bag = node.create_publisher(String, "~/bag", latched())
        self._joint_states = node.resolve_topic_name("joint_states")
        self._silent_for = 0
        logger = node.get_logger()
        self._recorder = Recorder(
            options,
            Surroundings(
                say=lambda sentence: logger.info(shown(sentence)),
                warn=lambda sentence: logger.warning(shown(sentence)),
                on_state=lambda state: self._state.publish(String(data=state)),
                on_bag=lambda folder: self._bag.publish(String(data=utf_8(folder))),
                drivers=self._drivers,
                weights=weights,
                offered=lambda topic: offered(node, topic),
            ),
        )
        self._subscriptions = [
            self._subscribe(JointState, joint_state.MESSAGE_TYPE, "joint_states"),
            self._subscribe(TimeReference, TIME_REFERENCE, "time_reference"),
            self._subscribe(DiagnosticArray, DIAGNOSTICS, "/diagnostics"),
        ]
        serve(node, "~/arm", self._recorder.arm)
        serve(node, "~/start", lambda: self._recorder.start(self._now()))
        serve(node, "~/stop", self._stop)
        call_every(node, FLUSH_NS * 1e-9, lambda: self._recorder.tick(self._now()))
        diagnose(node, self._report)

    def close(self) -> None:
        """Complete the bag that is being recorded, with all that has arrived."""
        self._drain()
        self._recorder.close()

    def _report(self) -> Health:
        recorder = self._recorder
        values = {"state": recorder.state, "last bag": str(recorder.last_bag or "none"), "folder": str(recorder.folder)}
        if recorder.problem:
            return Health(Level.ERROR, recorder.problem, values)
        hears = recorder.hears_joint_states(self._now())
        self._silent_for = 0 if hears else self._silent_for + 1
        if hears:
            return Health(Level.OK, recorder.state, values)
        drivers = ", ".join(sorted(self._drivers()))
        why = (
            f", though {drivers} publishes them: after a kill, half a minute may pass"
            if drivers
            else ": no node publishes them"
        )
        problem = f"{recorder.state}: no joint states come on {self._joint_states}{why}"
        if self._silent_for == _SAID_AFTER:
            self._node.get_logger().warning(shown(problem))
        return Health(Level.WARN, problem, values)

    def _drivers(self) -> set[str]:
        publishers = self._node.get_publishers_info_by_topic(self._joint_states)
        return {f"{info.node_namespace.rstrip('/')}/{info.node_name}" for info in publishers}

    def _subscribe(self, message_class: type, message_type: str, topic: str) -> Subscription:
        name = self._node.resolve_topic_name(topic)

        def take(raw: bytes) -> None:
            self._recorder.take(name, message_type, self._now(), raw)

        return Subscription(self._node, message_class, topic, take)

    def _now(self) -> int:
        return int(self._clock.now().nanoseconds)

    def _stop(self) -> object:
        self._drain()
        return self._recorder.stop() or self._recorder.state

    def _drain(self) -> None:
        """Take what waits, the joint states last: they may end the trial."""
        for subscription in reversed(self._subscriptions):
            subscription.drain()


def _declare_weights(parameters: Parameters) -> Callable[[], tuple[Weight, ...]]:
    """Declare which weights are clamped to the rods, from trial to trial; return what tells those that are there now.

    Raises `OptionError` where a value that the user gave is not possible.
    """
    for what in (ADDED, ADDED_STD):
        for rod in RODS:
            text = DESCRIPTIONS[what].format(rod=rod)
            parameters.declare(f"{what}.{rod}", list(NOTHING), text, minimum=0.0, changeable=True)

    def now(changed: Sequence[Any] = ()) -> tuple[Weight, ...]:
        values = {name: list(parameters.get(name)) for name in NAMES}
        values |= {parameter.name: list(parameter.value or ()) for parameter in changed if parameter.name in NAMES}
        # Standard deviations that are all 0 are those of a weight for which none are given.
        given = {name: value for name, value in values.items() if name.startswith(f"{ADDED}.") or any(value)}
        return tuple(weight for weight in weights_of(given, "recorder").values() if weight)

    now()
    parameters.check_changes(now)
    return now


@entry_point
def main(arguments: list[str]) -> int:
    """Run the recorder."""
    parse_arguments(ArgumentParser("recorder", DESCRIPTION, EXAMPLE), arguments)
    return run_node("recorder", RecorderNode, arguments)

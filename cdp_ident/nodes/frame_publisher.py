# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where a simulated motion is shown: the topics of the simulator."""

from typing import Any

from builtin_interfaces.msg import Time
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String

from cdp_ident.configuration.fitted_model import FittedModel
from cdp_ident.replay.observer import Observer
from cdp_ident.replay.scene import Frame
from cdp_ident.rig.joints import Triple
from cdp_ident.ros.joint_state_publisher import JointStatePublisher
from cdp_ident.ros.qos import latched

JOINTS = ("cart_joint", "inner_joint", "outer_joint")


class FramePublisher:
    """Publishes frames and the state."""

    def __init__(self, node: Any, measured: bool, error: bool, clock: bool, velocities: bool) -> None:
        """`measured`, `error` and `clock` say what is published beside the simulated joint states and the state.

        Where `velocities` are wished, joint states have those that the driver would estimate, in the motion's own time.
        """
        self._logger = node.get_logger()
        self._simulated = JointStatePublisher(node, "simulated/joint_states", JOINTS)
        self._measured = JointStatePublisher(node, "measured/joint_states", JOINTS) if measured else None
        self._error = JointStatePublisher(node, "simulated/error", JOINTS[1:]) if error else None
        self._topics = [topic for topic in (self._simulated, self._measured, self._error) if topic]
        self._clock = node.create_publisher(Clock, "/clock", 10) if clock else None
        self._state = node.create_publisher(String, "~/state", latched())
        self._said = ""
        self._has_velocities, self._observers = velocities, dict[JointStatePublisher, Observer]()

    def take_model(self, model: FittedModel) -> None:
        """Estimate velocities by another model from now on, where they are wished."""
        if self._has_velocities:
            self._observers = {topic: Observer(model) for topic in (self._simulated, self._measured) if topic}

    @property
    def has_listeners(self) -> bool:
        """Whether there is somebody who hears every topic of joint states."""
        return all(topic.has_listeners for topic in self._topics)

    def show(self, frame: Frame, stamp_ns: int) -> None:
        """Publish a frame."""
        if self._clock:
            seconds, nanoseconds = divmod(stamp_ns, 1_000_000_000)
            self._clock.publish(Clock(clock=Time(sec=seconds, nanosec=nanoseconds)))
        if self._measured and frame.measured:
            self._publish(self._measured, frame.measured, frame, stamp_ns)
        self._publish(self._simulated, frame.simulated, frame, stamp_ns)
        if self._error and frame.error:
            self._error.publish(frame.error, stamp_ns)

    def _publish(self, topic: JointStatePublisher, positions: Triple, frame: Frame, stamp_ns: int) -> None:
        observer = self._observers.get(topic)
        velocities = observer.update(round(frame.time * 1e9), positions) if observer else ()
        topic.publish(positions, stamp_ns, velocities)

    def say(self, state: str) -> None:
        """Publish and log the state where it has become another."""
        if state != self._said:
            self._said = state
            self._state.publish(String(data=state))
            self._logger.info(state)

    def close(self) -> None:
        """Wait until everything has arrived."""
        for topic in self._topics:
            topic.finish()

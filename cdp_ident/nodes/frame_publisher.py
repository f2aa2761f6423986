"""Where a simulated motion is shown: the topics of the simulator."""

import array
from collections.abc import Sequence
from typing import Any

from builtin_interfaces.msg import Time
from rclpy.duration import Duration
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from cdp_ident.replay.scene import Frame
from cdp_ident.ros.qos import create_publisher, latched

JOINTS = ("cart_joint", "inner_joint", "outer_joint")
_QUEUE_DEPTH = 2000
"""Ten seconds at 200 Hz: what a busy subscriber may be behind without loss."""
_LONGEST_GOODBYE = 2.0
"""How long the last messages are waited for to arrive [s]."""


class FramePublisher:
    """Publishes frames and the state."""

    def __init__(self, node: Any, measured: bool, error: bool, clock: bool) -> None:
        """`measured`, `error` and `clock` say what is published beside the simulated joint states and the state."""
        self._logger = node.get_logger()

        def topic(name: str, joints: Sequence[str]) -> "_JointStates":
            return _JointStates(node, name, joints)

        self._simulated = topic("simulated/joint_states", JOINTS)
        self._measured = topic("measured/joint_states", JOINTS) if measured else None
        self._error = topic("simulated/error", JOINTS[1:]) if error else None
        self._topics = [topic for topic in (self._simulated, self._measured, self._error) if topic]
        self._clock = node.create_publisher(Clock, "/clock", 10) if clock else None
        self._state = node.create_publisher(String, "~/state", latched())
        self._said = ""

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
            self._measured.publish(frame.measured, stamp_ns)
        self._simulated.publish(frame.simulated, stamp_ns)
        if self._error and frame.error:
            self._error.publish(frame.error, stamp_ns)

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


class _JointStates:
    """One topic of JointState messages with positions only."""

    def __init__(self, node: Any, topic: str, joints: Sequence[str]) -> None:
        self._publisher = create_publisher(node, JointState, topic, _QUEUE_DEPTH)
        self._message = JointState(name=list(joints))

    @property
    def has_listeners(self) -> bool:
        return self._publisher.get_subscription_count() > 0

    def publish(self, positions: Sequence[float], stamp_ns: int) -> None:
        stamp = self._message.header.stamp
        stamp.sec, stamp.nanosec = divmod(stamp_ns, 1_000_000_000)
        self._message.position = array.array("d", positions)
        self._publisher.publish(self._message)

    def finish(self) -> None:
        self._publisher.wait_for_all_acked(Duration(seconds=_LONGEST_GOODBYE))

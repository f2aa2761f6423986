# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Publishing joint states as bytes: that takes a third of the time of messages."""

from collections.abc import Sequence
from typing import Any

from rclpy.duration import Duration
from sensor_msgs.msg import JointState

from cdp_ident.bag.joint_state import serialize_joint_state
from cdp_ident.ros.qos import create_publisher

QUEUE_DEPTH = 2000
"""Two seconds at 1 kHz: what a busy subscriber may be behind without loss."""
_LONGEST_GOODBYE = 2.0
"""How long the last messages are waited for to arrive [s]."""


class JointStatePublisher:
    """One topic of JointState messages: positions, and velocities where they are known."""

    def __init__(self, node: Any, topic: str, joints: Sequence[str]) -> None:
        """Publish these joints. Raises `OptionError` where `qos_overrides` make no sense."""
        self._publisher = create_publisher(node, JointState, topic, QUEUE_DEPTH)
        self._joints = tuple(joints)

    @property
    def has_listeners(self) -> bool:
        """Whether there is somebody who hears it."""
        return bool(self._publisher.get_subscription_count())

    def publish(self, positions: Sequence[float], stamp_ns: int, velocities: Sequence[float] = ()) -> None:
        """Publish the positions [m, rad], and velocities or none of them, at a time [ns]."""
        self._publisher.publish(serialize_joint_state(self._joints, positions, stamp_ns, velocities))

    def finish(self) -> None:
        """Wait until everything has arrived, but not for those that take nothing."""
        self._publisher.wait_for_all_acked(Duration(seconds=_LONGEST_GOODBYE))

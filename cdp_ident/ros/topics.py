# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Topics: joint states as bytes, and the quality of service that is asked for and offered, which users change."""

from collections.abc import Callable, Sequence
from typing import Any

from rclpy.duration import Duration
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.exceptions import InvalidParameterTypeException
from rclpy.qos import DurabilityPolicy, QoSPolicyKind, QoSProfile, ReliabilityPolicy
from rclpy.qos_overriding_options import InvalidQosOverridesError, QoSOverridingOptions
from sensor_msgs.msg import JointState

from cdp_ident.bag.joint_state import serialize_joint_state
from cdp_ident.bag.metadata import INFINITE, OFFERED_QOS_PROFILES, QosProfile
from cdp_ident.configuration.parameter_file import QOS_OVERRIDES
from cdp_ident.errors import OptionError

_SIZE = (QoSPolicyKind.HISTORY, QoSPolicyKind.DEPTH)
QUEUE_DEPTH = 2000
"""Two seconds at 1 kHz: what a busy subscriber may be behind without loss."""
_LONGEST_GOODBYE = 2.0
"""How long the last messages are waited for to arrive [s]."""
_DEPTH = 5000
"""Five seconds at 1 kHz: what a subscriber may be behind without loss."""


def latched(depth: int = 1) -> QoSProfile:
    """Return the quality of service of a topic whose last `depth` messages are given to each new subscriber."""
    return QoSProfile(depth=depth, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def create_publisher(node: Any, message_class: type, topic: str, depth: int) -> Any:
    """Return a reliable publisher whose quality of service users can change by `qos_overrides`.

    Raises `OptionError` where what they say makes no sense.
    """
    profile, options = QoSProfile(depth=depth), QoSOverridingOptions((*_SIZE, QoSPolicyKind.RELIABILITY))
    return _checked(topic, lambda: node.create_publisher(message_class, topic, profile, qos_overriding_options=options))


class JointStatePublisher:
    """One topic of JointState messages, published as bytes: that takes a third of the time of messages.

    They have positions, and velocities where these are known.
    """

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


class Subscription:
    """A subscription to serialised messages that hears best-effort publishers too.

    It asks for reliable messages. Where a publisher offers less, it says so and asks for less, unless the user has
    settled that by `qos_overrides`.
    """

    def __init__(self, node: Any, message_class: type, topic: str, callback: Callable[[bytes], None]) -> None:
        """Raises `OptionError` where `qos_overrides` make no sense."""
        self._node, self._class, self._topic, self._callback = node, message_class, topic, callback
        self._profile = QoSProfile(depth=_DEPTH, reliability=ReliabilityPolicy.RELIABLE)
        reliability = f"{QOS_OVERRIDES}{node.resolve_topic_name(topic)}.subscription.reliability"
        self._settled = reliability in node._parameter_overrides  # rclpy has no public way to ask for these
        # A subscription cannot be replaced from within its own event.
        self._adapting = node.create_guard_condition(self._adapt)
        self._subscription = self._subscribe((*_SIZE, QoSPolicyKind.RELIABILITY))

    def drain(self) -> None:
        """Hand on all that waits by now, in the order of arrival; more may arrive meanwhile."""
        for _ in range(self._profile.depth):
            with self._subscription.handle:  # as rclpy's executor takes them
                taken = self._subscription.handle.take_message(self._class, True)
            if taken is None:
                return
            self._callback(taken[0])

    def _subscribe(self, policies: Sequence[QoSPolicyKind]) -> Any:
        return _checked(
            self._topic,
            lambda: self._node.create_subscription(
                self._class,
                self._topic,
                self._callback,
                self._profile,
                raw=True,
                event_callbacks=SubscriptionEventCallbacks(incompatible_qos=self._incompatible),
                qos_overriding_options=QoSOverridingOptions(policies),
            ),
        )

    def _incompatible(self, event: Any) -> None:
        name, logger = self._node.resolve_topic_name(self._topic), self._node.get_logger()
        if event.last_policy_kind == QoSPolicyKind.RELIABILITY and not self._settled:
            self._settled = True
            logger.warning(f"a publisher of {name} does not make sure that its messages arrive: some may be lost")
            self._adapting.trigger()
        else:
            policy = QoSPolicyKind(event.last_policy_kind).name.lower()
            logger.error(f"nothing is heard from a publisher of {name}: it offers less {policy} than is asked for")

    def _adapt(self) -> None:
        self._node.destroy_subscription(self._subscription)
        self._profile.reliability = ReliabilityPolicy.BEST_EFFORT
        self._subscription = self._subscribe(_SIZE)


def offered(node: Any, topic: str) -> Sequence[QosProfile]:
    """Return what the publishers of a topic offer, as rosbag2 writes it; ROS's default where there is none."""
    profiles = [info.qos_profile for info in node.get_publishers_info_by_topic(topic)]
    return [_as_written(profile) for profile in profiles] or OFFERED_QOS_PROFILES


def _as_written(profile: Any) -> QosProfile:
    def duration(name: str) -> dict[str, int]:
        seconds, nanoseconds = divmod(getattr(profile, name).nanoseconds, 1_000_000_000)
        return INFINITE if seconds >= INFINITE["sec"] else {"sec": seconds, "nsec": nanoseconds}

    return {
        "history": profile.history.short_key,
        "depth": profile.depth,
        "reliability": profile.reliability.short_key,
        "durability": profile.durability.short_key,
        "deadline": duration("deadline"),
        "lifespan": duration("lifespan"),
        "liveliness": profile.liveliness.short_key,
        "liveliness_lease_duration": duration("liveliness_lease_duration"),
        "avoid_ros_namespace_conventions": profile.avoid_ros_namespace_conventions,
    }


def _checked(topic: str, make: Callable[[], Any]) -> Any:
    try:
        return make()
    except (InvalidQosOverridesError, InvalidParameterTypeException, RuntimeError, ValueError) as error:
        raise OptionError(f"{QOS_OVERRIDES}{topic}: {error}") from error

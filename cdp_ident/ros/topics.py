"""How topics are kept for who comes late."""

from rclpy.qos import DurabilityPolicy, QoSProfile


def latched(depth: int = 1) -> QoSProfile:
    """Return the quality of service of a topic whose last `depth` messages are given to each new subscriber."""
    return QoSProfile(depth=depth, durability=DurabilityPolicy.TRANSIENT_LOCAL)

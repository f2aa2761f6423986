"""`sensor_msgs/msg/JointState` to and from its bytes on the wire (CDR), without ROS."""

from collections.abc import Sequence
from functools import cache

import numpy as np
from rosbags.typesys import Stores, get_typestore
from rosbags.typesys.store import Typestore

MESSAGE_TYPE = "sensor_msgs/msg/JointState"
NANOSECONDS = 1_000_000_000
"""In a second."""


@cache
def typestore() -> Typestore:
    """Return the message definitions of the ROS distribution that the package is for."""
    return get_typestore(Stores.ROS2_JAZZY)


def serialize_joint_state(names: Sequence[str], positions: Sequence[float], stamp_ns: int) -> bytes:
    """Return the CDR bytes of a JointState.

    `positions` are in rad for revolute joints and m for prismatic ones, one for each of `names`; `stamp_ns` is the
    time of the measurement [ns since the epoch]. Velocity and effort stay empty: encoders do not measure them.
    """
    if len(names) != len(positions):
        raise ValueError(f"{len(names)} names but {len(positions)} positions")
    types = typestore().types
    seconds, nanoseconds = divmod(stamp_ns, NANOSECONDS)
    stamp = types["builtin_interfaces/msg/Time"](sec=seconds, nanosec=nanoseconds)
    empty = np.empty(0)
    message = types[MESSAGE_TYPE](
        header=types["std_msgs/msg/Header"](stamp=stamp, frame_id=""),
        name=list(names),
        position=np.asarray(positions, dtype=np.float64),
        velocity=empty,
        effort=empty,
    )
    return bytes(typestore().serialize_cdr(message, MESSAGE_TYPE))

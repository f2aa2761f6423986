# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""`metadata.yaml` of a rosbag2 folder, in the version that ROS 2 Jazzy writes, and what a recorder wrote into it."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from cdp_ident.outside_text import shown
from cdp_ident.yaml_file import read_yaml

METADATA_FILE = "metadata.yaml"
INFORMATION = "rosbag2_bagfile_information"
"""The one key at the top of the file."""
ROS_DISTRO = "jazzy"
RIG_NAME, UNKNOWN = "rig_name", "unknown"
"""The custom data in which a recorder writes which rig it was, and what it writes where it does not know."""
INFINITE = {"sec": 9223372036, "nsec": 854775807}
_LATEST_NS = 2**63 - 1
_LONGEST_NAME = 200

QosProfile = dict[str, Any]
"""One quality of service, as rosbag2 writes it."""

OFFERED_QOS_PROFILES: Sequence[QosProfile] = [
    {
        "history": "keep_last",
        "depth": 10,
        "reliability": "reliable",
        "durability": "volatile",
        "deadline": INFINITE,
        "lifespan": INFINITE,
        "liveliness": "automatic",
        "liveliness_lease_duration": INFINITE,
        "avoid_ros_namespace_conventions": False,
    }
]
"""What `ros2 bag play` shall offer where nothing else is known: ROS's default profile, for every subscription."""


class _Dumper(yaml.SafeDumper):
    """YAML without anchors: rosbag2 does not need to follow them, and people read the file."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


def dump_yaml(value: object) -> str:
    """Return a value as block-style YAML with its keys in the order given."""
    return yaml.dump(value, Dumper=_Dumper, default_flow_style=False, sort_keys=False, allow_unicode=True)


def read_offered(text: str) -> Sequence[QosProfile]:
    """Return the profiles in a topic's description in an MCAP file; the default where there are none."""
    try:
        offered = yaml.safe_load(text)
    except (yaml.YAMLError, ValueError, RecursionError):
        return OFFERED_QOS_PROFILES
    usable = isinstance(offered, list) and offered and all(isinstance(profile, dict) for profile in offered)
    return offered if usable else OFFERED_QOS_PROFILES


def read_information(bag: Path) -> tuple[dict[str, Any], str]:
    """Return what a bag's `metadata.yaml` holds under `INFORMATION`, and in words why it cannot be read.

    A bag without metadata gives none. Of a single file those of its folder are taken. They may come from anyone: a
    value may be of any type.
    """
    path = (bag if bag.is_dir() else bag.parent) / METADATA_FILE
    if not path.is_file():
        return {}, ""
    try:
        content = read_yaml(path)
    except (OSError, ValueError) as error:
        return {}, f"{METADATA_FILE} cannot be read, so what it says of the trial is not known: {error}"
    information = content.get(INFORMATION) if isinstance(content, dict) else None
    return (information if isinstance(information, dict) else {}), ""


@dataclass(frozen=True)
class Origin:
    """Where and when a bag was recorded, as far as its metadata say."""

    rig: str
    """The name that the recorder wrote; empty where it wrote none."""
    start_ns: int | None
    """Time of the first message [ns since the epoch]."""


def read_custom_data(bag: Path) -> tuple[dict[str, str], str]:
    """Return the custom data of a bag's metadata, and in words why they could not be read, if they are there."""
    information, problem = read_information(bag)
    custom = information.get("custom_data")
    if not isinstance(custom, dict):
        return {}, problem
    return {key: value for key, value in custom.items() if isinstance(key, str) and isinstance(value, str)}, problem


def origin_of(bag: Path) -> Origin:
    """Return the origin of a bag; its name is fit to be shown."""
    name = read_custom_data(bag)[0].get(RIG_NAME, UNKNOWN)
    start = read_information(bag)[0].get("starting_time")
    stamp = start.get("nanoseconds_since_epoch") if isinstance(start, dict) else None
    return Origin(
        shown(name, _LONGEST_NAME) if name != UNKNOWN else "",
        stamp if type(stamp) is int and 0 <= stamp <= _LATEST_NS else None,
    )

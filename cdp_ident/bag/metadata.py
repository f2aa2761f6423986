# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""`metadata.yaml` of a rosbag2 folder, in the version that ROS 2 Jazzy writes, and what a recorder wrote into it."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
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


@dataclass(frozen=True)
class Metadata:
    """What the metadata of a bag say, as far as they do; they may come from anyone: a value may be of any type."""

    information: Mapping[str, Any]
    """What stands under `INFORMATION`; nothing where there are no metadata."""
    problem: str = ""
    """Why they cannot be read, in words."""

    @classmethod
    def of(cls, bag: Path) -> "Metadata":
        """Read those of a bag; of a single file those of its folder are taken."""
        path = (bag if bag.is_dir() else bag.parent) / METADATA_FILE
        try:
            content = read_yaml(path) if path.is_file() else None
        except (OSError, ValueError) as error:
            return cls({}, f"{METADATA_FILE} cannot be read, so what it says of the trial is not known: {error}")
        information = content.get(INFORMATION) if isinstance(content, dict) else None
        return cls(information if isinstance(information, dict) else {})

    @property
    def custom_data(self) -> dict[str, str]:
        """What the recorder wrote beside what all bags have."""
        custom = self.information.get("custom_data")
        pairs = custom.items() if isinstance(custom, dict) else ()
        return {key: value for key, value in pairs if isinstance(key, str) and isinstance(value, str)}

    @cached_property
    def rig(self) -> str:
        """The name of the rig that the recorder wrote, fit to be shown; empty where it wrote none."""
        name = self.custom_data.get(RIG_NAME, UNKNOWN)
        return shown(name, _LONGEST_NAME) if name != UNKNOWN else ""

    @property
    def start_ns(self) -> int | None:
        """Time of the first message [ns since the epoch]."""
        start = self.information.get("starting_time")
        stamp = start.get("nanoseconds_since_epoch") if isinstance(start, dict) else None
        return stamp if type(stamp) is int and 0 <= stamp <= _LATEST_NS else None

    @property
    def paths(self) -> list[Path]:
        """The paths of the bag's files, in its folder."""
        paths = self.information.get("relative_file_paths")
        return [Path(path) for path in paths if isinstance(path, str)] if isinstance(paths, list) else []

    @property
    def files(self) -> set[str]:
        """The names of the bag's files."""
        return {path.name for path in self.paths}

    def count(self, topics: Collection[str]) -> int:
        """Return how many messages of some topics there are; 0 where that is not said."""
        stated = self.information.get("topics_with_message_count") or []
        try:
            return sum(int(of["message_count"]) for of in stated if of["topic_metadata"]["name"] in topics)
        except (TypeError, KeyError, ValueError, OverflowError):
            return 0

"""What a recorder wrote of a trial into the `metadata.yaml` of its bag: where, when, and what else."""

from dataclasses import dataclass
from pathlib import Path

from cdp_ident.bag.metadata import RIG_NAME, UNKNOWN, read_information
from cdp_ident.outside_text import shown

_LATEST_NS = 2**63 - 1
_LONGEST_NAME = 200


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

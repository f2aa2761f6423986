"""Where and when a bag was recorded, from its metadata."""

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


def origin_of(bag: Path) -> Origin:
    """Return the origin of a bag; its name is fit to be shown."""
    information, _ = read_information(bag)
    custom = information.get("custom_data")
    name = custom.get(RIG_NAME) if isinstance(custom, dict) else None
    start = information.get("starting_time")
    stamp = start.get("nanoseconds_since_epoch") if isinstance(start, dict) else None
    return Origin(
        shown(name, _LONGEST_NAME) if isinstance(name, str) and name != UNKNOWN else "",
        stamp if type(stamp) is int and 0 <= stamp <= _LATEST_NS else None,
    )

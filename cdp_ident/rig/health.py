# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How a rig or a node is doing, in the levels of `/diagnostics`."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum


class Level(IntEnum):
    """Levels of a diagnostic status, as REP 107 has them."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


@dataclass(frozen=True)
class Health:
    """What a node reports of itself."""

    level: Level
    message: str
    values: Mapping[str, str]
    hardware_id: str = ""
    """Which device it is about, if any."""

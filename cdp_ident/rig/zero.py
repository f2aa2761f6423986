# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The counts at which the pendulum hangs, kept in a file across restarts of the driver."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from cdp_ident.errors import OptionError, RigError
from cdp_ident.files import write_whole
from cdp_ident.user_input import number
from cdp_ident.yaml_file import read_yaml

_KEYS = ("cart_counts", "inner_counts", "outer_counts", "sequence", "taken_at_ns")
_LARGEST = 2.0**63


@dataclass(frozen=True)
class Zero:
    """Counts at rest, hanging; and when they were taken, to know whether the device has run on since."""

    counts: tuple[float, float, float]
    """Cart, inner, outer; the mean over a second, so not whole numbers."""
    sequence: int
    """Sequence number of the device at that time."""
    taken_at_ns: int
    """Host's time [ns since the epoch]."""

    def is_of_this_run(self, sequence: int, now_ns: int, period_us: int) -> bool:
        """Tell whether the device's sequence number says that it was not reset since the zero was taken."""
        elapsed = (now_ns - self.taken_at_ns) * 1e-9
        counted = (sequence - self.sequence) % 2**32 * period_us * 1e-6
        turn = 2**32 * period_us * 1e-6
        error = (counted - elapsed + turn / 2) % turn - turn / 2
        return elapsed >= -5.0 and abs(error) < 5.0 + 0.01 * elapsed


def load_zero(path: Path) -> Zero | None:
    """Return the zero kept in a file, None where there is no file yet.

    Raises `RigError` where the file is there but is not a zero: guessing would falsify every angle.
    """
    try:
        content: Any = read_yaml(path)
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as error:
        raise RigError(f"the zero kept in {path} cannot be read: {error}; {_REMEDY}") from error
    if not isinstance(content, dict) or set(content) != set(_KEYS):
        raise RigError(f"the zero kept in {path} has not the keys {', '.join(_KEYS)}; {_REMEDY}")
    try:
        cart, inner, outer, *_ = (number(content[key], key, minimum=-_LARGEST, maximum=_LARGEST) for key in _KEYS)
    except OptionError as error:
        raise RigError(f"the zero kept in {path} holds something that is not a number: {error}; {_REMEDY}") from error
    return Zero((cart, inner, outer), int(content["sequence"]), int(content["taken_at_ns"]))


def save_zero(path: Path, zero: Zero) -> None:
    """Keep a zero in a file, which is replaced as a whole. Raises `RigError` where it cannot be written."""
    content = dict(zip(_KEYS, (*zero.counts, zero.sequence, zero.taken_at_ns), strict=True))
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole({path: yaml.safe_dump(content, sort_keys=False).encode()})
    except OSError as error:
        raise RigError(f"the zero cannot be kept in {path}: {error.strerror or error}") from error


_REMEDY = "delete it, let the pendulum hang and call ~/zero_hanging"

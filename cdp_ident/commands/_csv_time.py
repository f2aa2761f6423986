# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""When the rows of a CSV file were measured."""

import argparse
from datetime import datetime, timezone
from pathlib import Path

import numpy as np

from cdp_ident.arrays import Array, Indices
from cdp_ident.bag.csv_file import Table
from cdp_ident.bag.csv_titles import FRAME, TIME, seconds_and_nanoseconds
from cdp_ident.bag.joint_state import NANOSECONDS
from cdp_ident.commands._csv_arguments import TIME_UNITS, unit_in
from cdp_ident.errors import BagError, OptionError
from cdp_ident.trial.order import counted_on

_ABSOLUTE = 1e9
"""Times [s] from here on, which is 2001, are taken as seconds since 1970."""
_LATEST = 2.0**31
"""From here on they are counted from an earlier year, as LabVIEW does [s]: the recording's beginning is not known."""
_DEFAULT_START = datetime(2000, 1, 1, tzinfo=timezone.utc)
_TO_AND_FRO = 0.2
"""Share of steps back in what is no time; one that steps back now and then was set so."""
_LONGEST_STEP, _SHORTEST_STEP = 0.05, 2e-6
"""Steps of a time [s] longer or shorter than these show no swing: the unit is another one."""
_FIRST_OF_1970 = (719529.0, 25569.0)
"""In the days of MATLAB and of spreadsheets."""


def times(table: Table, options: argparse.Namespace, known: dict[str, int]) -> tuple[Array, set[int], str]:
    """Return the time of each row [s], the columns that are used up, and what was taken for it.

    `known` are the columns whose titles tell what they are. Raises CdpIdentError where there is no time.
    """
    count, width = table.values.shape
    counted = {known[FRAME]} if FRAME in known else set()
    if options.rate is not None:
        place = table.place(options.time) if options.time else known.get(FRAME)
        used = counted | ({known[TIME]} if TIME in known else set()) | ({place} if place is not None else set())
        if place is None:
            return np.arange(count) / options.rate, used, f"time from the rows, {options.rate:g} a second"
        said = f"time from frame numbers in {table.name(place)}, {options.rate:g} a second"
        return table.column(place) / options.rate, used, said
    if options.time is None and (stamp := seconds_and_nanoseconds(table.titles)):
        seconds, nanoseconds = (table.column(place) for place in stamp)
        said = f"time from {table.name(stamp[0])} in s and {table.name(stamp[1])} in ns"
        return seconds + 1e-9 * nanoseconds, counted | set(stamp), said
    if options.time is None and TIME not in known and (FRAME in known or width < 3):
        raise OptionError(f"{table.path} has no times: give --rate, or the column of the times by --time")
    place = table.place(options.time) if options.time else known.get(TIME, 0)
    time, counter = counted_on(table.column(place))
    rolls_over = f" ({counter}, counted on where it rolls over)" if counter else ""
    steps = np.diff(time[np.isfinite(time)])
    forth, back = np.count_nonzero(steps > 0), np.count_nonzero(steps < 0)
    # Some logs begin with the newest row, some round their times so that several rows have the same.
    if not forth + back or 0 < min(forth, back) > _TO_AND_FRO * (forth + back):
        raise OptionError(
            f"{table.path}: {table.name(place)} does not increase as times do: name their column by --time, or give "
            "--rate if there is none"
        )
    unit, how = options.time_unit or table.titles[place].unit, ""
    if not unit:
        unit, how = _time_unit(table, steps, place)
    unit_in(TIME_UNITS, unit, table.path, "time")
    if unit == "d":
        time = time - next((day for day in _FIRST_OF_1970 if np.nanmin(time) > day), 0.0)
    return time * TIME_UNITS[unit], counted | {place}, f"time from {table.name(place)} in {unit}{how}{rolls_over}"


def _time_unit(table: Table, steps: Array, place: int) -> tuple[str, str]:
    """Find the unit of a time that states none by its steps."""
    # Of rounded times several are the same.
    step = float(np.median(np.abs(steps[steps != 0.0])) * np.mean(steps != 0.0))
    if step == 1 and np.all(steps == np.round(steps)):
        raise OptionError(
            f"{table.path}: {table.name(place)} counts 1, 2, 3: give --rate if these are frames, or --time-unit"
        )
    if 0.0 < step < _SHORTEST_STEP:
        return "d", f" (not stated: steps of {step:.2g} s would be too short for a log)"
    for unit, factor in TIME_UNITS.items():
        if step * factor <= _LONGEST_STEP:
            return unit, "" if unit == "s" else f" (not stated: steps of {step:.4g} s would be too long for a swing)"
    return "s", ""


def stamps_of(time: Array, path: Path, options: argparse.Namespace) -> Indices:
    """Return the stamp [ns since the epoch] of each of the file's times (n,) [s]."""
    if options.start_stamp is not None:
        origin, base = time[0], options.start_stamp
    else:
        origin = 0.0 if time[0] < _LATEST else time[0]
        base = 0 if _ABSOLUTE <= time[0] < _LATEST else round(_DEFAULT_START.timestamp()) * NANOSECONDS
    if not np.abs(time - origin).max() < 2**62 / NANOSECONDS:
        raise BagError(f"{path}: its times reach {np.abs(time).max():.3g} s: check --time and --time-unit")
    since = np.round((time - origin) * NANOSECONDS).astype(np.int64)
    first, last = base + int(since.min()), base + int(since.max())
    if first <= 0 or last >= 2**31 * NANOSECONDS:
        raise OptionError(
            f"samples would be stamped {first} to {last} ns since 1970: ROS's stamps reach from then to 2038; give "
            "another --start-stamp"
        )
    return base + since

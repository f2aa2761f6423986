# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From a table to the samples of a recording, for `import_csv`: the same that a bag with its numbers gives."""

import argparse
from dataclasses import dataclass, replace
from datetime import datetime, timezone
from pathlib import Path

import numpy as np

from cdp_ident.arrays import Array, Indices
from cdp_ident.bag import csv_titles
from cdp_ident.bag.csv_file import Table
from cdp_ident.bag.csv_titles import CART, FRAME, INNER, OUTER, POINTS, TIME
from cdp_ident.bag.joint_recording import JointRecording
from cdp_ident.bag.joint_state import NANOSECONDS
from cdp_ident.commands.import_csv import ANGLE_UNITS, LENGTH_UNITS, MEANINGS, TIME_UNITS, TypedOptions, unit_in
from cdp_ident.errors import BagError, OptionError
from cdp_ident.trial.conventions import found_units, in_right_ranges
from cdp_ident.trial.film import rods_on_film
from cdp_ident.trial.joints import Samples, in_angles, select_joints
from cdp_ident.trial.options import UNITS, TrialOptions, Unit
from cdp_ident.trial.order import counted_on

_ABSOLUTE = 1e9
"""Times [s] from here on, which is 2001, are taken as seconds since 1970."""
_LATEST = 2.0**31
"""From here on they are counted from an earlier year, as LabVIEW does [s]: the recording's beginning is not known."""
_DEFAULT_START = datetime(2000, 1, 1, tzinfo=timezone.utc)
_TO_AND_FRO = 0.2
"""Share of steps back in what is no time; one that steps back now and then was set so."""
_EVEN = 0.8
"""Share of steps that are usual ones, in times that are out of order."""
_LONGEST_STEP, _SHORTEST_STEP = 0.05, 2e-6
"""Steps of a time [s] longer or shorter than these show no swing: the unit is another one."""
_FIRST_OF_1970 = (719529.0, 25569.0)
"""In the days of MATLAB and of spreadsheets."""
_FEWEST_DEGREES, _MOST_RADIANS = 7.0, 20.0
"""Angles that state no unit are radians if they vary by less, and degrees by more if the motion does not tell."""
_TELLS = 0.3
"""Share of the acceleration that the right unit leaves unexplained at most, be a zero off or the camera lean."""


@dataclass(frozen=True)
class Recording:
    """A table's samples in SI units, with their conventions."""

    samples: Samples
    """Angles are continuous [rad]."""
    meaning: TrialOptions
    length: float | None
    """Between the joints, as given or seen [m]."""
    on_film: bool
    columns: list[str]
    """Which column was taken for what."""
    notes: list[str]
    """What was corrected or left out."""


@dataclass
class _Rows:
    """The numbers of a table's rows, and what is said of them."""

    time: Array
    """(n,) [s]; NaN of rows that may not be used."""
    numbers: Array
    """(n, 3) of the inner and outer rod as recorded, and of the cart [m], NaN where there is none."""
    meaning: TrialOptions
    columns: list[str]
    notes: list[str]
    is_unit_known: bool = True
    """Whether the angles are in radians; else they may be in degrees."""
    length: float | None = None


def recording_of(table: Table, options: argparse.Namespace) -> Recording:
    """Return what stands in a table, by its titles and by what the user says; raises CdpIdentError where that fails."""
    known = csv_titles.roles(table.titles)
    time, used, said = _times(table, options, known)
    columns, cart = [said], None
    if options.cart is not None or CART in known:
        place = known[CART] if options.cart is None else table.place(options.cart)
        factors = LENGTH_UNITS | ({"counts": 1.0 / options.counts_per_metre} if options.counts_per_metre else {})
        unit = unit_in(factors, options.cart_unit or table.titles[place].unit or "m", table.path, "cart")
        cart = factors[unit] * table.column(place)
        columns.append(f"cart from {table.name(place)} in {unit}")
        used = used | {place}
    efforts = _torques(table, columns)
    if points := _points(table, options, known):
        rows = _from_points(table, points, time, cart, options)
    else:
        rows = _from_angles(table, known, used, time, cart, options)
    time = rows.time
    if lost := np.count_nonzero(np.isnan(time) & np.any(np.isfinite(rows.numbers[:, :2]), axis=1)):
        rows.notes.append(f"rows without a time are left out: {lost}")
    wanted = np.flatnonzero(np.isfinite(time) & (time >= options.start) & (time <= options.stop))
    if not len(wanted):
        asked = [f" --{name} {s:g} s" for name, s in (("from", options.start), ("to", options.stop)) if np.isfinite(s)]
        raise BagError(f"{table.path} has no row with a time{''.join(asked)}")
    lean = np.radians(options.lean)
    meaning = replace(
        rows.meaning,
        cart_joint="" if np.all(np.isnan(rows.numbers[:, 2])) else "cart_joint",
        cart_sign=options.cart_sign or 1,
        inner_offset=rows.meaning.inner_offset + lean,
        outer_offset=rows.meaning.outer_offset + lean * (rows.meaning.outer_angle == "absolute"),
    )
    names = (meaning.inner_joint, meaning.outer_joint, "cart_joint")
    if efforts is not None:
        efforts = np.pad(np.resize(efforts, (len(time), 2)), ((0, 0), (0, 1)))[wanted]
    stamps = _stamps_of(time[wanted], table.path, options)
    recording = JointRecording("", str(table.path), names, stamps, rows.numbers[wanted], (), efforts=efforts)
    samples, notes = select_joints(recording, meaning)
    samples = samples[np.arange(0, len(samples.stamps), options.every)]
    if not rows.is_unit_known:
        units, how = _with_units(samples, meaning)
        samples = in_angles(samples, units)
        short = {unit: name for name, unit in ANGLE_UNITS.items()}
        told = [short[unit] for unit in (units.inner_unit, units.outer_unit)]
        rows.columns = [f"{column}{unit} ({how})" for column, unit in zip(rows.columns, told, strict=True)]
    samples = in_right_ranges(samples, meaning)
    samples = replace(samples, angles=samples.unwrapped)
    columns += rows.columns
    length = rows.length or options.length
    return Recording(samples, meaning, length, bool(points), columns, [*table.notes, *rows.notes, *notes])


def _from_angles(
    table: Table, known: dict[str, int], used: set[int], time: Array, cart: Array | None, options: argparse.Namespace
) -> _Rows:
    """Return the rows of a table in which angles stand, each with a time of its own where two stand before them."""
    places: list[int] = []
    for role, column in ((INNER, options.inner), (OUTER, options.outer)):
        if column is not None:
            places.append(table.place(column))
        elif role in known:
            places.append(known[role])
        else:
            places.append(_next_place(table, used.union(places, known.values())))
    if places[0] == places[1]:
        raise OptionError(f"{table.path}: {table.name(places[0])} cannot be both angles: name them by --inner, --outer")
    said = {name: value for name in MEANINGS if (value := getattr(options, name)) is not None}
    said |= {"inner_joint": table.joint(places[0]), "outer_joint": table.joint(places[1])}
    factors, unit = _angle_factors(table, places, options)
    columns = [f"{name} from {table.name(place)} in {unit}" for name, place in zip((INNER, OUTER), places, strict=True)]
    angles = np.column_stack([table.column(place) for place in places]) * factors
    numbers = np.column_stack([angles, np.full(len(angles), np.nan) if cart is None else cart])
    if TIME not in known and options.time is None and options.rate is None:
        before = [csv_titles.time_before(table.titles, place) for place in places]
        given = [argparse.Namespace(**{**vars(options), "time": str(at)}) for at in before if at is not None]
        own = [_times(table, of_joint, {})[0] for of_joint in given]
        if len(own) == len(places) and not np.array_equal(own[0], own[1], equal_nan=True):
            time = np.concatenate(own)
            numbers = np.concatenate([numbers * [1.0, np.nan, 1.0], numbers * [np.nan, 1.0, 1.0]])
    return _Rows(time, numbers, TypedOptions(**said), columns, [], unit != "")


def _from_points(
    table: Table, points: list[int], time: Array, cart: Array | None, options: argparse.Namespace
) -> _Rows:
    """Return the rows of a table whose angles follow from positions in the columns `points`."""
    for name in MEANINGS:
        if getattr(options, name) is not None:
            raise OptionError(f"{TypedOptions().called(name)} does not go with points: what their angles mean is known")
    unit = options.points_unit or next((table.titles[place].unit for place in points if table.titles[place].unit), "px")
    unit_in(("px", *LENGTH_UNITS), unit, table.path, "points")
    y_down = (options.y_axis or ("down" if unit == "px" else "up")) == "down"
    positions = np.stack([table.column(place) for place in points], axis=1)
    film = rods_on_film(positions.reshape(len(positions), -1, 2), y_down)
    markers = ("pivot", "joint", "tip")[-len(points) // 2 :]
    columns = [
        f"{marker} from {table.name(x)} and {table.name(y)} in {unit}, y {'down' if y_down else 'up'}"
        for marker, x, y in zip(markers, points[::2], points[1::2], strict=True)
    ]
    length = film.length * LENGTH_UNITS[unit] if unit in LENGTH_UNITS else options.length
    numbers = np.full((len(film.kept), 3), np.nan)
    numbers[film.kept, :2] = film.angles
    notes = [*film.notes]
    if cart is not None:
        numbers[:, 2] = cart
    elif film.pivot is not None:
        if length is None:
            raise OptionError("the pivot moves: give --length, so that its way is known in metres")
        numbers[film.kept, 2] = film.pivot * length / film.length
        notes.append("the pivot moves: its x is the cart's position")
    time = np.where(film.kept, time, np.nan)
    return _Rows(time, numbers, TypedOptions(outer_angle="absolute"), columns, notes, length=length)


def _next_place(table: Table, used: set[int]) -> int:
    """Return the first column that is not used and may be an angle."""
    left = [
        place for place in csv_titles.may_be_angles(table.titles) if place not in used and place not in table.no_numbers
    ]
    if not left:
        raise BagError(
            f"{table.path}: two angles of rods are needed besides the time, and its titles tell fewer, as those of one "
            "pendulum do: name the columns by --inner and --outer, or of x and y by --points; they are "
            f"{table.columns}"
        )
    return left[0]


def _torques(table: Table, columns: list[str]) -> Array | None:
    """Return the torques of motors in both joints (n, 2) that titles tell, and say so; None where all are zero."""
    for places in csv_titles.torques(table.titles):
        there = {place: csv_titles.torque_unit(table.titles[place]) for place in places if place is not None}
        unknown = np.full(len(table.values), np.nan)
        values = [unknown if place is None else table.values[:, place] * (there[place] or 1.0) for place in places]
        if np.any(np.nan_to_num(values)):
            columns.append(f"torques of motors from {' and '.join(map(table.name, there))}")
            if None in there.values():
                columns.append(
                    "warning: by their titles these are no torques in N m, but taken for such: inertias and masses "
                    "that follow from them are off by as much"
                )
            return np.column_stack(values)
    return None


def _points(table: Table, options: argparse.Namespace, known: dict[str, int]) -> list[int]:
    """Return the columns of x and y of pivot, joint and tip, or of joint and tip; none where there are angles."""
    if options.points:
        return [table.place(column) for column in options.points]
    titled = [known[point] for point in POINTS if point in known]
    whole = len(titled) == 6 or (len(titled) == 4 and not {"pivot_x", "pivot_y"} & set(known))
    if options.points is not None and not whole:
        raise OptionError(
            f"{table.path}: the titles do not tell x and y of pivot, joint and tip: name them after --points"
        )
    has_angles = options.inner or options.outer or INNER in known or OUTER in known
    return titled if whole and (options.points is not None or not has_angles) else []


def _angle_factors(table: Table, places: list[int], options: argparse.Namespace) -> tuple[Array, str]:
    """Return what angles are multiplied with to give radians, and their unit in words; 1 and none if it is not told."""
    if options.angle_unit == "counts":
        counts = options.counts_per_turn
        return 2 * np.pi / np.array([counts[0], counts[-1]]), "counts"
    units = [options.angle_unit or table.titles[place].unit for place in places]
    stated = [unit if unit in ANGLE_UNITS else other for unit, other in zip(units, units[::-1], strict=True)]
    if set(stated) <= set(ANGLE_UNITS):
        return np.array([UNITS[ANGLE_UNITS[unit]] for unit in stated]), " and ".join(dict.fromkeys(stated))
    # In which unit counts are not is no question to the motion: 6000 a turn are nearly milliradians.
    for place, unit in zip(places, units, strict=True):
        values = np.unique(table.column(place)[np.isfinite(table.column(place))])
        if unit == "counts" or (len(values) > 1 and np.all(values == np.round(values))):
            what = "angles in counts" if unit else f"{table.name(place)} has whole numbers without a unit (counts?)"
            raise OptionError(f"{table.path}: {what}: give --angle-unit counts and --counts-per-turn, or their unit")
    return np.ones(2), ""


def _with_units(samples: Samples, meaning: TrialOptions) -> tuple[TrialOptions, str]:
    """Find the units of angles that state none: those in which they move as a pendulum does, else by their size."""
    size = float(np.ptp(samples.angles, axis=0).max())
    found, before = found_units(samples, meaning)
    if size < _FEWEST_DEGREES and found is before:
        return meaning, "not stated: a swing in degrees is wider"
    if found and found.lumped.unexplained < _TELLS:
        how = f"not stated: {found.lumped.unexplained:.1%} of the motion is unexplained in it"
        return replace(meaning, inner_unit=found.meaning.inner_unit, outer_unit=found.meaning.outer_unit), how
    unit: Unit = "degrees" if size > _MOST_RADIANS else "radians"
    return replace(meaning, inner_unit=unit, outer_unit=unit), "not stated: by their size"


def _times(table: Table, options: argparse.Namespace, known: dict[str, int]) -> tuple[Array, set[int], str]:
    """Return the time of each row [s], the columns that it stands in, and what was taken for it.

    `known` are the columns whose titles tell what they are. Raises CdpIdentError where there is no time.
    """
    count, width = table.values.shape
    if options.rate is not None:
        place = table.place(options.time) if options.time else known.get(FRAME)
        if place is None:
            return np.arange(count) / options.rate, set(), f"time from the rows, {options.rate:g} a second"
        said = f"time from frame numbers in {table.name(place)}, {options.rate:g} a second"
        return table.column(place) / options.rate, {place}, said
    if options.time is None and (stamp := csv_titles.seconds_and_nanoseconds(table.titles)):
        seconds, nanoseconds = (table.column(place) for place in stamp)
        said = f"time from {table.name(stamp[0])} in s and {table.name(stamp[1])} in ns"
        return seconds + 1e-9 * nanoseconds, set(stamp), said
    if options.time is None and TIME not in known and (FRAME in known or width < 3):
        raise OptionError(f"{table.path} has no times: give --rate, or the column of the times by --time")
    with_numbers = (place for place in range(width) if place not in table.no_numbers)  # a date may stand before
    place = table.place(options.time) if options.time else known.get(TIME, next(with_numbers, 0))
    time, counter = counted_on(table.column(place))
    rolls_over = f" ({counter}, counted on where it rolls over)" if counter else ""
    steps = np.diff(time[np.isfinite(time)])
    forth, back = np.count_nonzero(steps > 0), np.count_nonzero(steps < 0)
    # Some logs begin with the newest row, some round their times so that several rows have the same, and the rows of
    # some are out of order: in order, their times are even.
    goes_to_and_fro = 0 < min(forth, back) > _TO_AND_FRO * (forth + back)
    if goes_to_and_fro:
        steps = np.diff(np.sort(time[np.isfinite(time)]))
    typical = np.median(steps) if len(steps) else 0.0
    even = np.mean(np.abs(steps - typical) <= 0.5 * typical) if goes_to_and_fro else 1.0
    if not forth + back or even < _EVEN:
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
    return time * TIME_UNITS[unit], {place}, f"time from {table.name(place)} in {unit}{how}{rolls_over}"


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


def _stamps_of(time: Array, path: Path, options: argparse.Namespace) -> Indices:
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

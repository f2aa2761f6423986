"""From a table to a recording, for `import_csv`."""

import argparse
from dataclasses import dataclass, field, replace
from typing import get_args

import numpy as np
import numpy.typing as npt

from cdp_ident.bag.csv_file import Table
from cdp_ident.bag.csv_titles import CART, INNER, OUTER, POINTS, may_be_angles, roles, torques
from cdp_ident.commands._csv_arguments import ANGLE_UNITS, AS_TYPED, LENGTH_UNITS
from cdp_ident.commands._csv_time import times
from cdp_ident.errors import BagError, OptionError, TrialError
from cdp_ident.trial.film import rods_on_film
from cdp_ident.trial.find import rough_balance
from cdp_ident.trial.joints import Samples
from cdp_ident.trial.options import OuterAngle, TrialOptions

Array = npt.NDArray[np.float64]

_FEWEST_DEGREES = 7.0
"""Angles that state no unit and vary by less are radians."""
_MOST_RADIANS = 20.0
"""Angles that state no unit and vary by more are degrees, if the motion does not tell."""
_LONGEST_GAP = 2.5
"""Between rows further apart than so many usual steps of a column, nothing is taken."""
_FAR_BETTER = 0.5
"""Another unit is taken if it leaves at most this share of the unexplained motion."""


@dataclass(frozen=True)
class Recording:
    """A table's numbers in SI units, with their conventions."""

    time: Array
    """(n,) the file's time of each row taken [s]."""
    angles: Array
    """(n, 2) of the inner and outer rod as recorded, maybe wrapped [rad]."""
    cart: Array | None
    """(n,) position of the cart as recorded [m]."""
    torques: Array | None
    """(n, 2) torques of motors in the joints, as recorded; NaN where none is known."""
    meaning: TrialOptions
    length: float | None
    """Between the joints, as given or seen [m]."""
    on_film: bool = False
    columns: list[str] = field(default_factory=list)
    """Which column was taken for what."""
    notes: list[str] = field(default_factory=list)
    """What was corrected or left out."""

    def samples(self) -> Samples:
        """Return the samples, the first at time zero."""
        stamps = np.round((self.time - self.time[0]) * 1e9).astype(np.int64)
        torques = None if self.torques is None else np.nan_to_num(self.torques)
        return Samples(stamps, np.asarray(np.unwrap(self.angles, axis=0)), self.cart, torques)

    def complete(self, options: argparse.Namespace, table: Table) -> "Recording":
        """Return the rows that are complete and wanted; says how many lack a number.

        Where most rows lack one, as each column has rows of its own, the others are taken at the times of the inner
        rod's.
        """
        taken = None if self.on_film else self._on_a_common_time()
        if taken:
            self.notes.append(
                "each column has rows of its own: the others are taken, by straight lines, at the inner rod's times"
            )
        taken = taken or self
        usable = np.isfinite(taken.time) & np.all(np.isfinite(taken.angles), axis=1)
        if taken.cart is not None:
            usable &= np.isfinite(taken.cart)
        if (missing := int(np.count_nonzero(~usable))) and not self.on_film:
            self.notes.append(f"{missing} rows lack a number and are left out")
        usable &= (taken.time >= options.start) & (taken.time <= options.stop)
        rows = np.flatnonzero(usable)[:: options.every]
        if not len(rows):
            asked = [
                f"--{name} {s:g} s" for name, s in (("from", options.start), ("to", options.stop)) if np.isfinite(s)
            ]
            raise BagError(
                f"{table.path} has no row with a time and a number for both rods {' '.join(asked)}: {missing} of "
                f"{len(usable)} rows lack one"
            )
        cart, of_motors = (None if values is None else values[rows] for values in (taken.cart, taken.torques))
        return replace(taken, time=taken.time[rows], angles=taken.angles[rows], cart=cart, torques=of_motors)

    def _on_a_common_time(self) -> "Recording | None":
        """Return the rows that have the inner rod's angle, with the other columns at their times.

        None where most of these are complete. Between rows of a column that are far apart nothing is taken.
        """
        has_time = np.isfinite(self.time)
        rows = np.flatnonzero(has_time & np.isfinite(self.angles[:, 0]))
        needed = self.angles[rows, 1] if self.cart is None else self.angles[rows, 1] + self.cart[rows]
        if not len(rows) or 2 * np.count_nonzero(np.isfinite(needed)) >= len(rows):
            return None

        def taken(column: Array) -> Array:
            return _at(self.time[rows], self.time[has_time], column[has_time])

        return replace(
            self,
            time=self.time[rows],
            angles=np.column_stack([self.angles[rows, 0], taken(self.angles[:, 1])]),
            cart=None if self.cart is None else taken(self.cart),
            torques=None if self.torques is None else np.column_stack([taken(column) for column in self.torques.T]),
        )


def _at(times: Array, at: Array, values: Array) -> Array:
    """Return values (n,) at other times (k,), by straight lines: the nearest at a wrap, NaN far from those known."""
    known = np.isfinite(values)
    at, first = np.unique(at[known], return_index=True)
    values = values[known][first]
    if len(at) < 2:
        return np.full(len(times), np.nan)
    after = np.clip(np.searchsorted(at, times), 1, len(at) - 1)
    before = after - 1
    share = (times - at[before]) / (at[after] - at[before])
    share = np.where(np.abs(values[after] - values[before]) > np.ptp(values) / 2, np.round(share), share)
    taken = values[before] + share * (values[after] - values[before])
    gap, step = at[after] - at[before], np.median(np.diff(at))
    return np.asarray(np.where((gap > _LONGEST_GAP * step) | (share < -0.5) | (share > 1.5), np.nan, taken))


def recording_of(table: Table, options: argparse.Namespace) -> Recording:
    """Return what stands in a table, by its titles and by what the user says; raises CdpIdentError where that fails."""
    known = roles(table.titles)
    time, used, columns = times(table, options, known)
    cart = None
    if options.cart is not None or CART in known:
        place = known[CART] if options.cart is None else table.place(options.cart)
        unit, factor = _cart_factor(table, place, options)
        cart = factor * table.column(place)
        columns.append(f"cart from {table.name(place)} in {unit}")
        used = used | {place}
    of_motors = _torques(table, columns)
    points = _points(table, options, known)
    meaning = TrialOptions(cart_sign=options.cart_sign or 1)
    rows = Recording(
        time, np.empty((len(time), 2)), cart, of_motors, meaning, options.length, columns=columns, notes=[*table.notes]
    )
    return _from_points(rows, table, points, options) if points else _from_angles(rows, table, known, used, options)


def _from_angles(
    rows: Recording, table: Table, known: dict[str, int], used: set[int], options: argparse.Namespace
) -> Recording:
    """Return the recording whose angles stand in the table."""
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
    meaning = replace(
        rows.meaning,
        zero=options.zero or "upright",
        outer_angle=options.outer_angle or "relative",
        inner_sign=options.inner_sign or 1,
        outer_sign=options.outer_sign or 1,
        inner_scale=1.0 if options.inner_scale is None else options.inner_scale,
        outer_scale=1.0 if options.outer_scale is None else options.outer_scale,
    )
    found = replace(rows, angles=np.column_stack([table.column(place) for place in places]), meaning=meaning)
    found = found.complete(options, table)
    factors, unit = _angle_factors(found, table, places, options)
    found.columns.extend(
        f"{name} from {table.name(place)} in {unit}" for name, place in zip((INNER, OUTER), places, strict=True)
    )
    lean = np.radians(options.lean) * np.array([meaning.inner_sign, meaning.outer_sign], dtype=float)
    lean[1] *= meaning.outer_angle == "absolute"
    return replace(found, angles=found.angles * factors + lean)


def _from_points(rows: Recording, table: Table, points: list[int], options: argparse.Namespace) -> Recording:
    """Return the recording whose angles follow from positions in the columns `points`."""
    for name in ("zero", "outer_angle", "inner_sign", "outer_sign", "inner_scale", "outer_scale"):
        if getattr(options, name) is not None:
            raise OptionError(f"{AS_TYPED.name(name)} does not go with points: what their angles mean is known")
    unit = options.points_unit or next((table.unit(place) for place in points if table.unit(place)), "px")
    if unit not in ("px", *LENGTH_UNITS):
        raise OptionError(f"{table.path}: positions in {unit}? Give --points-unit")
    y_down = (options.y_axis or ("down" if unit == "px" else "up")) == "down"
    film = rods_on_film(
        np.stack([table.column(place) for place in points], axis=1).reshape(len(rows.time), -1, 2), y_down
    )
    markers = ("pivot", "joint", "tip")[-len(points) // 2 :]
    rows.columns.extend(
        f"{marker} from {table.name(x)} and {table.name(y)} in {unit}, y {'down' if y_down else 'up'}"
        for marker, x, y in zip(markers, points[::2], points[1::2], strict=True)
    )
    rows.notes.extend(film.notes)
    angles = np.full((len(film.kept), 2), np.nan)
    angles[film.kept] = film.angles + np.radians(options.lean)
    length = film.length * LENGTH_UNITS[unit] if unit in LENGTH_UNITS else options.length
    cart = rows.cart
    if film.pivot is not None and cart is None:
        if length is None:
            raise OptionError("the pivot moves: give --length, so that its way is known in metres")
        cart = np.full(len(film.kept), np.nan)
        cart[film.kept] = film.pivot * length / film.length
        rows.notes.append("the pivot moves: its x is the cart's position")
    meaning = replace(rows.meaning, outer_angle="absolute")
    found = replace(rows, angles=angles, cart=cart, meaning=meaning, length=length, on_film=True)
    return found.complete(options, table)


def _cart_factor(table: Table, place: int, options: argparse.Namespace) -> tuple[str, float]:
    unit = options.cart_unit or table.unit(place) or "m"
    if unit == "counts" and options.counts_per_metre:
        return unit, 1.0 / options.counts_per_metre
    if unit not in LENGTH_UNITS:
        raise OptionError(f"{table.path}: the cart's position is in {unit}: give --cart-unit")
    return unit, LENGTH_UNITS[unit]


def _next_place(table: Table, used: set[int]) -> int:
    """Return the first column that is not used and may be an angle."""
    possible = may_be_angles(table.titles) if table.titles else range(table.values.shape[1])
    left = [place for place in possible if place not in used]
    if not left:
        raise BagError(
            f"{table.path}: two angles of rods are needed besides the time, and its titles tell fewer, as those of one "
            f"pendulum do: name the columns by --inner and --outer; they are {table.columns}"
        )
    return left[0]


def _torques(table: Table, columns: list[str]) -> Array | None:
    """Return the torques of motors in both joints (n, 2) that titles tell, and say so; None where all are zero."""
    for places in torques(table.titles):
        unknown = np.full(len(table.values), np.nan)
        values = np.column_stack([unknown if place is None else table.values[:, place] for place in places])
        if np.any(np.nan_to_num(values)):
            named = [table.name(place) for place in places if place is not None]
            columns.append(f"torques of motors from {' and '.join(named)}")
            return values
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


def _angle_factors(found: Recording, table: Table, places: list[int], options: argparse.Namespace) -> tuple[Array, str]:
    """Return what the angles are multiplied with to give radians, and their unit in words."""
    if options.angle_unit == "counts":
        counts = options.counts_per_turn
        return 2 * np.pi / np.array([counts[0], counts[-1]]), "counts"
    if options.angle_unit:
        return np.full(2, ANGLE_UNITS[options.angle_unit]), options.angle_unit
    units = [table.unit(place) for place in places]
    if units[0] in ANGLE_UNITS or units[1] in ANGLE_UNITS:
        stated = [unit if unit in ANGLE_UNITS else other for unit, other in zip(units, units[::-1], strict=True)]
        return np.array([ANGLE_UNITS[unit] for unit in stated]), " and ".join(dict.fromkeys(stated))
    if "counts" in units:
        raise OptionError(f"{table.path}: angles in counts: give --angle-unit counts and --counts-per-turn")
    unit, how = _angle_unit(found)
    return np.full(2, ANGLE_UNITS[unit]), unit + how


def _angle_unit(found: Recording) -> tuple[str, str]:
    """Find the unit of angles that state none: by their size, or the one in which they move as a pendulum does."""
    size = float(np.ptp(found.angles, axis=0).max())
    if size < _FEWEST_DEGREES:
        return "rad", " (not stated: a swing in degrees is wider)"
    left = {}
    for unit in ("rad", "deg"):
        samples = replace(found, angles=found.angles * ANGLE_UNITS[unit]).samples()
        meanings = [replace(found.meaning, outer_angle=outer_angle) for outer_angle in get_args(OuterAngle)]
        left[unit] = min(_unexplained(samples, meaning) for meaning in meanings)
    for unit, other in (("deg", "rad"), ("rad", "deg")):
        if left[unit] < _FAR_BETTER * left[other]:
            return unit, f" (not stated: {left[unit]:.1%} of the motion is unexplained in it)"
    return ("deg" if size > _MOST_RADIANS else "rad"), " (not stated: by their size)"


def _unexplained(samples: Samples, meaning: TrialOptions) -> float:
    try:
        balance = rough_balance(samples, meaning)
    except TrialError:
        return np.inf
    return balance.lumped.unexplained if balance else np.inf

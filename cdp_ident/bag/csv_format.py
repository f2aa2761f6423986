# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How the rows of a CSV file are written: what parts columns, which sign decimals have, which columns hold numbers."""

import csv
import itertools
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime, timedelta, timezone

import numpy as np

from cdp_ident.bag.csv_titles import is_unit

DELIMITERS = {"\t": "tabs", ";": "semicolons", ",": "commas", " ": "blanks", "|": "bars"}
"""What may part columns, and what it is called."""
_MISSING = {"", "na", "n/a", "nan", "null", "none", "-", "--", "?"}
_NUMERIC = 0.5
"""Share of a column's cells that are numbers where the column is one of numbers."""
_EMPTY = 0.1
"""A column with a smaller share of cells that hold anything is empty: before numbers, no row has one."""
_WITH_UNIT = re.compile(r"(.*\d\.?)\s*([^\W\d]+|°)")
_DATE = re.compile(
    r"(?:(\d{4})-(\d\d)-(\d\d)[T ]|\d+([./])\d+\4\d+ |(\d+) days? )?(?:(\d\d?):)?(\d\d?):(\d\d(?:[.,:]\d+)?)\s*([AP]M)?"
    r"(?:Z|([+-]\d\d):?(\d\d))?",
    re.IGNORECASE,
)


@dataclass(frozen=True)
class Format:
    """How the rows of a file are written."""

    delimiter: str
    decimal: str
    width: int
    """Number of columns."""
    numeric: tuple[int, ...]
    """The columns that hold numbers."""
    empty: tuple[int, ...]
    """Those with next to nothing."""

    @classmethod
    def of(cls, rows: Sequence[str], delimiter: str | None, decimal: str | None) -> "Format | None":
        """Find delimiter, decimal sign and number of columns with which most cells of some rows are numbers.

        None where no cells are.
        """
        best, found = 0.0, None
        for sign, point in itertools.product([delimiter] if delimiter else DELIMITERS, [decimal] if decimal else ".,"):
            cells = [cells_of(line, sign) for line in rows]
            cells = [row for row in cells if any(number_of(cell, point) is not None for cell in row)]
            widths = Counter(len(row) for row in cells)
            width = max(widths, key=lambda w: (widths[w] * w, w), default=0)
            of_width = [row for row in cells if len(row) == width]
            flat = [(cell, number_of(cell, point) is not None) for row in of_width for cell in row]
            # Digits in words, as of decimal commas that are taken for signs between columns, speak against it.
            score = sum(1.0 if known else -2.0 * any(map(str.isdigit, cell)) for cell, known in flat)
            if width > 1 and (found is None or score > best):
                best, found = score, (sign, point, width, of_width)
        if found is None:
            return None
        sign, point, width, of_width = found
        numeric, empty = [], []
        for place, column in enumerate(zip(*of_width, strict=True)):
            there = [number_of(cell, point) is not None for cell in column if not _is_missing(cell)]
            if sum(there) >= max(1.0, _NUMERIC * len(there)):
                numeric.append(place)
            elif len(there) < _EMPTY * len(column):
                empty.append(place)
        return cls(sign, point, width, tuple(numeric), tuple(empty))

    def cells(self, line: str) -> list[str]:
        """Return the cells of a line."""
        return cells_of(line, self.delimiter)

    def row(self, cells: Sequence[str]) -> tuple[list[float], dict[int, str]]:
        """Return the numbers of a row (width,), NaN where there are none, and there the words, empty where missing."""
        try:  # most rows are nothing but numbers
            if self.decimal == "." and len(cells) == self.width:
                return list(map(float, cells)), {}
        except ValueError:
            pass
        whole = [*cells[: self.width], *[""] * (self.width - len(cells))]
        numbers = [number_of(cell, self.decimal) for cell in whole]
        others = {place: cell for place, cell in enumerate(whole) if numbers[place] is None}
        return (
            [np.nan if number is None else number for number in numbers],
            {place: "" if _is_missing(cell) else cell for place, cell in others.items()},
        )

    def is_data(self, others: Mapping[int, str], first: bool) -> bool:
        """Return whether a line is a row of numbers, be a cell of it missing or, behind the `first` one, wrong.

        `others` are its cells that are no numbers.
        """
        numbers = sum(place not in others for place in self.numeric)
        wrong = any(others.get(place) for place in (*self.numeric, *(self.empty if first else ())))
        return numbers > 0 and (not wrong or (not first and 2 * numbers >= len(self.numeric)))


def cells_of(line: str, delimiter: str) -> list[str]:
    """Return the cells of a line, without quotes and blanks around them; a terminal's time stands before an arrow."""
    line = line.replace(" -> ", delimiter)
    if '"' in line:
        with suppress(csv.Error):
            return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))]
    return line.split() if delimiter == " " else [cell.strip() for cell in line.split(delimiter)]


def number_of(cell: str, decimal: str) -> float | None:
    """Return the number in a cell, with a unit or without, or the seconds of a date or time of day; None for none."""
    number = cell.replace(",", ".") if decimal == "," else cell
    try:
        return float(number)
    except ValueError:
        if ":" in cell:
            return _seconds(cell)
    return number_of(cell.removesuffix(unit).rstrip(), decimal) if (unit := unit_behind(cell)) else None


def unit_behind(cell: str) -> str:
    """Return the unit that stands behind the number in a cell; empty where there is none."""
    match = _WITH_UNIT.fullmatch(cell)
    return match[2] if match and is_unit(match[2]) else ""


def _seconds(cell: str) -> float | None:
    """Return a date with a time in seconds since 1970, or a time of day in those since midnight; None for neither."""
    match = _DATE.fullmatch(cell)
    if match is None:
        return None
    # Of other dates the day and the month may be exchanged: their time of day is taken.
    year, month, day, _, days, hour, minute, second, half, zone_hours, zone_minutes = match.groups()
    hours = int(hour or 0) % 12 + 12 * (half.upper() == "PM") if half else int(hour or 0)
    of_day = 86400.0 * int(days or 0) + 3600.0 * hours + 60.0 * int(minute) + float(re.sub("[,:]", ".", second))
    if year is None:
        return of_day
    try:
        date = datetime(int(year), int(month), int(day), tzinfo=timezone.utc)
    except ValueError:
        return None
    zone = timedelta(hours=int(zone_hours or 0), minutes=int(f"{(zone_hours or '+')[0]}{zone_minutes or 0}"))
    return (date - zone).timestamp() + of_day


def _is_missing(cell: str) -> bool:
    return cell.casefold() in _MISSING or cell.startswith("#")

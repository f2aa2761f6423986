"""How the rows of a CSV file are written: what parts columns, which sign decimals have, which columns hold numbers."""

import csv
import re
from array import array
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta, timezone

import numpy as np

DELIMITERS = {"\t": "tabs", ";": "semicolons", ",": "commas", " ": "blanks", "|": "bars"}
"""What may part columns, and what it is called."""
_FORMATS = tuple((sign, decimal) for decimal in (".", ",") for sign in DELIMITERS)
_MISSING = {"", "na", "n/a", "#n/a", "nan", "null", "none", "-", "--", "?"}
_NUMERIC = 0.5
"""Share of a column's cells that are numbers where the column is one of numbers."""
_DATE = re.compile(
    r"(?:(\d{4})-(\d\d)-(\d\d)[T ]|\d+([./])\d+\4\d+ )?(\d\d?):(\d\d):(\d\d(?:[.,]\d+)?)\s*(?:Z|([+-]\d\d):?(\d\d))?",
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

    @classmethod
    def of(cls, rows: Sequence[str], delimiter: str | None, decimal: str | None) -> "Format | None":
        """Find delimiter, decimal sign and number of columns with which most cells of some rows are numbers.

        None where no cells are.
        """
        tried = [form for form in _FORMATS if delimiter in (None, form[0]) and decimal in (None, form[1])]
        if delimiter is not None and not tried:
            tried = [(delimiter, sign) for sign in (".", ",") if decimal in (None, sign)]
        best, found = -np.inf, None
        for sign, point in tried:
            cells = [cells_of(line, sign) for line in rows]
            cells = [row for row in cells if any(number_of(cell, point) is not None for cell in row)]
            widths = Counter(len(row) for row in cells)
            width = max(widths, key=lambda w: (widths[w] * w, w), default=0)
            of_width = [row for row in cells if len(row) == width]
            flat = [cell for row in of_width for cell in row]
            numbers = sum(number_of(cell, point) is not None for cell in flat)
            others = sum(number_of(cell, point) is None and any(letter.isdigit() for letter in cell) for cell in flat)
            if width > 1 and numbers - 2 * others > best:
                best, found = float(numbers - 2 * others), (sign, point, width, of_width)
        if found is None:
            return None
        sign, point, width, of_width = found
        numeric = []
        for place, column in enumerate(zip(*of_width, strict=True)):
            there = [cell for cell in column if not _is_missing(cell)]
            if sum(number_of(cell, point) is not None for cell in there) >= max(1.0, _NUMERIC * len(there)):
                numeric.append(place)
        return cls(sign, point, width, tuple(numeric))

    def cells(self, line: str) -> list[str]:
        """Return the cells of a line."""
        return cells_of(line, self.delimiter)

    def _count(self, cells: Sequence[str]) -> tuple[int, int]:
        """Return how many cells in columns of numbers are numbers, and how many are words."""
        of_numbers = [cells[place] for place in self.numeric if place < len(cells)]
        numbers = sum(number_of(cell, self.decimal) is not None for cell in of_numbers)
        return numbers, len(of_numbers) - numbers - sum(map(_is_missing, of_numbers))

    def plain(self, cells: Sequence[str]) -> list[float]:
        """Return the numbers of a row that has nothing else, as most have; none of another."""
        try:
            return list(map(float, cells)) if self.decimal == "." and len(cells) == self.width else []
        except ValueError:
            return []

    def begins(self, cells: Sequence[str]) -> bool:
        """Return whether these may be the first row of numbers, and no title or a line before it."""
        numbers, words = self._count(cells)
        return len(cells) == self.width and numbers > 0 and not words

    def is_data(self, cells: Sequence[str]) -> bool:
        """Return whether a later line is a row of numbers, be a cell of it missing or wrong."""
        numbers, words = self._count(cells)
        return numbers > 0 and (not words or 2 * numbers >= len(self.numeric))

    def take(
        self, cells: Sequence[str], line: int, values: "array[float]", no_numbers: dict[int, tuple[int, str]]
    ) -> None:
        """Add a row's numbers; what stands behind the last column is left out."""
        for place in range(self.width):
            cell = cells[place] if place < len(cells) else ""
            value = number_of(cell, self.decimal)
            if value is None and place not in no_numbers and not _is_missing(cell):
                no_numbers[place] = (line, cell)
            values.append(np.nan if value is None else value)


def cells_of(line: str, delimiter: str) -> list[str]:
    """Return the cells of a line, without quotes and blanks around them."""
    if '"' in line:
        try:
            return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))]
        except csv.Error:
            pass
    return line.split() if delimiter == " " else [cell.strip() for cell in line.split(delimiter)]


def number_of(cell: str, decimal: str) -> float | None:
    """Return the number in a cell, a date or a time of day in seconds; None where there is none."""
    number = cell.replace(",", ".") if decimal == "," else cell
    try:
        return float(number)
    except ValueError:
        return _seconds(cell) if ":" in cell else None


def _seconds(cell: str) -> float | None:
    """Return a date with a time in seconds since 1970, or a time of day in those since midnight; None for neither."""
    match = _DATE.fullmatch(cell)
    if match is None:
        return None
    # Of other dates the day and the month may be exchanged: their time of day is taken.
    year, month, day, _, hour, minute, second, zone_hours, zone_minutes = match.groups()
    of_day = 3600.0 * int(hour) + 60.0 * int(minute) + float(second.replace(",", "."))
    if year is None:
        return of_day
    try:
        date = datetime(int(year), int(month), int(day), tzinfo=timezone.utc)
    except ValueError:
        return None
    zone = timedelta(hours=int(zone_hours or 0), minutes=int(f"{(zone_hours or '+')[0]}{zone_minutes or 0}"))
    return (date - zone).timestamp() + of_day


def _is_missing(cell: str) -> bool:
    return cell.casefold() in _MISSING

"""Tables of numbers from the CSV file of any laboratory, read as they are found."""

import csv
import gzip
import io
import re
import zlib
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from cdp_ident.bag.csv_titles import Title, is_unit
from cdp_ident.errors import BagError
from cdp_ident.regular_file import read_regular

Array = npt.NDArray[np.float64]
Line = tuple[int, str]
"""Number of a line, counted from 1, and its text."""

_COMMENTS = "#%!"
_FORMATS = tuple((sign, decimal) for decimal in (".", ",") for sign in ("\t", ";", ",", " ", "|"))
_NAMES = {"\t": "tabs", ";": "semicolons", ",": "commas", " ": "blanks", "|": "bars"}
_MISSING = {"", "na", "n/a", "#n/a", "nan", "null", "none", "-", "--", "?"}
_LARGEST = 1 << 28
"""Bytes; an hour at 1 kHz has half of them."""
_LOOKED_AT = 200
"""Lines from which the format is found."""


@dataclass(frozen=True)
class Table:
    """What stands in a CSV file."""

    path: Path
    titles: tuple[Title, ...]
    """Of each column; empty where the file has none."""
    values: Array
    """(n, columns); NaN where a cell is empty or no number."""
    format: str
    """How the file is written, in words."""
    no_numbers: dict[int, tuple[int, str]]
    """Of columns with a cell that is neither a number nor missing: the first one's line and text."""

    def column(self, place: int) -> Array:
        """Return the numbers of a column (n,). Raises BagError where a cell is no number."""
        if place in self.no_numbers:
            line, cell = self.no_numbers[place]
            raise BagError(f"{self.path}, line {line}, column {place}: {cell[:40]!r} is not a number")
        return self.values[:, place]

    def unit(self, place: int) -> str:
        """Return the unit that a column's title states; empty where there is none."""
        return self.titles[place].unit if self.titles else ""

    def name(self, place: int) -> str:
        """Return what a column is called, for people."""
        title = self.titles[place].text if self.titles else ""
        return f"column {title!r}" if title else f"column {place}"

    def place(self, column: str) -> int:
        """Return the number of a column that is named by its title, with or without unit, or by its number from 0.

        Raises BagError where there is none.
        """
        for names in ([title.text for title in self.titles], [title.name for title in self.titles]):
            if names.count(column) == 1:
                return names.index(column)
        width = self.values.shape[1]
        if column in (places := [str(place) for place in range(width)]):
            return places.index(column)
        titles = ", ".join(title.text for title in self.titles)
        there = f"its columns are {titles}" if titles else f"it has {width} columns and no titles"
        raise BagError(f"{self.path} has no column {column!r}: {there} (numbers count from 0)")


def read_table(path: Path, delimiter: str | None = None, decimal: str | None = None) -> Table:
    """Read a CSV file, which may be compressed with gzip.

    Without a `delimiter`, and without a `decimal` sign, they are those with which most of the first cells are numbers;
    several blanks count as one. Titles, and a line of units under them, are found before the first numbers, also
    behind a comment sign (# % !). Other lines there, and comments later, are skipped.

    Raises BagError where the file cannot be read or holds no numbers in columns.
    """
    lines = [(number, line.strip(" \r\n\x0c")) for number, line in enumerate(_text(path).split("\n"), start=1)]
    lines = [(number, line) for number, line in lines if line.strip()]
    if not lines:
        raise BagError(f"{path} is empty: expected a CSV file")
    rows = [line for line in lines if line[1][0] not in _COMMENTS]
    delimiter, decimal, width = _format(path, rows, delimiter, decimal)
    first = next((i for i, (_, line) in enumerate(lines) if _is_data(line, delimiter, decimal, width)), None)
    if first is None:
        raise _no_numbers_in(path, rows)
    titles, where = _titles(lines[:first], delimiter, width)
    values, no_numbers = _numbers([line for line in lines[first:] if line[1][0] not in _COMMENTS], delimiter, decimal)
    written = (
        f"{len(values)} rows of {values.shape[1]} columns parted by {_NAMES.get(delimiter, repr(delimiter))}, "
        f"decimal {'commas' if decimal == ',' else 'points'}, {f'titles in line {where}' if titles else 'no titles'}"
    )
    if values.shape[1] > len(titles):
        titles = (*titles, *(Title("", "", "") for _ in range(values.shape[1] - len(titles)))) if titles else ()
    return Table(path, titles, values, written, no_numbers)


def _text(path: Path) -> str:
    try:
        content = read_regular(path, _LARGEST)
        if content[:2] == b"\x1f\x8b":
            with gzip.open(io.BytesIO(content)) as stream:
                content = stream.read(_LARGEST + 1)
            if len(content) > _LARGEST:
                raise BagError(f"{path} unfolds to more than {_LARGEST} bytes: it is not read as CSV")
        if content[:2] in (b"\xff\xfe", b"\xfe\xff"):
            return content.decode("utf-16")
        try:
            return content.decode("utf-8-sig")
        except UnicodeDecodeError:
            # What spreadsheets of western Europe write: it has the degree sign, and gives every byte a meaning.
            return content.decode("latin-1")
    except (OSError, EOFError, UnicodeDecodeError, zlib.error) as error:
        raise BagError(f"{path} cannot be read as CSV: {error}") from error


def _format(path: Path, rows: Sequence[Line], delimiter: str | None, decimal: str | None) -> tuple[str, str, int]:
    """Return delimiter, decimal sign and number of columns with which most cells are numbers."""
    tried = [form for form in _FORMATS if delimiter in (None, form[0]) and decimal in (None, form[1])]
    if delimiter is not None and not tried:
        tried = [(delimiter, sign) for sign in (".", ",") if decimal in (None, sign)]
    looked_at = [line for _, line in rows[:_LOOKED_AT]]
    best, found = -np.inf, None
    for sign, point in tried:
        cells = [_cells(line, sign) for line in looked_at]
        cells = [row for row in cells if any(_number(cell, point) is not None for cell in row)]
        widths = Counter(len(row) for row in cells)
        width = max(widths, key=lambda w: (widths[w] * w, w), default=0)
        of_width = [cell for row in cells for cell in row if len(row) == width]
        numbers = sum(_number(cell, point) is not None for cell in of_width)
        others = sum(_number(cell, point) is None and any(letter.isdigit() for letter in cell) for cell in of_width)
        if width > 1 and numbers - 2 * others > best:
            best, found = float(numbers - 2 * others), (sign, point, width)
    if found is None:
        raise _no_numbers_in(path, rows)
    return found


def _no_numbers_in(path: Path, rows: Sequence[Line]) -> BagError:
    if not rows:
        return BagError(f"{path} has comments but no numbers")
    return BagError(f"{path} has no numbers in columns; its first line is {rows[0][1][:60]!r}")


def _cells(line: str, delimiter: str) -> list[str]:
    if '"' in line:
        try:
            return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))]
        except csv.Error:
            pass
    return line.split() if delimiter == " " else [cell.strip() for cell in line.split(delimiter)]


def _number(cell: str, decimal: str) -> float | None:
    if decimal == ",":
        cell = cell.replace(",", ".")
    try:
        return float(cell)
    except ValueError:
        return None


def _is_missing(cell: str) -> bool:
    return cell.casefold() in _MISSING


def _is_data(line: str, delimiter: str, decimal: str, width: int) -> bool:
    cells = _cells(line, delimiter)
    numbers = sum(_number(cell, decimal) is not None for cell in cells)
    missing = sum(_is_missing(cell) for cell in cells)
    return line[0] not in _COMMENTS and len(cells) == width and numbers > 0 and 2 * (numbers + missing) >= width


def _titles(before: Sequence[Line], delimiter: str, width: int) -> tuple[tuple[Title, ...], int]:
    """Return the titles that stand before the numbers, nearest to them, and in which line."""
    units: list[str] = [""] * width
    for number, line in reversed(before):
        cells = _title_cells(line.lstrip(_COMMENTS).strip(), delimiter, width)
        if cells is None:
            continue
        if all(is_unit(cell) for cell in cells if cell) and not any(units):
            units = cells
            continue
        titles = (Title.of(cell, unit) for cell, unit in zip(cells, units, strict=True))
        return tuple(titles), number
    return ((), 0) if not any(units) else (tuple(Title("", "", unit) for unit in units), 0)


def _title_cells(line: str, delimiter: str, width: int) -> list[str] | None:
    """Return as many titles as there are columns, whichever sign parts them; None if the line holds no titles."""
    for sign in (delimiter, *_NAMES):
        # A blank before a unit parts no columns.
        cells = _cells(re.sub(r"\s+(?=[\[(])", "", line) if sign == " " else line, sign)
        cells = cells[:width] if len(cells) == width + 1 and not cells[-1] else cells
        if len(cells) == width and any(cells) and all(_number(cell, ".") is None for cell in cells):
            return cells
    return None


def _numbers(rows: Sequence[Line], delimiter: str, decimal: str) -> tuple[Array, dict[int, tuple[int, str]]]:
    no_numbers: dict[int, tuple[int, str]] = {}
    table = []
    for line, text in rows:
        row = []
        for place, cell in enumerate(_cells(text, delimiter)):
            value = _number(cell, decimal)
            if value is None and not _is_missing(cell):
                no_numbers.setdefault(place, (line, cell))
            row.append(np.nan if value is None else value)
        table.append(row)
    values = np.full((len(table), max(len(row) for row in table)), np.nan)
    for i, row in enumerate(table):
        values[i, : len(row)] = row
    return values, no_numbers

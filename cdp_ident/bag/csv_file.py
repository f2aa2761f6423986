"""Columns of numbers from the CSV file of any laboratory."""

import csv
import gzip
import zlib
from collections.abc import Iterator, Sequence
from itertools import chain
from pathlib import Path

import numpy as np
import numpy.typing as npt

from cdp_ident.errors import BagError

_COMMENTS = ("#", "%")
_DELIMITERS = ("\t", ";", ",", " ")


def read_columns(
    path: Path, columns: Sequence[str], delimiter: str | None = None, decimal: str = "."
) -> npt.NDArray[np.float64]:
    """Return the columns named (n, columns) of a CSV file, which may be compressed with gzip.

    A column is named by its title in the first line, or by its number, counted from 0. Empty cells become NaN. Lines
    that begin with # or % are skipped. Without a `delimiter` it is the first of tab, semicolon, comma and blank that
    the first line holds; several blanks count as one.

    Raises BagError where the file cannot be read, a column is not there or a cell is no number.
    """
    try:
        with gzip.open(path, "rt", encoding="utf-8-sig") if _is_gzip(path) else path.open(encoding="utf-8-sig") as text:
            return _parse(path, text, columns, delimiter, decimal)
    except (OSError, EOFError, UnicodeDecodeError, zlib.error, csv.Error) as error:
        raise BagError(f"{path} cannot be read as CSV: {error}") from error


def _parse(
    path: Path, text: Iterator[str], columns: Sequence[str], delimiter: str | None, decimal: str
) -> npt.NDArray[np.float64]:
    lines = ((number, line.strip()) for number, line in enumerate(text, start=1))
    filled = ((number, line) for number, line in lines if line and not line.startswith(_COMMENTS))
    first = next(filled, None)
    if first is None:
        raise BagError(f"{path} is empty: expected a CSV file")
    delimiter = delimiter or next((sign for sign in _DELIMITERS if sign in first[1]), ",")
    numbers: list[int] = []

    def numbered() -> Iterator[str]:
        for number, line in chain([first], filled):
            numbers.append(number)
            yield line

    rows = csv.reader(numbered(), delimiter=delimiter, skipinitialspace=True)
    head = [cell.strip() for cell in next(rows)]
    is_title = any(cell and not _is_number(cell, decimal) for cell in head)
    places = [_place(path, column, head if is_title else [], len(head)) for column in columns]
    table = [] if is_title else [[_number(path, numbers[-1], head, place, decimal) for place in places]]
    table += [[_number(path, numbers[-1], row, place, decimal) for place in places] for row in rows]
    if not table:
        raise BagError(f"{path} has titles but no numbers")
    return np.array(table, dtype=np.float64)


def _place(path: Path, column: str, titles: list[str], width: int) -> int:
    if column in titles:
        return titles.index(column)
    if column.isdecimal() and int(column) < width:
        return int(column)
    there = f"its columns are {', '.join(titles)}" if titles else f"it has {width} columns and no titles"
    raise BagError(f"{path} has no column {column!r}: {there} (numbers count from 0)")


def _number(path: Path, line: int, row: list[str], place: int, decimal: str) -> float:
    cell = row[place].strip() if place < len(row) else ""
    try:
        return float(cell.replace(decimal, ".")) if cell else np.nan
    except ValueError as error:
        raise BagError(f"{path}, line {line}, column {place}: {cell[:40]!r} is not a number") from error


def _is_number(cell: str, decimal: str) -> bool:
    try:
        float(cell.replace(decimal, "."))
    except ValueError:
        return False
    return True


def _is_gzip(path: Path) -> bool:
    with path.open("rb") as stream:
        return stream.read(2) == b"\x1f\x8b"

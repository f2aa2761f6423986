# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Tables of numbers from the CSV file of any laboratory, read as they are found."""

import csv
import gzip
import io
import itertools
import math
import re
import zlib
from array import array
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime, timedelta, timezone
from pathlib import Path

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.bag.csv_titles import Title, is_unit, titles_of_echo
from cdp_ident.bag.mcap_scan import ROS1, ROS1_MAGIC
from cdp_ident.errors import BagError
from cdp_ident.files import read_regular
from cdp_ident.outside_text import shown

Line = tuple[int, str]
"""Number of a line, counted from 1, and its text."""

_COMMENTS = "#%!"
_REGISTER = re.compile(r"0x[0-9a-f]|\w:\d", re.IGNORECASE)
"""What is no title but a device's word for how it starts, `clk_drv:0x00` or `clock div:1`."""
_UNITS_ROW = re.compile("unit|einheit", re.IGNORECASE)
"""What a row of units may be called in its first cell."""
_KEY = re.compile(r"""[ \t,;{]*["']?([^\W\d]\w*)["']?[ \t]*[:=][ \t]*(?=["']?[-+.\d])""")
"""What stands before each number in rows that name them."""
_LARGEST = 1 << 28
"""Bytes; an hour at 1 kHz has half of them."""
_LONGEST_LINE = 1 << 16
"""Letters: more than a thousand columns."""
_MOST_CELLS = 1 << 26
"""Half a gigabyte of numbers."""
_LOOKED_AT, _LETTERS = 200, 1 << 18
"""Lines, and letters of them at most, from which the format is found."""
_IN_MATLAB = "there, `writematrix([ts.Time ts.Data], 'swing.csv')` makes a CSV file of a timeseries"
_OTHERS = {
    ROS1_MAGIC: ROS1,
    b"MATLAB": f"a file of MATLAB: {_IN_MATLAB}; without it, `scipy.io.loadmat` of Python reads plain arrays",
    b"\x89HDF": f"a file of MATLAB 7.3 (HDF5): {_IN_MATLAB}",
    rb"(?s).{0,200}header:\r?\n": "what `ros2 topic echo` prints: with --csv it prints a table",
    b"PK\x03\x04": "a spreadsheet or an archive: save the sheet as CSV",
}
"""What files that are no tables begin with, and what to do with them."""


_DELIMITERS = {"\t": "tabs", ";": "semicolons", ",": "commas", " ": "blanks", "|": "bars"}
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
_BASIC_DATE = re.compile(r"(\d{4})(\d\d)(\d\d)[T ](\d\d)(\d\d)(\d\d)(?!\d)")


@dataclass(frozen=True)
class Table:
    """What stands in a CSV file."""

    path: Path
    titles: tuple[Title, ...]
    """Of each column, without words where the file has none."""
    values: Array
    """(n, columns); NaN where a cell is empty or no number."""
    format: str
    """How the file is written, in words."""
    no_numbers: dict[int, tuple[int, str]]
    """Of columns with a cell that is neither a number nor missing: the first one's line and text."""
    notes: tuple[str, ...] = ()
    """What was left out, in words."""

    def column(self, place: int) -> Array:
        """Return the numbers of a column (n,). Raises BagError where a cell is no number."""
        if place in self.no_numbers:
            line, cell = self.no_numbers[place]
            raise BagError(f"{self.path}, line {line}, column {place}: {cell[:40]!r} is not a number")
        return self.values[:, place]

    def joint(self, place: int) -> str:
        """Return what a joint is called whose angle stands in a column, and the column by its user."""
        texts = [title.text for title in self.titles]
        return texts[place] if texts[place] and texts.count(texts[place]) == 1 else str(place)

    def name(self, place: int) -> str:
        """Return what a column is called, for people."""
        return f"column {self.titles[place].text!r}" if self.titles[place].text else f"column {place}"

    def place(self, column: str) -> int:
        """Return the number of a column that is named by its title, with or without unit, or by its number from 0.

        Raises BagError where there is none.
        """
        for names in ([title.text for title in self.titles], [title.name for title in self.titles]):
            if names.count(column) == 1:
                return names.index(column)
        if column in (places := [str(place) for place in range(len(self.titles))]):
            return places.index(column)
        raise BagError(f"{self.path} has no column {column!r}: its columns are {self.columns} (numbers count from 0)")

    @property
    def columns(self) -> str:
        """Which columns there are, for people."""
        texts = [title.text for title in self.titles]
        return shown(", ".join(texts)) if any(texts) else f"{len(texts)} without titles"


def read_table(path: Path, delimiter: str | None = None, decimal: str | None = None) -> Table:
    """Read a CSV file, which may be compressed with gzip.

    Without a `delimiter`, and without a `decimal` sign, they are those with which most of the first cells are numbers;
    several blanks count as one. Titles, and a line of units under them, are found before the first numbers, also
    behind a comment sign (# % !). Other lines there, and comments later, are skipped; later lines of words, such as a
    second header, are counted, too, as is one row of numbers before titles. Behind titles that stand there again in
    another order, columns are taken in that. A word among numbers is a missing reading,
    unless it has digits. Dates and times of day are numbers: seconds, since 1970 or midnight. What
    `ros2 topic echo --csv` writes of joint states has the joints' names as titles.

    It takes memory of about three times the file's size.

    Raises BagError where the file cannot be read or holds no numbers in columns.
    """
    text = _text(path).replace("\u2212", "-")
    keys = _keys(text)
    text = _KEY.sub(",", text).replace("}", "") if keys else text
    rows = ((number, line) for number, line in _lines(path, text) if line[0] not in _COMMENTS)
    looked_at = list(itertools.islice(rows, _LOOKED_AT))
    letters = itertools.accumulate(len(line) for _, line in looked_at)
    few = [line for (_, line), so_far in zip(looked_at, letters, strict=True) if so_far <= _LETTERS]
    form = _Format.of(few, delimiter, decimal)
    if form is None:
        raise _no_numbers_in(path, looked_at)
    before, units = list[Line](), list[str]()
    values, no_numbers, stray, missing, first = array("d"), dict[int, tuple[int, str]](), list[Line](), list[Line](), 0
    titles, where, turned, order = tuple[Title, ...](), 0, list[str](), [*range(form.width)]
    as_titled = order
    for number, line in _lines(path, text):
        is_comment = line[0] in _COMMENTS
        cells = [] if is_comment else _cells_of(line, form.delimiter)
        if order is not as_titled and len(cells) == form.width:
            cells = [cells[place] for place in order]
        row, others = form.row(cells)
        if (first or len(cells) == form.width) and not is_comment and (not others or form.is_data(others, not first)):
            if not first:
                first, units = number, [_unit_behind(cell) for cell in cells]
                titles, where = _titles(before, form.delimiter, units)
            values.extend(row)
            for place, cell in others.items():
                if cell and place in form.numeric and not any(map(str.isdigit, cell)):
                    missing.append((number, cell))
                elif cell:
                    no_numbers.setdefault(place, (number, cell))
        elif not first:
            before = [*before[1 - _LOOKED_AT :], (number, line)]
        elif again := _again(path, (number, line), titles, (where, dict(before).get(where, "")), form.delimiter):
            if again != [*order]:
                turned.append(f"from line {number} on, columns are taken in the order that it tells")
            order = again
            stray += [] if is_comment else [(number, line)]
        elif not is_comment:
            if not stray and len(values) == form.width and not where:
                # Titles may follow: the one row was of numbers in a preamble.
                stray.append((first, " ".join(map(str, values))))
                before.append((number, line))
                del values[:]
                first = 0
            else:
                stray.append((number, line))
        if len(values) > min(_MOST_CELLS, form.width + len(text)):
            what = f"more than {_MOST_CELLS} numbers" if len(values) > _MOST_CELLS else "rows shorter than most others"
            raise BagError(f"{path} has {what}: cut the swing out of it")
    if not first:
        raise _no_numbers_in(path, before)
    table = np.frombuffer(values).reshape(-1, form.width)
    titles = titles if where else titles_of_echo(table[:1000], no_numbers) or titles
    if keys and len(keys) + 1 == form.width:
        titles = tuple(map(Title.of, ("", *keys)))
    named = "joints by their names" if any(title.text for title in titles) else "no titles"
    written = (
        f"{len(table)} rows of {form.width} columns parted by {_DELIMITERS.get(form.delimiter, repr(form.delimiter))}, "
        f"decimal {'commas' if form.decimal == ',' else 'points'}, "
        f"{f'titles in line {where}' if where else named}"
    )
    told = (("lines that are no rows are left out", stray), ("words in place of numbers are missing readings", missing))
    notes = [f"{what}: {len(of)}, first line {of[0][0]}, {shown(of[0][1], 60)!r}" for what, of in told if of]
    return Table(path, titles, table, written, no_numbers, (*notes, *turned))


def _text(path: Path) -> str:
    try:
        content = read_regular(path, _LARGEST)
        for beginning, what in _OTHERS.items():
            if re.match(beginning, content):
                raise BagError(f"{path} is {what.format(path=path)}")
        if content[:2] == b"\x1f\x8b":
            with gzip.open(io.BytesIO(content)) as stream:
                content = stream.read(_LARGEST + 1)
            if len(content) > _LARGEST:
                raise BagError(f"{path} unfolds to more than {_LARGEST} bytes: it is not read as CSV")
        if content[:2] in (b"\xff\xfe", b"\xfe\xff") or content[1:2] == b"\0":
            return content.decode("utf-16" if content[1:2] != b"\0" else "utf-16-le")
        try:
            return content.decode("utf-8-sig")
        except UnicodeDecodeError:
            # What spreadsheets of western Europe write: it has the degree sign, and gives every byte a meaning.
            return content.decode("latin-1")
    except (OSError, EOFError, UnicodeDecodeError, zlib.error) as error:
        raise BagError(f"{path} cannot be read as CSV: {error}") from error


def _lines(path: Path, text: str) -> Iterator[Line]:
    """Yield the lines that are not blank; no copy of the text is made."""
    for number, line in enumerate(re.finditer(r"[^\r\n]*(?:\r\n?|\n|$)", text), start=1):
        if line.end() - line.start() > _LONGEST_LINE:
            raise BagError(f"{path}, line {number} has more than {_LONGEST_LINE} letters: it is no row of a table")
        if line[0].strip():
            yield number, line[0].strip(" \r\n\x0c")


def _no_numbers_in(path: Path, rows: Sequence[Line]) -> BagError:
    if not rows:
        return BagError(f"{path} is empty or has comments but no numbers: expected a CSV file")
    return BagError(f"{path} has no numbers in columns; its first line is {rows[0][1][:60]!r}")


def _titles(before: Sequence[Line], delimiter: str, units: list[str]) -> tuple[tuple[Title, ...], int]:
    """Return the titles that stand before the numbers, nearest to them, and in which line; without words if in none.

    Titles that stand there twice, as x and y of several points, belong to what stands above them. `units` stand behind
    the numbers of each column.
    """
    width = len(units)
    for place, (number, line) in reversed([*enumerate(before)]):
        cells = _title_cells(line, delimiter, width)
        if cells is None:
            continue
        if not any(units) and all(is_unit(cell) for cell in cells if cell and not _UNITS_ROW.search(cell)):
            units = ["" if _UNITS_ROW.search(cell) else cell for cell in cells]
            continue
        if place and len(set(cells)) < width:
            above = _title_cells(before[place - 1][1], delimiter, width) or [""] * width
            groups: Iterator[str] = itertools.accumulate(above, lambda last, group: group or last)
            cells = [f"{group} {cell}".strip() for group, cell in zip(groups, cells, strict=True)]
        titles = (Title.of(cell, unit) for cell, unit in zip(cells, units, strict=True))
        return tuple(titles), number
    return tuple(Title.of("", unit) for unit in units), 0


def _again(path: Path, line: Line, titles: Sequence[Title], header: Line, delimiter: str) -> list[int]:
    """Return in which order columns stand behind a later line of titles; none where the line has no titles.

    `titles` are those of a line before the numbers, the `header`. Raises BagError where there are others, or units.
    """
    number, text = line
    cells = _cells_of(re.sub(rf"^[{_COMMENTS}]+\s*", "", text), delimiter)
    if text == header[1]:
        return [*range(len(titles))]
    texts = [title.text for title in titles]
    if sorted(cells) == sorted({*texts}):
        return [cells.index(text) for text in texts]
    if not any(texts) or any(_number_of(cell, ".") is not None for cell in cells):
        return []
    here, known = [Title.of(cell) for cell in cells], {title.key for title in titles if title.key}
    other_units = all(map(is_unit, cells)) and [Title.of("", cell).unit for cell in cells] != [of.unit for of in titles]
    if other_units or 2 * sum(title.key in known for title in here) >= len(here):
        what = f"line {number} has other titles than line {header[0]}: {shown(text, 60)!r}"
        raise BagError(f"{path}, {what}; part the file there")
    return []


def _title_cells(line: str, delimiter: str, width: int) -> list[str] | None:
    """Return as many titles as there are columns, whichever sign parts them; None if the line holds no titles."""
    line = re.sub("^.* -> ", delimiter, re.sub(rf"^[{_COMMENTS}]+\s*", "", line))
    if _REGISTER.search(line):
        return None
    for sign in (delimiter, *_DELIMITERS):
        # A blank before a unit parts no columns.
        cells = _cells_of(re.sub(r"\s+(?=[\[(])", "", line) if sign == " " else line, sign)
        cells = cells[:width] if len(cells) == width + 1 and not cells[-1] else cells
        if len(cells) == width and any(cells) and all(_number_of(cell, ".") is None for cell in cells):
            return cells
    return None


def _keys(text: str) -> list[str]:
    """Return what each number is called in rows as `t=0.1 a=2.5` or `{"t": 0.1, "a": 2.5}`; none for other rows."""
    line = text[:_LETTERS].rpartition("\n")[0].rstrip().rpartition("\n")[2]
    cells = _KEY.sub(",", line).strip(" ,;}").split(",")
    is_named = len(cells) > 1 and all(_number_of(cell.strip(), ".") is not None for cell in cells)
    return _KEY.findall(line) if is_named else []


@dataclass(frozen=True)
class _Format:
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
    def of(cls, rows: Sequence[str], delimiter: str | None, decimal: str | None) -> "_Format | None":
        """Find delimiter, decimal sign and number of columns with which most cells of some rows are numbers.

        None where no cells are.
        """
        best, found = 0.0, None
        for sign, point in itertools.product([delimiter] if delimiter else _DELIMITERS, [decimal] if decimal else ".,"):
            cells = [_cells_of(line, sign) for line in rows]
            cells = [row for row in cells if any(_number_of(cell, point) is not None for cell in row)]
            widths = Counter(len(row) for row in cells)
            # How many rows there are counts for more than how wide one is.
            width = max(widths, key=lambda w: (widths[w] * math.log(w), w), default=0)
            of_width = [row for row in cells if len(row) == width]
            flat = [(cell, _number_of(cell, point) is not None) for row in of_width for cell in row]
            # Digits in words, as of decimal commas that are taken for signs between columns, speak against it.
            score = sum(1.0 if known else -2.0 * any(map(str.isdigit, cell)) for cell, known in flat)
            if width > 1 and (found is None or score > best):
                best, found = score, (sign, point, width, of_width)
        if found is None:
            return None
        sign, point, width, of_width = found
        numeric, empty = [], []
        for place, column in enumerate(zip(*of_width, strict=True)):
            there = [_number_of(cell, point) is not None for cell in column if not _is_missing(cell)]
            if sum(there) >= max(1.0, _NUMERIC * len(there)):
                numeric.append(place)
            elif len(there) < _EMPTY * len(column):
                empty.append(place)
        return cls(sign, point, width, tuple(numeric), tuple(empty))

    def row(self, cells: Sequence[str]) -> tuple[list[float], dict[int, str]]:
        """Return the numbers of a row (width,), NaN where there are none, and there the words, empty where missing."""
        try:  # most rows are nothing but numbers
            if self.decimal == "." and len(cells) == self.width:
                return list(map(float, cells)), {}
        except ValueError:
            pass
        whole = [*cells[: self.width], *[""] * (self.width - len(cells))]
        numbers = [_number_of(cell, self.decimal) for cell in whole]
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


def _cells_of(line: str, delimiter: str) -> list[str]:
    """Return the cells of a line, without quotes and blanks around them; a terminal's time stands before an arrow."""
    line = line.replace(" -> ", delimiter)
    if '"' in line:
        with suppress(csv.Error):
            return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))]
    return line.split() if delimiter == " " else [cell.strip() for cell in line.split(delimiter)]


def _number_of(cell: str, decimal: str) -> float | None:
    """Return the number in a cell, with a unit or without, or the seconds of a date or time of day; None for none."""
    number = cell.replace(",", ".") if decimal == "," else cell
    try:
        return float(number)
    except ValueError:
        if ":" in (cell := _BASIC_DATE.sub(r"\1-\2-\3T\4:\5:\6", cell)):
            return _seconds(cell)
    return _number_of(cell.removesuffix(unit).rstrip(), decimal) if (unit := _unit_behind(cell)) else None


def _unit_behind(cell: str) -> str:
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
    return cell.casefold() in _MISSING or "#" in cell  # as #N/A of spreadsheets and 1.#QNAN

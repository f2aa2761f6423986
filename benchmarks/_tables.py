# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Tables of results, once for the terminal and once for the page."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from rich.console import Group
from rich.table import Table as TerminalTable
from rich.text import Text


@dataclass(frozen=True)
class Table:
    """What a benchmark found, in words and rounded numbers."""

    title: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    notes: str = ""
    """What must be known to read it, in sentences."""

    def __post_init__(self) -> None:
        """Refuse a row that does not fit under the columns."""
        for row in self.rows:
            if len(row) != len(self.columns):
                raise ValueError(
                    f"{self.title}: a row has {len(row)} cells, there are {len(self.columns)} columns: {row}"
                )

    def for_terminal(self) -> Group:
        """Return it as rich prints it."""
        table = TerminalTable()
        for column in self.columns:
            table.add_column(Text(column))  # a plain string's [s] would be a style
        for row in self.rows:
            table.add_row(*map(Text, row))
        return Group(Text(self.title, style="bold"), table, Text(f"{self.notes}\n"))

    def as_markdown(self) -> str:
        """Return it as a part of a page, its title a heading."""
        lines = [self.columns, ["---"] * len(self.columns), *self.rows]
        body = "\n".join(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in line)} |" for line in lines)
        return "\n\n".join(part for part in (f"### {self.title}", body, self.notes) if part)


def number(value: float, digits: int = 2) -> str:
    """Return a number with so many significant digits, its thousands apart; a very small one with its power."""
    rounded = float(f"{value:.{digits - 1}e}")
    if 0.0 < abs(rounded) < 1e-3:
        return f"{rounded:.{digits - 1}e}"
    order = math.floor(math.log10(abs(rounded))) if rounded else 0
    return f"{rounded:,.{max(0, digits - 1 - order)}f}".replace(",", " ")


def whole(value: float) -> str:
    """Return a number without decimals, its thousands apart."""
    return f"{value:,.0f}".replace(",", " ")

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A pendulum's swing as a table of text."""

from collections.abc import Sequence

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.model.motions import simulate
from cdp_ident.model.parameters import NOMINAL, physical_coefficients


def swing(
    length: float = 0.4, rate: float = 200.0, seconds: float = 4.0, start: tuple[float, float] = (2.0, 2.5)
) -> tuple[Array, Array]:
    """Return times (n,) [s] and absolute angles from upright (n, 2) [rad] of Table 2's pendulum at another size."""
    size = length / NOMINAL["L"]
    of_size = np.array([1, 1, 1 / size, size**-0.5, size**-0.5, size, 1])
    coefficients = physical_coefficients({**NOMINAL, "c1": 0.002, "c2": 0.0005}) * of_size
    time = np.arange(round(seconds * rate)) / rate
    return time, simulate(coefficients, np.array([*start, 0, 0]), time)[:, :2]


def text_of(
    columns: Sequence[Array], title: str = "t,a,b,c", delimiter: str = ",", decimal: str = ".", digits: int = 9
) -> str:
    """Return columns of numbers as a table of text, under as many titles as it has columns."""
    table = np.column_stack(columns)
    head = delimiter.join(title.split(",")[: table.shape[1]]) + "\n" if title else ""
    rows = (delimiter.join(f"{value:.{digits}f}".replace(".", decimal) for value in row) for row in table.tolist())
    return head + "\n".join(rows) + "\n"

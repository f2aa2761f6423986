# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The scales of rigs of 0.05 to 2 m, and what following them costs: nothing that was chosen for one of 0.4 m.

For each case it prints the scales in the rig's unit of time, and what thinning changes: the error of A23, A33 and a1
over A22 with all samples and with fewer.
"""

import itertools
from collections.abc import Sequence

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks.balance import GRAVITY, Case
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.force_balance import Pieces, balance_of_forces
from cdp_ident.fit.scales import scales_of
from cdp_ident.fit.thinning import thinned

LENGTHS = (0.05, 0.4, 2.0)
RATES = (60.0, 200.0, 2000.0)
DURATIONS = (2.0, 20.0, 600.0)
NOISES = (1e-5, 1e-3, 1e-2)
STARTS = ("small", "wide", "whirling")


def sweep(cases: Sequence[Case]) -> Table:
    """Return a table with a row for each case; times are in the rig's units."""
    table = Table(
        "start", r"L \[m]", "Hz", "s", "mrad", "step", "window", "together", "error of all [%]", "of fewer [%]",
    )  # fmt: skip
    for case in cases:
        trial, unit = case.trial(), case.unit
        known = (case.start, f"{case.length:g}", f"{case.rate:g}", f"{case.duration:g}", f"{1e3 * case.noise:g}")
        try:
            scales = scales_of([trial], case.length, GRAVITY)
            fewer = thinned(trial, scales.together)
            errors = [
                f"{100 * float(np.max(np.abs(balance.groups[:3] / case.truth[:3] - 1))):.3f}"
                for balance in (balance_of_forces(Pieces.of([of], case.length, GRAVITY)) for of in (trial, fewer))
            ]
        except IdentificationError as error:
            table.add_row(*known, str(error))
            continue
        table.add_row(
            *known, f"{scales.step / unit:.4f}", f"{scales.window / unit:.2f}", str(scales.together), *errors,
        )  # fmt: skip
    return table


def cases(rates: Sequence[float] = RATES, durations: Sequence[float] = DURATIONS) -> list[Case]:
    """Return the sweep; ten minutes are taken at the lowest rate and one noise alone, for they take long."""
    return [
        Case("viscous", start, length, rate, duration, noise)
        for start, length, rate, duration, noise in itertools.product(STARTS, LENGTHS, rates, durations, NOISES)
        if duration < 600.0 or (rate == RATES[0] and noise == NOISES[1] and start == "wide")
    ]


def main() -> None:
    Console().print(sweep(cases()))


if __name__ == "__main__":
    main()

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The balance of forces: how near it comes to the truth on rigs of 0.05 to 2 m, sticking ones among them.

`python -m benchmarks.balance` takes some minutes.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import numpy.typing as npt
from rich.console import Console
from rich.table import Table
from scipy.interpolate import CubicHermiteSpline

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.force_balance import ForceBalance, Pieces, balance_of_forces
from cdp_ident.trial.trial import Trial
from reference.own_units import Rig, motion

Array = npt.NDArray[np.float64]

GRAVITY = 9.81
LENGTHS = (0.05, 0.4, 2.0)
RATES = (60.0, 2000.0)
DURATIONS = (2.0, 20.0, 600.0)
NOISES = (1e-5, 1e-3, 1e-2)
STARTS = {
    "wide": np.array([2.0, 2.6, 0.0, 0.0]),
    "small": np.array([3.7, 2.5, 0.0, 0.0]),
    "whirling": np.array([0.24, 0.3, 0.0, 0.0]),
}
"""Both angles [rad] and their speeds; the last goes over the top."""
PLAIN = Rig(A23=0.5, A33=0.4, a1=1.4, c1=0.004, c2=0.002)
RIGS = {
    "viscous": PLAIN,
    "dry outer": replace(PLAIN, dry2=0.01),
    "sticking": replace(PLAIN, dry1=0.02, dry2=0.03),
}
TABLES = (450.0, 3000.0, 8500.0)
"""How long motions are tabulated, in the rig's unit of time; the last is more than 10 min of the smallest rig."""
STEP = 0.02
"""Of the table of a motion, in the rig's unit of time: between its entries cubics are good to a microradian."""


@dataclass(frozen=True)
class Case:
    """One rig, measured in one way."""

    rig: str
    start: str
    length: float
    rate: float
    duration: float
    noise: float

    @property
    def unit(self) -> float:
        """The rig's unit of time [s]."""
        return float(np.sqrt(self.length / GRAVITY))

    @property
    def truth(self) -> Array:
        """(5,) its base parameters in SI units, then both torques of dry friction over A22."""
        r, u = RIGS[self.rig], self.unit
        return np.array([r.A23, r.A33, r.a1 / self.length, r.c1 / u, r.c2 / u, r.dry1 / u**2, r.dry2 / u**2])

    def trial(self, seed: int = 0) -> Trial:
        """Measure it."""
        clock = np.arange(round(self.duration * self.rate)) / self.rate
        until = next(until for until in TABLES if until > self.duration / self.unit)
        theta = moved(self.rig, self.start, until)(clock / self.unit)
        return Trial("case", clock, theta + np.random.default_rng(seed).normal(scale=self.noise, size=theta.shape))


@cache
def moved(rig: str, start: str, until: float) -> CubicHermiteSpline:
    """Return the angles (2,) of a motion as a function of time, in the rig's units."""
    clock: Array = np.asarray(np.linspace(0.0, until, round(until / STEP) + 1), dtype=float)
    states = motion(RIGS[rig], STARTS[start], clock, tolerance=1e-8)
    return CubicHermiteSpline(clock, states[:, :2], states[:, 2:])


def found(case: Case) -> ForceBalance | None:
    """Return the balance of a case, or None where it says that there is too little motion."""
    try:
        return balance_of_forces(Pieces.of([case.trial()], case.length, GRAVITY))
    except IdentificationError:
        return None


def sweep(cases: Sequence[Case]) -> Table:
    """Return a table with a row for each case: errors of A23, A33 and a1 over A22 in per cent, friction in units."""
    table = Table(
        "rig", r"L \[m]", "Hz", "s", "mrad", "units", "A23, A33, a1 [%]", "c1, c2, dry1, dry2", "true", "left"
    )
    for case in cases:
        result, truth, unit = found(case), case.truth, case.unit
        known = (case.rig, f"{case.length:g}", f"{case.rate:g}", f"{case.duration:g}", f"{1e3 * case.noise:g}")
        in_units = np.array([unit, unit, unit**2, unit**2])
        if result is None:
            table.add_row(*known, f"{case.duration / unit:.0f}", "too little motion")
            continue
        table.add_row(
            *known,
            f"{case.duration / unit:.0f}",
            " ".join(f"{100 * error:+.2f}" for error in result.groups[:3] / truth[:3] - 1),
            " ".join(f"{value:.4f}" for value in np.array([*result.groups[3:], *result.dry_friction]) * in_units),
            " ".join(f"{value:.3f}" for value in truth[3:] * in_units),
            " ".join(f"{share:.4f}" for share in result.unexplained),
        )
    return table


def cases(rates: Sequence[float] = RATES, durations: Sequence[float] = DURATIONS) -> list[Case]:
    """Return the sweep; ten minutes are taken at the lowest rate and one noise alone, for they take long."""
    return [
        Case(rig, "wide", length, rate, duration, noise)
        for rig, length, rate, duration, noise in itertools.product(RIGS, LENGTHS, rates, durations, NOISES)
        if duration < 600.0 or (rate == RATES[0] and noise == NOISES[1])
    ]


def main() -> None:
    Console().print(sweep(cases()))


if __name__ == "__main__":
    main()

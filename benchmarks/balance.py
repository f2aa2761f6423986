"""The balance of forces: how near it comes to the truth on rigs of 0.05 to 2 m, sticking ones among them.

Every 60th of the sweep by default; `python -m benchmarks.balance --all` takes all of it.
"""

import argparse
import itertools
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import numpy.typing as npt
from rich.console import Console
from rich.table import Table

from cdp_ident.errors import CdpIdentError
from cdp_ident.fit.force_balance import balance_of_forces
from cdp_ident.trial.trial import Trial
from reference.sticking import Rig, motion

Array = npt.NDArray[np.float64]

GRAVITY = 9.81
LENGTHS = (0.05, 0.17, 0.4, 2.0)
RATES = (60.0, 200.0, 1000.0, 2000.0)
DURATIONS = (2.0, 10.0, 60.0, 600.0)
NOISES = (1e-5, 1e-4, 1e-3, 1e-2)
STARTS = {"wide": np.array([2.0, 2.6, 0.0, 0.0]), "small": np.array([3.7, 2.5, 0.0, 0.0])}
PLAIN = Rig(A23=0.5, A33=0.4, a1=1.4, c1=0.004, c2=0.002)
RIGS = {
    "viscous": PLAIN,
    "dry outer": replace(PLAIN, dry2=0.01),
    "sticking": replace(PLAIN, dry1=0.02, dry2=0.03),
}
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
        """(5,) its groups in SI units, then both torques of dry friction over A22."""
        r, u = RIGS[self.rig], self.unit
        return np.array([r.A23, r.A33, r.a1 / self.length, r.c1 / u, r.c2 / u, r.dry1 / u**2, r.dry2 / u**2])

    def trial(self, seed: int = 0) -> Trial:
        """Measure it."""
        clock = np.arange(0.0, self.duration, 1.0 / self.rate)
        theta = moved(self.rig, self.start)(clock / self.unit)
        return Trial("case", clock, theta + np.random.default_rng(seed).normal(scale=self.noise, size=theta.shape))


@cache
def moved(rig: str, start: str, until: float = 3000.0):  # type: ignore[no-untyped-def]
    """Return the angles of a motion as a function of time, in the rig's units."""
    from scipy.interpolate import CubicHermiteSpline  # noqa: PLC0415

    clock = np.arange(0.0, until, STEP)
    states = motion(RIGS[rig], STARTS[start], clock, tolerance=1e-8)
    return CubicHermiteSpline(clock, states[:, :2], states[:, 2:])

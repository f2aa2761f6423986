# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rigs of 0.05 to 2 m, 60 to 2000 Hz, 2 s to 10 min and noise of 0.01 to 10 mrad: the whole identification of each.

Each rig is one recording, of which `identify` knows L, g and nominal values that are off by up to 30 %. For each case
it prints what came of it, whether the true base parameters are in their intervals, which dry friction was named, the
error over the noise, and the processor time. `python -m benchmarks.rigs` takes all of the design (a central composite
one: a half fraction of the corners, the middles of the faces, and as many rigs drawn at random); within
`python -m benchmarks` it is cut short.
"""

import argparse
import itertools
import sys
import time
import traceback
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks._workers import each
from benchmarks.balance import GRAVITY, PLAIN, RIGS, STARTS, Case
from cdp_ident.errors import CdpIdentError
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.fit.prior import Prior
from cdp_ident.model.parameters import GROUPS
from cdp_ident.pipeline.identify import identify
from cdp_ident.tracing.trace import Trace, trace
from cdp_ident.trial.find import find_trial
from cdp_ident.trial.joints import Samples
from cdp_ident.trial.options import TrialOptions
from cdp_ident.trial.trial import Trial

RANGES = ((0.05, 2.0), (60.0, 2000.0), (2.0, 600.0), (1e-5, 1e-2))
"""L [m], samples a second [Hz], duration [s] and noise of the angles [rad]."""
DRAWN = 8
NOMINAL_ERROR = 0.3
WITHIN = 1.96
"""Standard deviations to either side of a 95 % interval."""
_OUTER_CENTRE, _OF_POINT_MASS = 0.7, 0.8
"""l2 over L of the rigs, and m1 l1^2 over m1 l1^2 + J1: the rest of their physical values follows from these and
`PLAIN`, A22 being 1 kg L^2."""


@dataclass(frozen=True)
class Result:
    """What came of a case."""

    case: Case
    outcome: str
    """"fitted", or why there is no result, or why the fit failed."""
    deviations: tuple[float, ...] = ()
    """(5,) errors of the base parameters, in their standard deviations."""
    largest_std: float = np.nan
    """Of A23, A33 and a1 over A22, relative: how well they are determined."""
    named: tuple[str, ...] = ()
    """Effects that were named, or named as probable."""
    before: float = np.nan
    """Error over the motion that was held out, without effects, over the noise."""
    after: float = np.nan
    """The same with the effects."""
    remains: bool = False
    """Whether more than noise is said to remain."""
    seconds: float = np.nan
    """Processor time."""

    @property
    def row(self) -> list[str]:
        """All of it in words."""
        case = self.case
        known = [case.rig, case.start, *(f"{v:.3g}" for v in (case.length, case.rate, case.duration))]
        known.append(f"{1e3 * case.noise:.2g}")
        if not self.deviations:
            return [*known, self.outcome, "", "", "", "", f"{self.seconds:.0f}"]
        inside = sum(abs(deviation) < WITHIN for deviation in self.deviations)
        worst = max(map(abs, self.deviations))
        remains = ", more remains" if self.remains else ""
        return [
            *known, self.outcome, f"{inside} of {len(self.deviations)} ({worst:.1f})", f"{100 * self.largest_std:.2g}",
            ", ".join(self.named) or "nothing", f"{self.before:.2f} -> {self.after:.2f}{remains}",
            f"{self.seconds:.0f}",
        ]  # fmt: skip


def physical(case: Case) -> dict[str, float]:
    """Return the rig's physical values in SI units, but for its dry friction."""
    r, size, unit = PLAIN, case.length, case.unit
    m2 = r.A23 / _OUTER_CENTRE
    own = (1.0 - m2) * _OF_POINT_MASS
    l1 = own / (r.a1 - m2)
    m1 = own / l1**2
    return {
        "m1": m1, "m2": m2, "m0": 0.0, "l1": l1 * size, "l2": _OUTER_CENTRE * size,
        "J1": (1.0 - m2 - own) * size**2, "J2": (r.A33 - m2 * _OUTER_CENTRE**2) * size**2,
        "c1": r.c1 * size**2 / unit, "c2": r.c2 * size**2 / unit, "L": size, "g": GRAVITY,
    }  # fmt: skip


def nominal(case: Case, rng: np.random.Generator) -> dict[str, float]:
    """Return L, g and what a user would think of the rest, which is off."""
    return {
        symbol: value if symbol in ("L", "g") else value * rng.uniform(1.0 - NOMINAL_ERROR, 1.0 + NOMINAL_ERROR)
        for symbol, value in physical(case).items()
    }


def examine(case: Case) -> Result:
    """Record a rig and identify it, as `identify` does."""
    measured = case.trial()
    begin = time.process_time()
    try:
        trial = _found(measured)
        options = IdentifyOptions(prior=Prior(nominal=nominal(case, np.random.default_rng(1))))
        result = _compared(case, trace(identify([trial], [], options)))
    except CdpIdentError as error:
        return Result(case, f"refused: {error}", seconds=time.process_time() - begin)
    except Exception:  # noqa: BLE001 - whatever happens to one rig, the others go on
        return Result(case, f"CRASHED: {traceback.format_exc().splitlines()[-1]}")
    return Result(**{**vars(result), "seconds": time.process_time() - begin})


def _found(measured: Trial) -> Trial:
    """Return the trial that is found in a recording of the joints."""
    stamps = np.round(1e9 * measured.time).astype(np.int64) + 1_700_000_000_000_000_000
    samples = Samples(stamps, np.column_stack([measured.theta[:, 0], np.diff(measured.theta, axis=1)[:, 0]]), None)
    return find_trial(samples, TrialOptions()).trial


def _compared(case: Case, found: Trace) -> Result:
    if found.failure:
        return Result(case, f"failed: {found.failure}")
    count = len(GROUPS)
    values, stds = found.completed.fit.values[:count], np.sqrt(np.diag(found.covariance)[:count])
    keys = [e.active.effect.key for e in found.effects if e.certainty != "acts_like"]
    return Result(
        case,
        "fitted",
        tuple(((values - case.truth[:count]) / stds).tolist()),
        float(np.max(stds[:3] / case.truth[:3])),
        tuple(keys),
        found.before.holdout.rmse() / case.noise,
        found.after.holdout.rmse() / case.noise,
        found.unexplained.significant,
    )


def design() -> list[Case]:
    """Return the rigs; kinds of friction and of starts take turns."""
    low, high = np.log(RANGES).T
    corners = [signs for signs in itertools.product((-1.0, 1.0), repeat=4) if np.prod(signs) > 0.0]
    faces = [sign * axis for axis in np.eye(4) for sign in (-1.0, 1.0)]
    drawn = np.random.default_rng(0).uniform(-1.0, 1.0, (DRAWN, 4))
    points = np.exp((low + high) / 2 + np.array([*corners, *faces, *drawn]) * (high - low) / 2)
    kinds = itertools.cycle(itertools.product(STARTS, RIGS))
    return [Case(rig, start, *map(float, point)) for point, (start, rig) in zip(points, kinds, strict=False)]


def table(results: Sequence[Result]) -> Table:
    """Return a table with a row for each rig."""
    shown = Table(
        "friction", "start", "L [m]", "Hz", "s", "mrad", "outcome", "in their intervals (worst)", "known to [%]",
        "named", "error / noise", "CPU [s]",
    )  # fmt: skip
    for result in results:
        shown.add_row(*result.row)
    return shown


def run(cases: Sequence[Case], jobs: int, limit: float) -> None:
    """Examine rigs in processes of one core each; one that takes longer [s] is given up."""
    results = []
    for result in each(examine, cases, jobs, limit, lambda case, why: Result(case, f"given up: {why}")):
        results.append(result)
        print(" | ".join(result.row), flush=True)
    order = {case: place for place, case in enumerate(cases)}
    Console(width=None if sys.stdout.isatty() else 200).print(table(sorted(results, key=lambda r: order[r.case])))


def short() -> None:
    """Take three rigs that take seconds."""
    run([design()[k] for k in (12, 16, 20)], 2, 600.0)


def main(arguments: Sequence[str] = ()) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.rigs")
    parser.add_argument("--jobs", type=int, default=2, help="processes, of one core each")
    parser.add_argument("--limit", type=float, default=3600.0, help="a rig that takes longer is given up [s]")
    parser.add_argument("--only", default="", help="numbers of rigs of the design, from 0 on, with commas")
    options = parser.parse_args(arguments)
    cases = design()
    run([cases[int(k)] for k in options.only.split(",")] if options.only else cases, options.jobs, options.limit)


if __name__ == "__main__":
    main(sys.argv[1:])

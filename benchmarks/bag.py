# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From a bag to parameters.

What `identify` does, beside what a competent user would write. Bags of an emulated rig with Table 5's values, encoders
of 8000 counts and nothing hidden: 14 s of free swing from rest, another start in each. All begin with Table 2's
estimates and with the trial that this package finds in the bag, and fit the state at its beginning, too. The motion is
chaotic, so that nobody follows it as a whole at once. CasADi with IPOPT and scipy's `least_squares` shoot at windows
that have to meet. `mujoco.sysid` takes sequences of one second from filtered states, as its manual has it, then a
single one that grows to the whole swing.
"""

import functools
import math
import statistics
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks import _mujoco, _multiple_shooting
from benchmarks._alternatives import LOWER, UPPER
from benchmarks._tables import Table, number
from benchmarks._workers import LIMIT, each
from benchmarks.efficiency import Motion, bound
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.machine.parallel import core_count
from cdp_ident.model.parameters import GROUPS, SYMBOLS, groups_of
from cdp_ident.pipeline.identify import identify
from cdp_ident.tracing.trace import trace
from cdp_ident.trial.load import load_trial
from cdp_ident.trial.trial import Trial
from reference.pendulum import TABLE_2, TABLE_5, Array
from scenarios.clean_bags import write_clean_bag
from scenarios.start_given import PRIOR

BAGS = 5
SWING = 14.0
"""How long each swings [s]."""


def _groups(chromosome: Array) -> Array:
    return groups_of(chromosome, PRIOR.length)


Job = tuple[str, Path, tuple[float, float]]
"""A way, a bag, and where its pendulum is let go: theta1 and theta2 [rad]."""
_EMPTY = ("",) * 5
TRUTH, BEGIN = (_groups(np.array([table[symbol] for symbol in SYMBOLS])) for table in (TABLE_5, TABLE_2))


def by_identify(trial: Trial) -> Array:
    """Return the base parameters (5,) by this package, the paper's model."""
    return identify([trial], [], IdentifyOptions()).fit.values[: len(GROUPS)]


def by_tracing(trial: Trial) -> Array:
    """Return them by this package, effects looked for."""
    return trace(identify([trial], [], IdentifyOptions())).completed.fit.values[: len(GROUPS)]


def by_mujoco(trial: Trial) -> Array:
    """Return them by `mujoco.sysid`."""
    states = _multiple_shooting.filtered(trial.time, trial.theta)
    return _groups(_mujoco.identify_swing(trial.time, trial.theta, states, TABLE_2, LOWER, UPPER))


def by_casadi(trial: Trial) -> Array:
    """Return them by CasADi with IPOPT."""
    return _multiple_shooting.by_casadi(trial.time, trial.theta, BEGIN)


def by_scipy(trial: Trial) -> Array:
    """Return them by scipy's `least_squares`."""
    return _multiple_shooting.by_scipy(trial.time, trial.theta, BEGIN)


OURS: dict[str, Callable[[Trial], Array]] = {
    "this package: the paper's model": by_identify,
    "this package: the same, and effects looked for": by_tracing,
}
ALTERNATIVES: dict[str, tuple[Callable[[Trial], Array], bool]] = {
    "CasADi and IPOPT, multiple shooting": (by_casadi, _multiple_shooting.has_casadi()),
    "scipy `least_squares`, multiple shooting": (by_scipy, True),
    "`mujoco.sysid`, sequences, then one that grows": (by_mujoco, _mujoco.can_identify()),
}
"""And whether they are installed."""
WAYS = OURS | {name: way for name, (way, installed) in ALTERNATIVES.items() if installed}


@dataclass(frozen=True)
class Result:
    """What came of a bag by one way."""

    way: str
    errors: Sequence[float] = ()
    """Of A23, A33, a1 over A22, the largest, and of the frictions, the larger: relative to the truth."""
    over_bound: float = 0.0
    """Mean square of the five errors, each over the least standard deviation that its base parameter can have."""
    seconds: float = 0.0
    """CPU time, from the bag on."""
    failure: str = ""


def tables(quick: bool = False) -> list[Table]:
    """Identify from each bag by all ways, as many at a time as there are cores, each on one; two bags are quick."""
    with tempfile.TemporaryDirectory() as folder:
        jobs = []
        for count in range(2 if quick else BAGS):
            bag, start = Path(folder) / f"swing_{count}", (2.2 - 0.05 * count, 2.0 + 0.07 * count)
            write_clean_bag(bag, start, TABLE_5, SWING)
            jobs += [(way, bag, start) for way in WAYS]
        return [table_of(list(each(identified, jobs, core_count(), LIMIT, _failed)))]


def identified(job: Job) -> Result:
    """Identify from a bag by one way."""
    way, bag, start = job
    _warm_up(bag)
    begin = time.process_time()
    groups = WAYS[way](load_trial(bag))
    seconds = time.process_time() - begin
    errors = np.abs(groups / TRUTH - 1.0)
    over_bound = float(np.mean(((groups - TRUTH) / _bound(start)) ** 2))
    return Result(way, (float(errors[:3].max()), float(errors[3:].max())), over_bound, seconds)


_bound = functools.cache(lambda start: bound(Motion(start)))


@functools.cache
def _warm_up(bag: Path) -> None:
    """Have all compiled code of this process loaded, which is not to be timed."""
    by_tracing(load_trial(bag))


def _failed(job: Job, why: str) -> Result:
    return Result(job[0], failure=why)


def table_of(results: Sequence[Result]) -> Table:
    """Return medians by way, and what they are to this package's."""
    shortest, rows = 0.0, []
    for way in WAYS:
        of_it = [result for result in results if result.way == way]
        done = [result for result in of_it if not result.failure]
        if not done:
            rows.append((way, of_it[0].failure, *_EMPTY))
            continue
        seconds = statistics.median(result.seconds for result in done)
        shortest = shortest or seconds
        of_groups, of_friction = np.array([result.errors for result in done]).T
        rows.append(
            (
                way,
                f"{100 * statistics.median(of_groups):.2g} %",
                f"{100 * max(of_groups):.2g} %",
                f"{100 * statistics.median(of_friction):.2g} %",
                number(math.sqrt(statistics.fmean(result.over_bound for result in done))),
                number(seconds),
                number(seconds / shortest),
            )
        )
    rows += [(way, "not installed", *_EMPTY) for way in ALTERNATIVES if way not in WAYS]
    return Table(
        f"{len(results) // len(WAYS)} bags",
        (
            "",
            "A23, A33, a1 off by, median",
            "worst",
            "c1, c2 off by, median",
            "over the Cramer-Rao bound",
            "CPU time [s]",
            "times as long",
        ),
        rows,
        "Of the three the largest error, of the two the larger one, all over A22. Over the bound: each error over the "
        "least standard deviation that any estimate without bias has, were the encoders' errors Gaussian; the root "
        "mean square over the five base parameters and the bags, about 1 at best. This package's way ends with "
        "intervals and warnings, too.",
    )

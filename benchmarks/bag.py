"""From a bag to parameters.

What `identify` does, beside what one would write oneself. Bags of an emulated rig with Table 5's values, encoders of
8000 counts and nothing hidden: 14 s of free swing from rest, another start in each. All begin with Table 2's estimates,
and with the trial that this package finds in the bag. `mujoco.sysid` takes the state at its beginning as known: it is
given what a Savitzky-Golay filter makes of the first samples. scipy's `least_squares` over `solve_ivp` fits it too.
"""

import functools
import statistics
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import savgol_filter

from benchmarks import _mujoco
from benchmarks._rivals import LOWER, UPPER, coefficients
from benchmarks._tables import Table, number
from benchmarks._workers import LIMIT, each
from benchmarks.simulation import by_scipy
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
_FILTER = 21
"""Samples of the Savitzky-Golay filter: a tenth of a second."""


def _groups(chromosome: Array) -> Array:
    return groups_of(chromosome, PRIOR.length)


TRUTH = _groups(np.array([TABLE_5[symbol] for symbol in SYMBOLS]))


def by_identify(trial: Trial) -> Array:
    """Return the base parameters (5,) by this package, the paper's model."""
    return identify([trial], [], IdentifyOptions()).fit.values[: len(GROUPS)]


def by_tracing(trial: Trial) -> Array:
    """Return them by this package, effects looked for."""
    return trace(identify([trial], [], IdentifyOptions())).completed.fit.values[: len(GROUPS)]


def by_mujoco(trial: Trial) -> Array:
    """Return them by `mujoco.sysid`."""
    return _groups(_mujoco.identify(trial.time, trial.theta, first_state(trial), TABLE_2, LOWER, UPPER))


def by_scipy_alone(trial: Trial) -> Array:
    """Return them by least squares over an integrator, the state at the beginning fitted too."""
    width = UPPER - LOWER

    def residuals(x: Array) -> Array:
        of = coefficients((LOWER + width * x[:9])[None])[0]
        return np.asarray((by_scipy(of, x[9:], trial.time)[:, :2] - trial.theta).ravel())

    begin = np.concatenate([(PRIOR.centre - LOWER) / width, first_state(trial)])
    limits = np.concatenate([np.zeros(9), np.full(4, -np.inf)]), np.concatenate([np.ones(9), np.full(4, np.inf)])
    return _groups(LOWER + width * least_squares(residuals, begin, bounds=limits).x[:9])


def first_state(trial: Trial) -> Array:
    """Return theta1, theta2 [rad], omega1, omega2 [rad/s] at a trial's first sample, from its neighbourhood."""
    spacing = float(np.median(np.diff(trial.time)))
    first = trial.theta[:_FILTER]
    return np.concatenate([savgol_filter(first, _FILTER, 3, deriv=order, delta=spacing, axis=0)[0] for order in (0, 1)])


WAYS: dict[str, Callable[[Trial], Array]] = {
    "this package: the paper's model": by_identify,
    "this package: the same, and effects looked for": by_tracing,
    **({"`mujoco.sysid`": by_mujoco} if _mujoco.can_identify() else {}),
    "scipy `least_squares` over `solve_ivp`": by_scipy_alone,
}


@dataclass(frozen=True)
class Result:
    """What came of a bag by one way."""

    way: str
    errors: Sequence[float] = ()
    """Of A23, A33, a1 over A22, the largest, and of the frictions, the larger: relative to the truth."""
    seconds: float = 0.0
    """CPU time, from the bag on."""
    failure: str = ""


def tables(quick: bool = False) -> list[Table]:
    """Identify from each bag by all ways, as many at a time as there are cores, each on one; two bags are quick."""
    with tempfile.TemporaryDirectory() as folder:
        bags = [Path(folder) / f"swing_{count}" for count in range(2 if quick else BAGS)]
        for count, bag in enumerate(bags):
            write_clean_bag(bag, (2.2 - 0.05 * count, 2.0 + 0.07 * count), TABLE_5, SWING)
        jobs = [(way, bag) for bag in bags for way in WAYS]
        return [table_of(list(each(identified, jobs, core_count(), LIMIT, _failed)))]


def identified(job: tuple[str, Path]) -> Result:
    """Identify from a bag by one way."""
    way, bag = job
    _warm_up(bag)
    begin = time.process_time()
    groups = WAYS[way](load_trial(bag))
    seconds = time.process_time() - begin
    errors = np.abs(groups / TRUTH - 1.0)
    return Result(way, (float(errors[:3].max()), float(errors[3:].max())), seconds)


@functools.cache
def _warm_up(bag: Path) -> None:
    """Have all compiled code of this process loaded, which is not to be timed."""
    by_tracing(load_trial(bag))
    by_scipy(coefficients(PRIOR.centre[None])[0], np.zeros(4), np.array([0.0, 1.0]))


def _failed(job: tuple[str, Path], why: str) -> Result:
    return Result(job[0], failure=why)


def table_of(results: Sequence[Result]) -> Table:
    """Return medians by way, and what they are to this package's."""
    shortest, rows = 0.0, []
    for way in WAYS:
        of_it = [result for result in results if result.way == way]
        done = [result for result in of_it if not result.failure]
        if not done:
            rows.append((way, of_it[0].failure, *[""] * 4))
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
                number(seconds),
                number(seconds / shortest),
            )
        )
    if not _mujoco.can_identify():
        rows.append(("`mujoco.sysid`", "not installed", *[""] * 4))
    return Table(
        f"{len(results) // len(WAYS)} bags",
        ("", "A23, A33, a1 off by, median", "worst", "c1, c2 off by, median", "CPU time [s]", "times as long"),
        rows,
        "Of the three the largest error, of the two the larger one, all over A22. This package's way ends with "
        "intervals and warnings, too.",
    )

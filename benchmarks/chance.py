# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Chance: how often it passes for an effect where nothing is missing, by a parametric bootstrap of the fitted model.

The paper's model is fitted to two trials; its motion with new noise is identified and traced again and again. Whatever
effect is then accepted is false, and the share of such runs is the error over all that was tried, every effect and
every instant, at every step. `python -m benchmarks.chance --count 200` does so with each kind of noise; results are
kept in `--out`, and a run that was interrupted goes on from there.
"""

import argparse
import functools
import math
import statistics
import sys
import zlib
from collections.abc import Callable, Mapping, Sequence

import numpy as np
import numpy.typing as npt
from rich.console import Console
from rich.table import Table
from scipy.signal import lfilter
from scipy.stats import binomtest

from benchmarks._kept import Kept, add_arguments, kept
from benchmarks._product import identified
from cdp_ident.diagnosis.identification import Identification
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.fit.prior import Prior
from cdp_ident.model.motions import simulate
from cdp_ident.pipeline.identify import identify
from cdp_ident.tracing.odds import unlikelihood
from cdp_ident.tracing.select_effects import select_effects
from cdp_ident.tracing.selection import Selection
from cdp_ident.trial.trial import Trial
from reference.encoders import Counter
from reference.pendulum import TABLE_2, TABLE_5
from reference.settings import Setting
from reference.truths import FIT_TRIALS, truth

Array = npt.NDArray[np.float64]

RIG = Setting(
    size=1.0,
    values=TABLE_5,
    nominal=TABLE_2,
    rate=100,
    counter=Counter(8000, 0.3e-3, 0.0),
    starts=tuple(np.array([*angles, 0.0, 0.0]) for angles in ((2.2, 2.0), (2.4, 4.5), (4.0, 4.4))),
    times=(np.arange(800) / 100.0,) * 3,
)
"""The paper's rig, let go as in the example bags, for 8 s."""
NOISE = 0.5e-3
"""Standard deviation of each encoder's noise [rad]."""
STEP = 2.0 * np.pi / 4000.0
"""Of an encoder that is coarser than its noise [rad]."""


def _white(rng: np.random.Generator, count: int) -> Array:
    return NOISE * rng.standard_normal((count, 2))


def _correlated(rng: np.random.Generator, count: int, samples: float = 10.0) -> Array:
    """Return noise whose correlation falls to 1 / e within so many samples."""
    kept = float(np.exp(-1.0 / samples))
    return _filtered(rng, count, [1.0, -kept], np.sqrt(1.0 - kept**2))


def _oscillating(rng: np.random.Generator, count: int, period: float = 40.0) -> Array:
    """Return noise that oscillates with a period, in samples, and forgets its phase within one."""
    kept = float(np.exp(-1.0 / period))
    poles = [1.0, -2.0 * kept * np.cos(2.0 * np.pi / period), kept**2]
    impulse = lfilter([1.0], poles, np.eye(1, 40 * int(period))[0])
    return _filtered(rng, count, poles, 1.0 / float(np.sqrt(np.sum(impulse**2))))


def _filtered(rng: np.random.Generator, count: int, poles: Sequence[float], scale: float) -> Array:
    begin = 400
    drawn = rng.standard_normal((count + begin, 2))
    return np.asarray(NOISE * scale * lfilter([1.0], poles, drawn, axis=0)[begin:])


def _counted(rng: np.random.Generator, count: int) -> Array:
    return 0.2 * STEP * rng.standard_normal((count, 2))


NOISES: Mapping[str, Callable[[np.random.Generator, int], Array]] = {
    "white": _white,
    "correlated over 10 samples": _correlated,
    "oscillates in 40 samples": _oscillating,
    "encoder coarser than it": _counted,
}


@functools.cache
def _fitted() -> tuple[Identification, tuple[Array, ...]]:
    """Return the paper's model fitted to trials in which nothing is hidden, and its motion from each trial's start."""
    made = truth("none", 1, setting=RIG)
    found = identified(made)
    model, values = found.fit.model, found.fit.values
    motions = []
    for index in range(len(made.trials)):
        first = next(window for window in (*found.fit.windows, *found.data.holdout) if window.trial == index)
        states = simulate(model.coefficients(values), first.start, RIG.times[index])
        motions.append(states[:, :2])
    return found, tuple(motions)


def examine(job: str) -> Kept:
    """Trace one set of trials of the fitted model with new noise, `KIND/SEED`."""
    kind, _, seed = job.partition("/")
    rng = np.random.default_rng([int(seed), zlib.crc32(kind.encode())])
    trials = [
        Trial(f"{index}", RIG.times[index], _read(motion, NOISES[kind](rng, len(motion)), kind))
        for index, motion in enumerate(_fitted()[1])
    ]
    options = IdentifyOptions(prior=Prior(nominal=RIG.nominal))
    selection = select_effects(identify(trials[:FIT_TRIALS], trials[FIT_TRIALS:], options))
    accepted = list(selection.after.model.labels)
    return {"job": job, "accepted": accepted, "log10_odds": -_best(selection) / (2.0 * math.log(10.0))}


def _best(selection: Selection) -> float:
    """Return by how much the most probable effects change the misfit, the odds against them counted."""
    if selection.after.model.effects:
        return selection.steps[-1].misfit
    recorded = selection.after.recorded
    return min(score.misfit + unlikelihood(score.active, recorded) for score in selection.scores)


def _read(motion: Array, noise: Array, kind: str) -> Array:
    """Return both absolute angles (n, 2) as encoders in the joints read them, each with its own noise."""
    joints = np.diff(motion, axis=1, prepend=0.0) + noise
    if kind == "encoder coarser than it":
        joints = STEP * np.round(joints / STEP)
    return np.cumsum(joints, axis=1)


def summary(results: Sequence[Kept]) -> Table:
    """Return a row for each kind of noise: runs with a false effect, and the odds of what comes nearest to one."""
    table = Table("noise", "runs", "with a false effect", "95 % interval", "log10 odds, median", "highest")
    for kind in (*NOISES, "all"):
        those = [r for r in results if kind in ("all", r["job"].partition("/")[0])]
        if those:
            false = sum(bool(r["accepted"]) for r in those)
            low, high = binomtest(false, len(those)).proportion_ci()
            odds = [r["log10_odds"] for r in those]
            interval = f"{100 * low:.1f} to {100 * high:.1f} %"
            table.add_row(
                kind, str(len(those)), str(false), interval, f"{statistics.median(odds):.1f}", f"{max(odds):.1f}"
            )
    return table


def main(arguments: Sequence[str] = ()) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.chance")
    parser.add_argument("--count", type=int, default=200, help="runs with each kind of noise")
    add_arguments(parser, 900.0)
    options = parser.parse_args(arguments)
    jobs = [f"{kind}/{seed}" for seed in range(options.count) for kind in NOISES]
    results = []
    for result in kept(examine, jobs, options.out, options.limit, options.jobs):
        results.append(result)
        if result["accepted"]:
            print(f"{result['job']}: {', '.join(result['accepted'])}", flush=True)
    console = Console(width=None if sys.stdout.isatty() else 140)
    console.print(summary(results))


def short() -> None:
    """Take few runs."""
    main(["--count", "3"])


if __name__ == "__main__":
    main(sys.argv[1:])

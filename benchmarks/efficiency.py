"""Efficiency: how far base parameters scatter, over the Cramer-Rao bound.

No estimate without bias scatters less than that: the inverse of the information that a whole swing has of base
parameters and its initial state, by derivatives of the reference's motion. `python -m benchmarks.efficiency` lets the
paper's rig go from two starts, one of them chaotic, and identifies it by default from many draws of the noise.
"""

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from rich.console import Console

from benchmarks._tables import Table
from benchmarks._workers import each
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.model.parameters import GROUPS, SYMBOLS, groups_of
from cdp_ident.pipeline.identify import identify
from cdp_ident.tracing.trace import trace
from cdp_ident.trial.trial import Trial
from reference import pendulum
from reference.pendulum import TABLE_5, Array
from scenarios.start_given import PRIOR

STARTS: Mapping[str, tuple[float, float]] = {"calm": (np.pi - 0.8, np.pi - 0.5), "chaotic": (1.5, 1.2)}
"""theta1 and theta2 when it is let go [rad]."""
TIMES: Array = np.arange(0.0, 14.0, 0.005, dtype=np.float64)
NOISE = 2.3e-4
"""Of both encoders [rad]."""
SEEDS = 20
LIMIT = 300.0
"""An identification that takes longer is given up [s]."""
_STEP = 1e-5
"""Relative change by which derivatives are taken, where the motion is not chaotic."""
_PIECE = 0.5
"""Derivatives are taken over pieces so long [s], and carried on: over a whole chaotic swing differences say nothing."""


def readings(theta: Array) -> Array:
    """Return what the encoders of both joints show (n, 2) of absolute angles."""
    return np.column_stack([theta[:, 0], theta[:, 1] - theta[:, 0]])


def bound(start: tuple[float, float]) -> Array:
    """Return the least standard deviation (5,) of each base parameter."""
    physical = np.array([TABLE_5[symbol] for symbol in SYMBOLS])
    by_physical = _differences(lambda values: groups_of(values, TABLE_5["L"]), physical)
    # Changes of physical values that change one base parameter alone.
    changes = np.linalg.pinv(by_physical)
    samples = round(_PIECE / (TIMES[1] - TIMES[0]))
    state = np.array([*start, 0.0, 0.0])
    by = np.concatenate([np.eye(4), np.zeros((4, len(GROUPS)))], axis=1)
    information = np.zeros((4 + len(GROUPS), 4 + len(GROUPS)))
    for first in range(0, len(TIMES) - 1, samples):
        times = TIMES[first : first + samples + 1] - TIMES[first]

        def moved(point: Array, times: Array = times) -> Array:
            values = dict(zip(SYMBOLS, (physical + changes @ point[4:]).tolist(), strict=True))
            return pendulum.motion(TABLE_5 | values, point[:4], times)

        slopes = _differences(moved, np.concatenate([state, np.zeros(len(GROUPS))]))
        whole = slopes @ np.concatenate([by, np.eye(4 + len(GROUPS))[4:]])
        shown = np.stack([whole[:-1, 0], whole[:-1, 1] - whole[:-1, 0]]).reshape(-1, whole.shape[-1])
        information += shown.T @ shown / NOISE**2
        state, by = moved(np.concatenate([state, np.zeros(len(GROUPS))]))[-1], whole[-1]
    scale = 1.0 / np.sqrt(np.diag(information))
    # The state at the beginning is known the better the more chaotic the motion is: eliminated by orthogonal rows.
    covariance = np.linalg.pinv(information * np.outer(scale, scale), rcond=1e-15, hermitian=True)
    return np.asarray(np.sqrt(np.diag(covariance))[4:] * scale[4:])


def _differences(function: Callable[[Array], Array], point: Array) -> Array:
    """Return the derivatives of a function by its argument, in a last axis."""
    columns = []
    for place in range(len(point)):
        step = np.zeros(len(point))
        step[place] = _STEP * max(abs(point[place]), 0.1)
        columns.append((function(point + step) - function(point - step)) / (2.0 * step[place]))
    return np.stack(columns, axis=-1)


def found(job: str) -> Array:
    """Return the base parameters (5,) that are found in one draw, `START/SEED`."""
    start, seed = job.split("/")
    rng = np.random.default_rng(int(seed))
    theta = pendulum.motion(TABLE_5, np.array([*STARTS[start], 0.0, 0.0]), TIMES)[:, :2]
    shown = readings(theta) + NOISE * rng.normal(size=theta.shape)
    trial = Trial("swing", TIMES, np.cumsum(shown, axis=1))
    values = trace(identify([trial], [], IdentifyOptions(prior=PRIOR))).completed.fit.values
    return np.asarray(values[: len(GROUPS)])


def table(seeds: int, jobs: int) -> Table:
    """Return the scatter of each base parameter over the bound."""
    truth = groups_of(np.array([TABLE_5[symbol] for symbol in SYMBOLS]), TABLE_5["L"])
    rows = []
    for start in STARTS:
        drawn = [f"{start}/{seed}" for seed in range(seeds)]
        results = [of for of in each(found, drawn, jobs, LIMIT, lambda job, reason: np.empty(0)) if len(of)]
        off = np.array(results) - truth
        ratios = np.sqrt(np.mean(off**2, axis=0)) / bound(STARTS[start])
        rows.append((start, f"{len(off)} of {seeds}", *(f"{ratio:.2f}" for ratio in ratios)))
    return Table("Scatter over the Cramer-Rao bound", ("start", "found", *(group.symbol for group in GROUPS)), rows)


def main(arguments: Sequence[str] = ()) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.efficiency", description=__doc__)
    parser.add_argument("--seeds", type=int, default=SEEDS, help="draws of the noise from each start")
    parser.add_argument("--jobs", type=int, default=2, help="processes, of one core each")
    options = parser.parse_args(list(arguments))
    Console().print(table(options.seeds, options.jobs).for_terminal())


if __name__ == "__main__":
    main(sys.argv[1:])

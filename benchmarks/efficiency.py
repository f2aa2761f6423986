# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Efficiency: how far base parameters scatter, over the Cramer-Rao bound.

No estimate without bias scatters less than that: the inverse of the information that a whole swing has of base
parameters, L and its initial state, by derivatives of the reference's motion. `python -m benchmarks.efficiency` lets
the paper's rig go from two starts, one of them chaotic, drives it by motors whose torques are known, and identifies it
by default from many draws of the noise.
"""

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from rich.console import Console

from benchmarks._tables import Table
from benchmarks._workers import each
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.model.parameters import GROUPS, INVERSE_INERTIA, SYMBOLS, groups_of, inertia_about_cart
from cdp_ident.pipeline.identify import identify
from cdp_ident.tracing.trace import trace
from cdp_ident.trial.trial import Trial
from reference import pendulum
from reference.pendulum import TABLE_5, Array
from scenarios.start_given import PRIOR

MOTORS = "motors"
STARTS: Mapping[str, tuple[float, float]] = {
    "calm": (np.pi - 0.8, np.pi - 0.5),
    "chaotic": (1.5, 1.2),
    MOTORS: (np.pi - 0.8, np.pi - 0.5),
}
"""theta1 and theta2 when it is let go [rad]; or when motors begin to drive both joints."""
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


class Shown(NamedTuple):
    """What trials show of a rig, and how well it is known beforehand."""

    names: tuple[str, ...]
    of: Callable[[Array], Array]
    """From the physical values and L (10,) to what trials show (k,)."""
    std: Array
    """(k,) standard deviations beforehand, infinite where nothing is known."""


def shown_by(with_motors: bool, length_std: float) -> Shown:
    """Return what trials show: base parameters, L where it is not exact, and by motors 1 / A22, too."""
    with_length = length_std > 0.0
    names = [group.symbol for group in GROUPS] + ["1/A22"] * with_motors + ["L"] * with_length

    def of(values: Array) -> Array:
        length = float(values[-1])
        inverse = 1.0 / inertia_about_cart(values[:-1], length)
        return np.array([*groups_of(values[:-1], length), *([inverse] * with_motors), *([length] * with_length)])

    std = np.full(len(names), np.inf)
    if with_length:
        std[-1] = length_std * TABLE_5["L"]
    return Shown(tuple(names), of, std)


def torques(time: float) -> tuple[float, float]:
    """Return the torques of the motors in both joints [N m]."""
    inner = 0.05 * np.sin(2.1 * time) + 0.05 * np.sin(7.3 * time + 1.0) + 0.04 * np.sin(13.1 * time)
    outer = 0.02 * np.sin(3.7 * time) + 0.02 * np.sin(9.1 * time + 2.0)
    return float(inner), float(outer)


def on_rods(time: float, _: Array) -> tuple[float, float]:
    """Return the same as torques on both rods."""
    inner, outer = torques(time)
    return inner - outer, outer


def bound(start: tuple[float, float], length_std: float = 0.0, with_motors: bool = False) -> Array:
    """Return the least standard deviation (k,) of what a trial from a start shows; L is exact, or as known as stated.

    The motors' lags, and how they differ, are taken for known.
    """
    shown = shown_by(with_motors, length_std)
    truth = np.array([*(TABLE_5[symbol] for symbol in SYMBOLS), TABLE_5["L"]])
    by_truth = _differences(shown.of, truth)
    # Changes of physical values that change one of what is shown alone; L stays where it is exact.
    by_truth[:, -1] *= length_std > 0.0
    changes = np.linalg.pinv(by_truth)
    count, samples = len(shown.names), round(_PIECE / (TIMES[1] - TIMES[0]))
    state = np.array([*start, 0.0, 0.0])
    by = np.concatenate([np.eye(4), np.zeros((4, count))], axis=1)
    information = np.diag([*np.zeros(4), *shown.std**-2.0])
    for first in range(0, len(TIMES) - 1, samples):
        times = TIMES[first : first + samples + 1] - TIMES[first]

        def moved(point: Array, times: Array = times, begin: float = float(TIMES[first])) -> Array:
            values = dict(zip((*SYMBOLS, "L"), (truth + changes @ point[4:]).tolist(), strict=True))
            driven = (lambda time, of: on_rods(begin + time, of)) if with_motors else None
            return pendulum.motion(TABLE_5 | values, point[:4], times, torque=driven)

        slopes = _differences(moved, np.concatenate([state, np.zeros(count)]))
        whole = slopes @ np.concatenate([by, np.eye(4 + count)[4:]])
        seen = np.stack([whole[:-1, 0], whole[:-1, 1] - whole[:-1, 0]]).reshape(-1, whole.shape[-1])
        information += seen.T @ seen / NOISE**2
        state, by = moved(np.concatenate([state, np.zeros(count)]))[-1], whole[-1]
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
    """Return what is found in one draw, `START/SEED`, of what the trials show."""
    start, seed = job.split("/")
    rng = np.random.default_rng(int(seed))
    is_driven = start == MOTORS
    driven = on_rods if is_driven else None
    theta = pendulum.motion(TABLE_5, np.array([*STARTS[start], 0.0, 0.0]), TIMES, torque=driven)[:, :2]
    encoders = readings(theta) + NOISE * rng.normal(size=theta.shape)
    recorded = np.array([torques(time) for time in TIMES.tolist()]) if is_driven else None
    trial = Trial("swing", TIMES, np.cumsum(encoders, axis=1), torques=recorded)
    fit = trace(identify([trial], [], IdentifyOptions(prior=PRIOR))).completed.fit
    names = [name.replace(INVERSE_INERTIA.symbol, "1/A22") for name in fit.model.names]
    return np.array([fit.values[names.index(name)] for name in shown_by(is_driven, 1.0).names])


def table(seeds: int, jobs: int) -> Table:
    """Return the scatter of what trials show over the bound."""
    truth = np.array([*(TABLE_5[symbol] for symbol in SYMBOLS), TABLE_5["L"]])
    rows, names = [], shown_by(True, 1.0).names
    for start in STARTS:
        drawn = [f"{start}/{seed}" for seed in range(seeds)]
        results = [of for of in each(found, drawn, jobs, LIMIT, lambda job, reason: np.empty(0)) if len(of)]
        is_driven, length_std = start == MOTORS, IdentifyOptions().length_std
        shown = shown_by(is_driven, length_std)
        off = np.array(results) - shown.of(truth)
        ratios = np.sqrt(np.mean(off**2, axis=0)) / bound(STARTS[start], length_std, is_driven)
        of = {name: f"{ratio:.2f}" for name, ratio in zip(shown.names, ratios, strict=True)}
        rows.append((start, f"{len(off)} of {seeds}", *(of.get(name, "–") for name in names)))
    return Table("Scatter over the Cramer-Rao bound", ("start", "found", *names), rows)


def main(arguments: Sequence[str] = ()) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.efficiency", description=__doc__)
    parser.add_argument("--seeds", type=int, default=SEEDS, help="draws of the noise from each start")
    parser.add_argument("--jobs", type=int, default=2, help="processes, of one core each")
    options = parser.parse_args(list(arguments))
    Console().print(table(options.seeds, options.jobs).for_terminal())


if __name__ == "__main__":
    main(sys.argv[1:])

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Efficiency: how far base parameters scatter, over the Cramer-Rao bound.

No estimate without bias scatters less than that: the inverse of the information that a whole swing has of base
parameters, L, its motors and its initial state, by derivatives of the reference's motion.
`python -m benchmarks.efficiency` lets the paper's rig go from two starts, one of them chaotic, drives it by motors
whose torques are known and by its cart, whose motion is known, and identifies it by default from many draws of the
noise.
"""

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import sympy
from rich.console import Console
from scipy.linalg import qr

from benchmarks._tables import Table
from benchmarks._workers import each
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.model.effects.forces import MOTORS
from cdp_ident.model.parameters import GROUPS, INVERSE_INERTIA, SYMBOLS, groups_of, inertia_about_cart
from cdp_ident.pipeline.identify import identify
from cdp_ident.tracing.trace import trace
from cdp_ident.trial.trial import Trial
from reference import pendulum
from reference.pendulum import AT_REST, TABLE_5, TIME, Array, cart_position
from scenarios.start_given import PRIOR

OF_MOTORS = ("imbalance", "lag_inner", "lag_outer")
UNKNOWNS = (*SYMBOLS, "L", *OF_MOTORS)
TRUTH = np.array([*(TABLE_5[symbol] for symbol in (*SYMBOLS, "L")), 0.0, 0.0, 0.0])


class Motion(NamedTuple):
    """How the rig moves."""

    start: tuple[float, float] = (np.pi - 0.8, np.pi - 0.5)
    """theta1 and theta2 at first, at rest [rad]."""
    motors: bool = False
    """Whether motors drive both joints."""
    cart: sympy.Expr = AT_REST
    """Where the cart is [m], an expression of `TIME`."""

    def states(self, values: Array, state: Array, times: Array, begin: float = 0.0) -> Array:
        """Return the states (n, 4) at times (n,) after a time `begin`, given the one (4,) then [s], and `UNKNOWNS`."""
        physical = TABLE_5 | dict(zip((*SYMBOLS, "L"), values[:-3].tolist(), strict=True))
        driven = (lambda time, _: on_rods(begin + time, *values[-3:])) if self.motors else None
        return pendulum.motion(physical, state, times, self.cart.subs(TIME, TIME + begin), driven)


MOTIONS: Mapping[str, Motion] = {
    "calm": Motion(),
    "chaotic": Motion((1.5, 1.2)),
    "motors": Motion(motors=True),
    "cart": Motion(cart=0.06 * sympy.sin(2.3 * TIME) + 0.03 * sympy.sin(5.1 * TIME)),
}
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
    """From `UNKNOWNS` (13,) to what trials show (k,)."""
    std: Array
    """(k,) standard deviations beforehand, infinite where nothing is known."""


def shown_by(with_motors: bool, length_std: float) -> Shown:
    """Return what trials show: base parameters, L where it is not exact, and by motors 1 / A22, too, and their own."""
    with_length = length_std > 0.0
    names = [group.symbol for group in GROUPS] + ["1/A22", *OF_MOTORS] * with_motors + ["L"] * with_length

    def of(values: Array) -> Array:
        physical, length = values[: len(SYMBOLS)], float(values[len(SYMBOLS)])
        by_motors = [1.0 / inertia_about_cart(physical, length), *values[-3:]]
        return np.array([*groups_of(physical, length), *by_motors * with_motors, *[length] * with_length])

    known = {"L": length_std * TABLE_5["L"], "imbalance": np.sqrt(2.0) * IdentifyOptions().torque_std}
    known |= {parameter.name: parameter.width for parameter in MOTORS.parameters if parameter.width}
    return Shown(tuple(names), of, np.array([known.get(name, np.inf) for name in names]))


def torques(time: float) -> tuple[float, float]:
    """Return the torques of the motors in both joints [N m]."""
    inner = 0.05 * np.sin(2.1 * time) + 0.05 * np.sin(7.3 * time + 1.0) + 0.04 * np.sin(13.1 * time)
    outer = 0.02 * np.sin(3.7 * time) + 0.02 * np.sin(9.1 * time + 2.0)
    return float(inner), float(outer)


def on_rods(time: float, imbalance: float, lag_inner: float, lag_outer: float) -> tuple[float, float]:
    """Return what acts of them on both rods [N m]."""
    inner, outer = torques(time - lag_inner)[0], (1.0 + imbalance) * torques(time - lag_outer)[1]
    return inner - outer, outer


def bound(motion: Motion, length_std: float = 0.0) -> Array:
    """Return the least standard deviation (k,) of what a trial shows; L is exact, or as known as stated."""
    shown = shown_by(motion.motors, length_std)
    by_truth = _differences(shown.of, TRUTH)
    # Changes of physical values that change one of what is shown alone; L stays where it is exact.
    by_truth[:, UNKNOWNS.index("L")] *= length_std > 0.0
    changes = np.linalg.pinv(by_truth)
    count, samples = len(shown.names), round(_PIECE / (TIMES[1] - TIMES[0]))
    state = np.array([*motion.start, 0.0, 0.0])
    by = np.concatenate([np.eye(4), np.zeros((4, count))], axis=1)
    known = np.diag([*np.zeros(4), *1.0 / shown.std])
    for first in range(0, len(TIMES) - 1, samples):
        times = TIMES[first : first + samples + 1] - TIMES[first]

        def moved(point: Array, times: Array = times, begin: float = float(TIMES[first])) -> Array:
            return motion.states(TRUTH + changes @ point[4:], point[:4], times, begin)

        slopes = _differences(moved, np.concatenate([state, np.zeros(count)]))
        whole = slopes @ np.concatenate([by, np.eye(4 + count)[4:]])
        seen = np.stack([whole[:-1, 0], whole[:-1, 1] - whole[:-1, 0]]).reshape(-1, whole.shape[-1])
        # The state at the beginning is known the better the more chaotic the motion is: triangular, by orthogonal rows.
        known = qr(np.concatenate([known, seen / NOISE]), mode="economic")[1]
        state, by = moved(np.concatenate([state, np.zeros(count)]))[-1], whole[-1]
    return np.asarray(np.linalg.norm(np.linalg.inv(known), axis=1)[4:])


def _differences(function: Callable[[Array], Array], point: Array) -> Array:
    """Return the derivatives of a function by its argument, in a last axis."""
    columns = []
    for place in range(len(point)):
        step = np.zeros(len(point))
        step[place] = _STEP * max(abs(point[place]), 0.1)
        columns.append((function(point + step) - function(point - step)) / (2.0 * step[place]))
    return np.stack(columns, axis=-1)


def found(job: str) -> Array:
    """Return what is found in one draw, `MOTION/SEED`, of what the trials show."""
    name, seed = job.split("/")
    motion, rng = MOTIONS[name], np.random.default_rng(int(seed))
    theta = motion.states(TRUTH, np.array([*motion.start, 0.0, 0.0]), TIMES)[:, :2]
    encoders = readings(theta) + NOISE * rng.normal(size=theta.shape)
    recorded = np.array([torques(time) for time in TIMES.tolist()]) if motion.motors else None
    cart = cart_position(motion.cart, TIMES)
    trial = Trial("swing", TIMES, np.cumsum(encoders, axis=1), cart=cart, torques=recorded)
    fit = trace(identify([trial], [], IdentifyOptions(prior=PRIOR))).completed.fit
    names = [name.replace(INVERSE_INERTIA.symbol, "1/A22").removeprefix("motors.") for name in fit.model.names]
    return np.array([fit.values[names.index(name)] for name in shown_by(motion.motors, 1.0).names])


def table(seeds: int, jobs: int) -> Table:
    """Return the scatter of what trials show over the bound."""
    rows, names = [], [name for name in shown_by(True, 1.0).names if name not in OF_MOTORS]
    for name, motion in MOTIONS.items():
        drawn = [f"{name}/{seed}" for seed in range(seeds)]
        results = [of for of in each(found, drawn, jobs, LIMIT, lambda job, reason: np.empty(0)) if len(of)]
        length_std = IdentifyOptions().length_std
        shown = shown_by(motion.motors, length_std)
        off = np.array(results) - shown.of(TRUTH)
        ratios = np.sqrt(np.mean(off**2, axis=0)) / bound(motion, length_std)
        of = {symbol: f"{ratio:.2f}" for symbol, ratio in zip(shown.names, ratios, strict=True)}
        rows.append((name, f"{len(off)} of {seeds}", *(of.get(symbol, "–") for symbol in names)))
    return Table("Scatter over the Cramer-Rao bound", ("motion", "found", *names), rows)


def main(arguments: Sequence[str] = ()) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.efficiency", description=__doc__)
    parser.add_argument("--seeds", type=int, default=SEEDS, help="draws of the noise of each motion")
    parser.add_argument("--jobs", type=int, default=2, help="processes, of one core each")
    options = parser.parse_args(list(arguments))
    Console(width=None if sys.stdout.isatty() else 160).print(table(options.seeds, options.jobs).for_terminal())


if __name__ == "__main__":
    main(sys.argv[1:])

"""From anywhere in the box to the noise floor: search and refinement beside pycma and scipy's least squares.

The twin's start is given, and an optimizer has arrived when its squared error is within 5 % of the true parameters'
own. Times are without compiling; all run on the same machine one after the other, so that their ratios hold elsewhere.
"""

import contextlib
import time
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import track
from rich.table import Table
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares

from benchmarks._timing import seconds
from benchmarks.simulation import _derivative
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.refinement import refine_from_afar
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.parallel import core_count
from cdp_ident.model.parameters import coefficients_of, groups_of, physical_coefficients
from cdp_ident.model.trajectory import trajectory, trajectory_with_derivatives
from cdp_ident.trial.trial import Trial
from reference.pendulum import TABLE_3, TABLE_5, Array
from scenarios.start_given import CLOSE, PRIOR, Arrival, StartGiven, search_and_refine

with warnings.catch_warnings():
    warnings.simplefilter("ignore", UserWarning)  # that it cannot plot
    import cma  # type: ignore[import-untyped]

LOWER, UPPER = PRIOR.box
MOST_SIMULATIONS = 50_000
MEASURED = Path(__file__).parents[2] / "shared" / "data" / "multiarm_free_swing" / "free_swing_8s_56s_1kHz.csv.gz"
MEASURED_MODEL = MotionModel(Mechanism.of(Prior(nominal={"L": 0.17272})), length_free=True)
MEASURED_GROUPS = np.array([0.49, 0.56, 6.0, 0.08, 0.003])
"""About what is published of that rig."""


def coefficients(chromosomes: Array) -> Array:
    return coefficients_of(groups_of(chromosomes, PRIOR.length), PRIOR.length, PRIOR.gravity)


def by_pycma(problem: StartGiven, seed: int, spread: Callable[[Array], Array]) -> Arrival:
    """Restart CMA-ES on the compiled objective until it is close; `spread` takes the unit box to the parameters'."""
    simulations, best, restart = 0, np.inf, 0
    while best > CLOSE and simulations < MOST_SIMULATIONS:
        restart += 1
        options = {"bounds": [0, 1], "verbose": -9, "seed": 1000 * seed + restart}
        strategy = cma.CMAEvolutionStrategy(len(LOWER) * [0.5], 0.3, options)
        while best > CLOSE and not strategy.stop():
            points = strategy.ask()
            errors = problem.population.squared_errors(coefficients(spread(np.array(points))))[:, 0]
            simulations += len(points)
            strategy.tell(points, errors.tolist())
            best = min(best, float(errors.min()) / problem.truth_error)
    return Arrival(best, simulations)


def evenly(x: Array) -> Array:
    return LOWER + (UPPER - LOWER) * x


def logarithmically(x: Array) -> Array:
    return np.asarray(LOWER * (UPPER / LOWER) ** x)


class _CloseError(Exception):
    """Ends a least-squares fit that is close enough."""


def by_least_squares(problem: StartGiven, seed: int) -> Arrival:
    """Fit by scipy alone, from somewhere in the box."""
    simulations, best = 0, np.inf
    times, theta = problem.trial.time, problem.trial.theta

    def residuals(x: Array) -> Array:
        nonlocal simulations, best
        simulations += 1
        solution = solve_ivp(
            _derivative,
            (0.0, times[-1]),
            TABLE_3,
            t_eval=times,
            rtol=1e-6,
            atol=1e-6,
            args=(coefficients(evenly(x)),),
        )
        error = (solution.y[:2].T - theta).ravel()
        best = min(best, float(error @ error) / problem.truth_error)
        if best < CLOSE:
            raise _CloseError
        return np.asarray(error)

    with contextlib.suppress(_CloseError):
        least_squares(residuals, np.random.default_rng(seed).uniform(size=len(LOWER)), bounds=(0.0, 1.0))
    return Arrival(best, simulations)


def cost_of_derivatives(problem: StartGiven) -> float:
    """Return how many simulations one with derivatives takes as long as."""
    whole, truth, start = problem.whole, physical_coefficients(TABLE_5), np.array(TABLE_3)
    plain = seconds(lambda: trajectory(truth, start, whole.grid, whole.u))
    return seconds(lambda: trajectory_with_derivatives(truth, start, whole.grid, whole.u)) / plain


def main() -> None:
    rows: list[tuple[str, Callable[[StartGiven, int], Arrival], Sequence[int]]] = [
        ("search, refinement", lambda p, seed: search_and_refine(p, np.random.default_rng(seed)), range(100)),
        ("pycma", lambda p, seed: by_pycma(p, seed, evenly), range(30)),
        ("pycma, logarithms", lambda p, seed: by_pycma(p, seed, logarithmically), range(30)),
        ("least_squares", by_least_squares, range(3)),
    ]
    problems = [StartGiven.of(seed) for seed in range(100)]
    for _, work, _ in rows[:3]:
        work(problems[0], 0)
    derivatives = cost_of_derivatives(problems[0])
    table = Table("", "arrived", "plain", "with derivatives", "in all", "time [ms]", "times as long")
    shortest = 0.0
    for name, work, seeds in rows:
        arrivals, durations = [], []
        for seed in track(seeds, name, transient=True):
            begin = time.perf_counter()
            arrivals.append(work(problems[seed], seed))
            durations.append(time.perf_counter() - begin)
        simulations = float(np.median([arrival.simulations for arrival in arrivals]))
        passes = float(np.median([arrival.passes for arrival in arrivals]))
        duration = float(np.median(durations))
        shortest = shortest or duration
        table.add_row(
            name,
            f"{sum(arrival.relative_error < CLOSE for arrival in arrivals)} of {len(arrivals)}",
            f"{simulations:.0f}",
            f"{passes:.0f}",
            f"{simulations + derivatives * passes:.0f}",
            f"{1e3 * duration:.0f}",
            f"{duration / shortest:.1f}",
        )
    console = Console()
    console.print(table)
    console.print(
        f"Medians, {core_count()} cores. One simulation with derivatives takes as long as {derivatives:.1f} without "
        "and is counted so in all."
    )
    if MEASURED.exists():
        time_s, theta1, theta2 = np.loadtxt(MEASURED, delimiter=",", skiprows=1, usecols=(0, 1, 2))[::5].T
        windows = cut_into_windows([Trial("measured", time_s - time_s[0], np.column_stack([theta1, theta2]))])

        begin = time.perf_counter()
        fit = refine_from_afar(MEASURED_MODEL, MEASURED_MODEL.initial_values(MEASURED_GROUPS), windows)
        console.print(
            f"Measured free swing of {windows[-1].begin + windows[-1].duration:.0f} s, {len(windows)} windows: refined "
            f"in {time.perf_counter() - begin:.1f} s to {1e3 * fit.rmse():.2f} mrad."
        )

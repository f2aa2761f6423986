# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From anywhere in the box to the noise.

The paper's algorithms, this package's default, and other optimizers, in the paper's setting: one trial of 10 s from
Table 3's start, which is given; Table 5's values are to be found, anywhere in the box of nine physical values. The
trial is simulated, with 2 mrad of noise and encoders of 8000 counts, anew for each seed. A method has arrived when its
squared error, Eq. (10), is within 5 % of the true values' own, which is about 0.016 rad². All but the paper's
algorithms end then, or after as many simulations as the improved one (IGA) makes; those run their 500 generations, with
each of the improvements left out, too.

Their squared errors spread widely. Of ten values, the median lies between the third and the eighth with a probability
of 89 %; what differs by less than a factor of three is not told apart.
"""

import functools
import math
import statistics
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks import _alternatives, _mujoco
from benchmarks._tables import Table, number, whole
from benchmarks._workers import LIMIT, each
from benchmarks.simulation import by_scipy
from cdp_ident.machine.parallel import core_count
from cdp_ident.search.genetic_search import genetic_search
from cdp_ident.search.options import IGA, TGA, GeneticOptions
from reference.pendulum import TABLE_3
from scenarios.start_given import CLOSE, PRIOR, Arrival, StartGiven, balance_and_fit, search_and_fit

Method = Callable[[StartGiven, int], Arrival]


def _by_genes(problem: StartGiven, seed: int, options: GeneticOptions) -> Arrival:
    """Run a genetic algorithm of the paper in full."""
    found = genetic_search(
        lambda chromosomes: problem.population.squared_errors(_alternatives.coefficients(chromosomes))[:, 0],
        *PRIOR.box,
        options,
        np.random.default_rng(seed),
    )
    return Arrival(found.error / problem.truth_error, found.evaluations)


ALGORITHMS = {
    "IGA": IGA,
    "IGA without Hamming pairing": replace(IGA, hamming_pairing=False),
    "IGA without variable precision": replace(IGA, variable_precision=False),
    "IGA without orthogonal experiments": replace(IGA, orthogonal_experiments=False),
    # As many simulations as with them: a generation costs 44 and not 344.
    "the same, for 3909 generations": replace(IGA, orthogonal_experiments=False, generations=3909),
    "IGA without feedback mutation": replace(IGA, feedback_mutation=False),
    "IGA without logarithmic fitness": replace(IGA, logarithmic_fitness=False),
    "IGA without elitist survival": replace(IGA, elitist_survival=False),
    "TGA": TGA,
    "TGA with elitist survival": replace(TGA, elitist_survival=True),
}
OURS = "this package: short search, whole swing"
SEEDS, FEW = 10, 4
"""Of a method, and of one that takes long; the interval in the table is that of ten."""
METHODS: Mapping[str, tuple[Method, int]] = {
    OURS: (lambda problem, seed: search_and_fit(problem, np.random.default_rng(seed)), SEEDS),
    "this package: balance of forces, whole swing": (lambda problem, _: balance_and_fit(problem), SEEDS),
    "pycma": (_alternatives.by_pycma, SEEDS),
    "pycma, box in logarithms": (
        functools.partial(_alternatives.by_pycma, spread=_alternatives.logarithmically),
        SEEDS,
    ),
    "scipy `differential_evolution`": (_alternatives.by_differential_evolution, SEEDS),
    "scipy `least_squares` over `solve_ivp`": (_alternatives.by_least_squares, FEW),
    "`mujoco.sysid`": (_alternatives.by_mujoco, FEW),
    **{name: (functools.partial(_by_genes, options=options), SEEDS) for name, options in ALGORITHMS.items()},
}
NOT_HERE = () if _mujoco.can_identify() else tuple(name for name in METHODS if "mujoco" in name)


_NOWHERE = Arrival(math.inf, 0)


@dataclass(frozen=True)
class Result:
    """What came of a method with one seed."""

    method: str
    seed: int
    arrival: Arrival = _NOWHERE
    error: float = math.inf
    """Squared error [rad^2]."""
    seconds: float = 0.0
    """CPU time."""
    failure: str = ""


def tables(quick: bool = False) -> list[Table]:
    """Try all methods on all seeds, as many at a time as there are cores, each on one; a quick run has three seeds."""
    seeds = 3 if quick else SEEDS
    names = [name for name in METHODS if name not in NOT_HERE]
    jobs = [(name, seed) for seed in range(seeds) for name in names if seed < METHODS[name][1]]
    return [table_of(list(each(solve, jobs, core_count(), LIMIT, _failed)))]


def solve(job: tuple[str, int]) -> Result:
    """Solve one problem by one method."""
    name, seed = job
    _warm_up()
    problem = StartGiven.of(seed)
    begin = time.process_time()
    arrival = METHODS[name][0](problem, seed)
    seconds = time.process_time() - begin
    return Result(name, seed, arrival, arrival.relative_error * problem.truth_error, seconds)


@functools.cache
def _warm_up() -> None:
    """Have all compiled code of this process loaded, which is not to be timed."""
    problem = StartGiven.of(SEEDS)
    search_and_fit(problem, np.random.default_rng(0))
    balance_and_fit(problem)
    by_scipy(_alternatives.coefficients(PRIOR.centre[None])[0], np.array(TABLE_3), problem.trial.time)


def _failed(job: tuple[str, int], why: str) -> Result:
    return Result(*job, failure=why)


def table_of(results: Sequence[Result]) -> Table:
    """Return medians by method, and what they are to this package's."""
    of = {name: [result for result in results if result.method == name] for name in METHODS}
    shortest = statistics.median(result.seconds for result in of[OURS])
    rows = []
    for name, all_of_it in of.items():
        done = [result for result in all_of_it if not result.failure]
        if not done:
            rows.append((name, "not installed" if name in NOT_HERE else all_of_it[0].failure, *[""] * 6))
            continue
        arrived = sum(result.arrival.relative_error < CLOSE for result in done)
        errors = sorted(result.error for result in done)
        low, high = (errors[2], errors[7]) if len(errors) == SEEDS else (errors[0], errors[-1])
        seconds = statistics.median(result.seconds for result in done)
        passes = statistics.median(result.arrival.passes for result in done)
        rows.append(
            (
                name,
                f"{arrived} of {len(all_of_it)}",
                number(statistics.median(errors)),
                f"{number(low)} to {number(high)}",
                whole(statistics.median(result.arrival.simulations for result in done)),
                whole(passes) if passes else "",
                number(seconds),
                number(seconds / shortest),
            )
        )
    return Table(
        "Methods",
        (
            "", "arrived", "squared error [rad²], median", f"third to eighth of {SEEDS}, or all", "simulations",
            "with derivatives", "CPU time [s]", "times as long",
        ),
        rows,
        "pycma, differential evolution and the genetic algorithms simulate with this package's compiled population, "
        "which flatters them; `least_squares` integrates its compiled equations; `mujoco.sysid` simulates with its own "
        "engine. These two begin somewhere in the box.",
    )  # fmt: skip

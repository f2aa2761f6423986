"""Simulation of the paper's trial, 10 s from Table 3 read at 200 Hz, beside scipy's integrators.

All integrate the same compiled equations. The error is the largest difference of an angle from the independent
reference, which is far finer than any of them.
"""

import functools
from collections.abc import Callable

import numba
import numpy as np
import numpy.typing as npt
from rich.console import Console
from rich.table import Table
from scipy.integrate import solve_ivp

from benchmarks._timing import seconds
from cdp_ident.model.equations import accelerations
from cdp_ident.model.parallel import core_count
from cdp_ident.model.parameters import coefficients_of, groups_of, physical_coefficients
from cdp_ident.model.population import Population, Segment
from cdp_ident.model.simulation import simulate
from reference.pendulum import TABLE_3, TABLE_5, motion
from scenarios.search_problem import LOWER, UPPER
from scenarios.twin import TEN_SECONDS

Array = npt.NDArray[np.float64]

COEFFICIENTS = physical_coefficients(TABLE_5)
START = np.array(TABLE_3)
MEMBERS = 1600


@numba.njit
def _derivative(time, state, coefficients):  # type: ignore[no-untyped-def]
    A23, A33, a1, c1, c2, m2_l2, g = coefficients
    theta1, theta2, omega1, omega2 = state
    alpha1, alpha2 = accelerations(theta1, theta2, omega1, omega2, 0.0, A23, A33, a1, c1, c2, m2_l2, g)
    return np.array([omega1, omega2, alpha1, alpha2])


def by_scipy(method: str, tolerance: float) -> Array:
    """Return the states (n, 4) by one of scipy's integrators."""
    solution = solve_ivp(
        _derivative,
        (0.0, TEN_SECONDS[-1]),
        START,
        method=method,
        t_eval=TEN_SECONDS,
        rtol=tolerance,
        atol=tolerance,
        args=(COEFFICIENTS,),
    )
    return np.asarray(solution.y.T)


def main() -> None:
    rows: list[tuple[str, Callable[[], Array]]] = [
        *(
            (
                f"simulate, step {step * 1e3:g} ms",
                functools.partial(simulate, COEFFICIENTS, START, TEN_SECONDS, None, step),
            )
            for step in (0.005, 0.001)
        ),
        *(
            (f"solve_ivp {method}, tolerance {tolerance:g}", functools.partial(by_scipy, method, tolerance))
            for method in ("RK45", "DOP853", "LSODA")
            for tolerance in (1e-6, 1e-9)
        ),
    ]
    truth = motion(TABLE_5, TABLE_3, TEN_SECONDS)
    table = Table("one trajectory", "error [rad]", "time [µs]", "times as long")
    shortest = seconds(rows[0][1])
    for name, work in rows:
        error = np.abs(work() - truth)[:, :2].max()
        duration = seconds(work)
        table.add_row(name, f"{error:.0e}", f"{duration * 1e6:.0f}", f"{duration / shortest:.1f}")
    console = Console()
    console.print(table)

    physical = np.random.default_rng(0).uniform(LOWER, UPPER, (MEMBERS, len(LOWER)))
    coefficients = coefficients_of(groups_of(physical, TABLE_5["L"]), TABLE_5["L"], TABLE_5["g"])
    population = Population([Segment(START, TEN_SECONDS, truth[:, :2])])
    together = seconds(lambda: population.squared_errors(coefficients), 2.0) / MEMBERS
    ones = seconds(lambda: [simulate(each, START, TEN_SECONDS) for each in coefficients[:100]]) / 100
    scipy = seconds(lambda: by_scipy("DOP853", 1e-6))
    table = Table(f"each of {MEMBERS} pendulums, {core_count()} cores", "time [µs]", "times as long")
    for name, duration in (
        ("Population.squared_errors", together),
        ("simulate, one after another", ones),
        ("solve_ivp DOP853, tolerance 1e-06", scipy),
    ):
        table.add_row(name, f"{duration * 1e6:.1f}", f"{duration / together:.0f}")
    console.print(table)

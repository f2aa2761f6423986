# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How fast motions are simulated.

The paper's trial: 10 s from Table 3, read at 200 Hz, steps of 5 ms. The C is `benchmarks/pendulum.c`, the same
arithmetic written by hand and compiled by gcc for this processor (`-O3 -march=native -ffast-math`, OpenMP simd); before
it is timed, its results are compared with the package's.
"""

import functools
from collections.abc import Callable, Mapping

import numba
import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp

from benchmarks import _compiled_c, _mujoco
from benchmarks._tables import Table, number
from benchmarks._timing import taking_turns
from benchmarks._workers import alone
from cdp_ident.model.acting import NO_EFFECTS, ActingEffects
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.formulas.compiled import pushes
from cdp_ident.model.motions import InitialValueProblem, Motions, motions, simulate
from cdp_ident.model.parameters import SYMBOLS, coefficients_of, groups_of, physical_coefficients
from cdp_ident.model.population import Population, Segment
from cdp_ident.model.rates import sine_and_cosine
from cdp_ident.model.time_grid import DEFAULT_STEP, TimeGrid
from reference.pendulum import TABLE_3, TABLE_5, motion
from scenarios.search_problem import LOWER, UPPER
from scenarios.twin import TEN_SECONDS

Array = npt.NDArray[np.float64]

COEFFICIENTS = physical_coefficients(TABLE_5)
START = np.array(TABLE_3)
MEMBERS = 1600
"""Pendulums of a population; where one after another is slow, fewer of them are simulated."""
FEWER = 50
SAME = 1e-9
"""Results of C may differ from ours by so much, relatively: sums are taken in another order."""
WINDOW = TimeGrid.over(np.arange(328) / 200.0)
"""A window of 1.64 s."""
STARTS = START + np.random.default_rng(0).normal(scale=0.05, size=(_compiled_c.WINDOWS, 4))
EFFECTS = (("air_drag.outer.strips",), ("air_drag.outer.strips", "joint_spring.inner", "quadratic_friction.inner"))
"""Effects beside which derivatives are timed: smooth ones, so that the motion takes as many steps as without them."""
NO_COMPILER = "no C compiler"


@numba.njit
def derivative(time, state, coefficients):  # type: ignore[no-untyped-def]
    A23, A33, a1, c1, c2, L, g = coefficients
    theta1, theta2, omega1, omega2 = state
    turned = (*sine_and_cosine(theta1), *sine_and_cosine(theta2))
    n1, n2, m = pushes(0.0, turned, (omega1, omega2), (A23, A33, a1, c1, c2, L, g))
    inverse = 1.0 / (A33 - m * m)
    return np.array([omega1, omega2, (A33 * n1 - m * n2) * inverse, (n2 - m * n1) * inverse])


def by_scipy(coefficients: Array, start: Array, times: Array, method: str = "RK45", tolerance: float = 1e-6) -> Array:
    """Return the states (n, 4) by one of scipy's integrators, of the compiled equations."""
    span = (0.0, float(times[-1]))
    return solve_ivp(
        derivative, span, start, method, t_eval=times, rtol=tolerance, atol=tolerance, args=(coefficients,)
    ).y.T


def by_numpy(coefficients: Array, start: Array, step: float, measured: Array) -> Array:
    """Return the squared errors (members,) of pendulums that are simulated side by side in numpy's arrays."""
    A23, A33, a1, c1, c2, L, g = coefficients.T
    m2_l2 = A23 / L

    def rates(state: Array) -> Array:
        theta1, theta2, omega1, omega2 = state
        s, c = np.sin(theta1 - theta2), np.cos(theta1 - theta2)
        friction = c2 * (omega1 - omega2)
        torque1 = a1 * g * np.sin(theta1) - A23 * s * omega2**2 - c1 * omega1 - friction
        torque2 = m2_l2 * g * np.sin(theta2) + A23 * s * omega1**2 + friction
        coupling = A23 * c
        determinant = A33 - coupling**2
        alpha1 = (A33 * torque1 - coupling * torque2) / determinant
        return np.stack([omega1, omega2, alpha1, (torque2 - coupling * torque1) / determinant])

    state, errors = np.repeat(start[:, None], len(coefficients), axis=1), np.zeros(len(coefficients))
    for row in measured:
        errors += ((state[:2] - row[:, None]) ** 2).sum(axis=0)
        k1 = rates(state)
        k2 = rates(state + 0.5 * step * k1)
        k3 = rates(state + 0.5 * step * k2)
        k4 = rates(state + step * k3)
        state = state + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return errors


def tables(quick: bool = False) -> list[Table]:
    """Measure in a process of one core; that is `quick` as it is."""
    return [table for part in (populations, single_motion, derivatives) for table in alone(part)]


def populations(rounds: int = 5) -> list[Table]:
    """Return the table of many pendulums, each compared with the same measured motion."""
    physical = np.random.default_rng(0).uniform(LOWER, UPPER, (MEMBERS, len(LOWER)))
    coefficients = coefficients_of(groups_of(physical, TABLE_5["L"]), TABLE_5["L"], TABLE_5["g"])
    few = coefficients[:FEWER]
    measured = np.ascontiguousarray(motion(TABLE_5, TABLE_3, TEN_SECONDS)[:, :2])
    population = Population([Segment(START, TEN_SECONDS, measured)])
    models = _mujoco.models_of(
        [TABLE_5 | dict(zip(SYMBOLS, map(float, each), strict=True)) for each in physical[:FEWER]]
    )
    ours = "this package: `Population.squared_errors`"
    works: dict[str, tuple[int, Callable[[], object]]] = {
        ours: (MEMBERS, lambda: population.squared_errors(coefficients)),
        "this package: `simulate`, one after another": (
            FEWER, lambda: [simulate(each, START, TEN_SECONDS) for each in few],
        ),
        "numpy, all members in one array": (MEMBERS, lambda: by_numpy(coefficients, START, DEFAULT_STEP, measured)),
        "`mujoco.rollout`, Runge-Kutta": (FEWER, lambda: _mujoco.rollout(models, START, len(measured) - 1)),
        "scipy `solve_ivp`, RK45, tolerance 1e-6, compiled equations": (
            FEWER // 5, lambda: [by_scipy(each, START, TEN_SECONDS) for each in few[: FEWER // 5]],
        ),
    }  # fmt: skip
    missing = [] if _compiled_c.is_there() else [("C", NO_COMPILER, "", "")]
    if _compiled_c.is_there():
        in_lanes = functools.partial(_compiled_c.population, coefficients, START, DEFAULT_STEP, measured)
        plain = functools.partial(_compiled_c.one_by_one, few, START, DEFAULT_STEP, measured)
        expected = population.squared_errors(coefficients)[:, 0]
        _agree(in_lanes(), expected)
        _agree(plain(), expected[:FEWER])
        works |= {"C, in lanes": (MEMBERS, in_lanes), "C, one after another": (FEWER, plain)}
    _agree(by_numpy(few, START, DEFAULT_STEP, measured), population.squared_errors(few)[:, 0])
    taken = taking_turns({name: work for name, (_, work) in works.items()}, rounds)
    each = {name: taken[name] / count for name, (count, _) in works.items()}
    rows = [
        (name, number(1e6 * time, 3), number(1.0 / time, 3), number(time / each[ours]))
        for name, time in sorted(each.items(), key=lambda item: item[1])
    ]
    return [
        Table(
            f"{MEMBERS} pendulums, 2000 steps each, compared with one measured motion",
            ("", "CPU time of one [µs]", "simulations per second and core", "times as long"),
            [*rows, *missing],
            "All but `solve_ivp` take the same steps.",
        )
    ]


def single_motion(rounds: int = 9) -> list[Table]:
    """Return the table of one motion, and how near to the truth it comes."""
    truth = motion(TABLE_5, TABLE_3, TEN_SECONDS)[:, :2]
    models = _mujoco.models_of([TABLE_5])
    works: dict[str, Callable[[], Array]] = {
        f"this package: `simulate`, step {step * 1e3:g} ms": functools.partial(
            simulate, COEFFICIENTS, START, TEN_SECONDS, None, step
        )
        for step in (DEFAULT_STEP, 0.001)
    }
    works |= {
        f"scipy `solve_ivp` {method}, tolerance {tolerance:g}": functools.partial(
            by_scipy, COEFFICIENTS, START, TEN_SECONDS, method, tolerance
        )
        for method in ("RK45", "DOP853", "LSODA")
        for tolerance in (1e-6, 1e-9)
    }
    works["`mujoco.rollout`, Runge-Kutta, step 5 ms"] = lambda: _mujoco.rollout(models, START, len(truth) - 1)[0]
    taken = taking_turns(works, rounds)
    shortest = next(iter(taken.values()))
    rows = [
        (name, f"{np.abs(work()[:, :2] - truth).max():.0e}", number(1e3 * taken[name]), number(taken[name] / shortest))
        for name, work in works.items()
    ]
    return [
        Table(
            "One motion of 10 s",
            ("", "largest error of an angle [rad]", "CPU time [ms]", "times as long"),
            rows,
            "The error is the difference from a reference of our own that shares no code with the package and is far "
            "finer than any of these. scipy integrates the package's compiled equations.",
        )
    ]


def derivatives(rounds: int = 25) -> list[Table]:
    """Return the table of windows with their derivatives by the start, the coefficients and parameters of effects."""
    u = np.zeros(2 * WINDOW.steps + 1)

    def simulated(effects: ActingEffects = NO_EFFECTS, derive: bool = True) -> Motions:
        return motions([InitialValueProblem(COEFFICIENTS, start, WINDOW, u, effects) for start in STARTS], derive)

    ours = "this package, no effect"
    works: Mapping[str, tuple[int, Callable[[], object]]] = {
        ours: (_compiled_c.DIRECTIONS, simulated),
        "the same without derivatives": (0, lambda: simulated(derive=False)),
        "finite differences of it": (
            _compiled_c.DIRECTIONS, lambda: [simulated(derive=False) for _ in range(1 + _compiled_c.DIRECTIONS)],
        ),
    }  # fmt: skip
    missing = [] if _compiled_c.is_there() else [("C", NO_COMPILER, "", "")]
    if _compiled_c.is_there():
        in_c = functools.partial(_compiled_c.windows, COEFFICIENTS, STARTS, WINDOW)
        # Both absolute angles contain the inner joint's.
        ours_found = simulated()
        for of_c, found in zip(in_c(), (ours_found.readings, ours_found.by), strict=True):
            _agree(of_c.reshape(found.shape), np.cumsum(found, axis=1))
        works = {**works, "C, windows in lanes, no effect": (_compiled_c.DIRECTIONS, in_c)}
    for keys in EFFECTS:
        effects = _effects_of(keys)
        names = f"this package, {'one effect' if len(keys) == 1 else f'{len(keys)} effects'}"
        works = {**works, names: (effects.directions, functools.partial(simulated, effects))}
        works |= {f"{names}, without derivatives": (0, functools.partial(simulated, effects, False))}
    taken = taking_turns({name: work for name, (_, work) in works.items()}, rounds)
    rows = [
        (name, str(count), number(1e9 * taken[name] / (len(STARTS) * WINDOW.steps)), number(taken[name] / taken[ours]))
        for name, (count, _) in works.items()
    ]
    return [
        Table(
            f"{len(STARTS)} windows of {WINDOW.steps} steps, with derivatives",
            ("", "directions", "CPU time of a step [ns]", "times as long"),
            [*rows, *missing],
            f"Effects: {', '.join(f'`{key}`' for key in EFFECTS[-1])}; of one, the first. The C divides no step.",
        )
    ]


def _effects_of(keys: tuple[str, ...]) -> ActingEffects:
    """Return effects of typical strength, all of whose fitted parameters are directions."""
    by_key = {effect.key: effect for effect in CATALOGUE}
    chosen = [(by_key[key], [p.typical for p in by_key[key].parameters]) for key in keys]
    return ActingEffects.of(chosen, TABLE_5["L"], fitted=True)


def _agree(computed: Array, expected: Array) -> None:
    """Make sure that what is compared computes the same.

    Raises:
        ArithmeticError: it does not.
    """
    apart = float(np.abs(computed - expected).max() / np.abs(expected).max())
    if not apart < SAME:
        raise ArithmeticError(f"what is compared differs by {apart:.0e}")

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Swing a fitted pendulum up from hanging and hold it there: a trajectory, and gains along it and after it.

    python3 $(ros2 pkg prefix --share cdp_ident)/examples/swing_up.py identification/one/fitted.yaml --out swing_up.json

The trajectory is found by direct collocation, its gains are those of a time-varying linear-quadratic regulator and a
Kalman filter, and the last ones are lqr.py's. They are tried as there, on the fitted model in full. It moves nothing
real: balance.py does, with the file. It needs CasADi (`pip install casadi`).
"""

import argparse
import ast
import importlib
import sys
from collections.abc import Iterable, Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from lqr import (
    FALLEN,
    JOINT_RATES,
    PERIOD,
    SLOW,
    Controller,
    Design,
    Schedule,
    add_design_arguments,
    balance,
    design_of,
    gain,
    of_surprise,
    upright_schedule,
    write_schedule,
)
from scipy.interpolate import CubicHermiteSpline

from cdp_ident.configuration.fitted_model import FittedModel, read_fitted_model
from cdp_ident.errors import CdpIdentError, OptionError
from cdp_ident.model.formulas.algebra import OPERATIONS, as_number, function_of
from cdp_ident.model.formulas.code import rows_of
from cdp_ident.model.formulas.derivation import Definitions
from cdp_ident.model.formulas.language import ACCELERATIONS, CART, COEFFICIENTS, PAPER, STATE, TORQUE1, TORQUE2
from cdp_ident.rig.emulator.motion import Drive

try:
    casadi: Any = importlib.import_module("casadi")
except ImportError:
    casadi = None

Array = npt.NDArray[np.float64]

DURATIONS = (15.0, 18.0, 21.0)
"""Of the motion, over sqrt(L / g); the first for which a trajectory is found is taken."""
INTERVALS = 100
"""Of the collocation."""
SHARE = 0.7
"""Of the drive's limits that the trajectory uses; the rest is the regulator's."""
MOST_STEPS = 500
"""Of the optimization."""
SMOOTH = 0.02
"""What changes of the acceleration weigh, over sqrt(L / g), beside it."""
AFTERWARDS = 10.0
"""It is to stand for so long when it is tried [s]."""


class RodsMotion:
    """The equations of motion of a fitted model for CasADi, effects included."""

    def __init__(self, fitted: FittedModel) -> None:
        """Make them of the laws' formulas."""
        acting = fitted.motion.acting(fitted.values, fitted.trial())
        angles, unknown = casadi.SX.sym("angles", 4), casadi.SX.sym("accelerations", 3)
        u, directions = casadi.SX.sym("u"), casadi.SX.sym("directions", 2)
        given = dict(zip(STATE, casadi.vertsplit(angles), strict=True))
        given |= zip(ACCELERATIONS, casadi.vertsplit(unknown), strict=True)
        given |= zip(COEFFICIENTS, fitted.coefficients.tolist(), strict=True)
        for k in range(2):
            given |= {f"sin{k + 1}": casadi.sin(angles[k]), f"cos{k + 1}": casadi.cos(angles[k])}
        given |= zip(("direction_inner", "direction_outer"), casadi.vertsplit(directions), strict=True)
        given |= {"outer_length": acting.outer_length, "carried": acting.carried}
        left = [*_values(Definitions("the equations of motion"), PAPER, given), u - unknown[2]]
        self.left_out: list[str] = []
        """Effects that move the rods and are not in here: those with a state of their own, and curves."""
        for effect, values in acting.each():
            if not effect.moves:
                continue
            if effect.states or effect.curve:
                self.left_out.append(effect.key)
                continue
            definitions, rows = Definitions(effect.key, effect.joint), rows_of(effect)
            for parameter in effect.parameters:
                definitions.add_input(parameter.name)
            for name, text in effect.law.where:
                definitions.add(name, text)
            of_effect = given | {p.name: value for p, value in zip(effect.parameters, values, strict=True)}
            for row, value in zip(rows, _values(definitions, rows.values(), of_effect), strict=True):
                for place, sums in enumerate((TORQUE1, TORQUE2, CART)):
                    left[place] += value if row == sums else 0.0
        residual = casadi.vertcat(*left)  # it is linear in the accelerations
        at_zero = casadi.substitute(residual, unknown, casadi.DM.zeros(3))
        found = -casadi.solve(casadi.jacobian(residual, unknown), at_zero)[:2]
        self.accelerations = casadi.Function("accelerations", [angles, u, directions], [found])
        """Of theta1 and theta2, from (theta1, theta2, omega1, omega2), the cart's acceleration, and the directions in
        which the joints slip: numbers from -1 to 1."""


def _values(definitions: Definitions, formulas: Iterable[str], given: Mapping[str, Any]) -> list[Any]:
    """Return the values of formulas, given those of the words in them."""
    trees = [definitions.value("formula", text) for text in formulas]
    known = {"pi": np.pi, **given}
    for name, tree in definitions.needed(trees).items():
        known[name] = _value(tree, known)
    return [_value(tree, known) for tree in trees]


def _value(tree: ast.expr, known: Mapping[str, Any]) -> Any:
    number = as_number(tree)
    if number is not None:
        return number
    if isinstance(tree, ast.Name):
        return known[tree.id]
    if isinstance(tree, ast.UnaryOp):
        return -_value(tree.operand, known)
    if isinstance(tree, ast.BinOp):
        operation = pow if isinstance(tree.op, ast.Pow) else OPERATIONS[type(tree.op)]
        return operation(_value(tree.left, known), _value(tree.right, known))
    (argument,) = (_value(part, known) for part in tree.args)
    name = function_of(tree)
    return argument >= 0 if name == "step" else getattr(casadi, "fabs" if name == "abs" else name)(argument)


class Motion(NamedTuple):
    """A motion from hanging to upright, between nodes in time."""

    nodes: Array
    """(n,) [s]"""
    states: Array
    """(n, 6) x, theta1, theta2 and their rates."""
    inputs: Array
    """(n,) acceleration of the cart [m/s^2], linear between the nodes."""
    linear: Any
    """Function of CasADi of a state and an input: the rates of the state, and their derivatives by both, and by the
    directions in which the joints slip."""


def trajectory(fitted: FittedModel, end: Array, drive: Drive) -> Motion:
    """Return a motion from hanging to theta1, theta2 `end` (2,), at rest there: by Hermite and Simpson's collocation.

    Accelerations of the cart, and their changes, are as small as can be.

    Raises:
        OptionError: none was found within the drive's limits.
    """
    length, gravity = fitted.coefficients[-2:]
    unit = float(np.sqrt(length / gravity))
    state, a, slips = casadi.SX.sym("state", 6), casadi.SX.sym("a"), casadi.SX.sym("slips", 2)
    alphas = RodsMotion(fitted).accelerations(casadi.vertcat(state[1:3], state[4:]), a, slips)
    slipping = casadi.tanh(casadi.mtimes(JOINT_RATES, state[4:]) / SLOW)
    rates = casadi.vertcat(state[3:], a, alphas)
    derivatives = [casadi.jacobian(rates, of) for of in (state, a, slips)]
    whole = [casadi.substitute(of, slips, slipping) for of in (rates, *derivatives)]
    linear, rate = casadi.Function("linear", [state, a], whole), casadi.Function("rate", [state, a], whole[:1])

    following, next_a, step = casadi.SX.sym("following", 6), casadi.SX.sym("next_a"), casadi.SX.sym("step")
    first, last = rate(state, a), rate(following, next_a)
    middle = rate((state + following) / 2 + step / 8 * (first - last), (a + next_a) / 2)
    gap = following - state - step / 6 * (first + 4 * middle + last)
    gaps = casadi.Function("gap", [state, a, following, next_a, step], [gap]).map(INTERVALS)
    states, inputs = casadi.MX.sym("states", 6, INTERVALS + 1), casadi.MX.sym("inputs", 1, INTERVALS + 1)
    duration = casadi.MX.sym("duration")
    spacing = duration / INTERVALS
    changes = (inputs[:, 1:] - inputs[:, :-1]) * (unit / spacing)
    problem = {
        "x": casadi.veccat(states, inputs),
        "p": duration,
        "f": spacing / unit * (casadi.sumsqr(inputs) + SMOOTH * casadi.sumsqr(changes)) / drive.acceleration**2,
        "g": casadi.vec(gaps(states[:, :-1], inputs[:, :-1], states[:, 1:], inputs[:, 1:], spacing)),
    }
    quiet = {"print_time": False, "ipopt": {"print_level": 0, "sb": "yes", "max_iter": MOST_STEPS}}
    solver = casadi.nlpsol("solver", "ipopt", problem, quiet)
    begin = np.array([0.0, np.pi, np.pi, 0.0, 0.0, 0.0])
    ends = np.stack([begin, [0.0, *end, 0.0, 0.0, 0.0]])
    upper = np.full((INTERVALS + 1, 6), np.inf)
    upper[:, [0, 3]] = SHARE * drive.rail, SHARE * drive.speed
    lower, most = -upper, np.full(INTERVALS + 1, SHARE * drive.acceleration)
    lower[[0, -1]] = upper[[0, -1]] = ends
    most[[0, -1]] = 0.0
    straight = begin + np.linspace(0.0, 1.0, INTERVALS + 1)[:, None] * (ends[1] - begin)
    for units in DURATIONS:
        found = solver(
            x0=np.concatenate([straight.ravel(), 0.0 * most]), p=units * unit, lbg=0.0, ubg=0.0,
            lbx=np.concatenate([lower.ravel(), -most]), ubx=np.concatenate([upper.ravel(), most]),
        )  # fmt: skip
        if solver.stats()["success"]:
            numbers, nodes = np.array(found["x"]).ravel(), np.linspace(0.0, units * unit, INTERVALS + 1)
            return Motion(nodes, numbers[: upper.size].reshape(-1, 6), numbers[upper.size :], linear)
    raise OptionError("no motion from hanging to upright was found within the drive's limits")


def swing_up_schedule(fitted: FittedModel, design: Design = Design()) -> Schedule:  # noqa: B008
    """Return how the rods are swung up, and then held upright.

    Raises:
        OptionError: the cart cannot do it, or CasADi is not installed.
    """
    if casadi is None:
        raise OptionError("CasADi is not installed, which finds the trajectory: pip install casadi")
    last, P = upright_schedule(fitted, design)
    motion = trajectory(fitted, last.states[0, 1:3], design.drive)

    period, delay = design.period, design.delay
    nodes, count = motion.nodes, int(np.ceil(motion.nodes[-1] / period))
    rates = np.array(motion.linear.map(len(nodes))(motion.states.T, motion.inputs)[0]).T
    along, slopes = CubicHermiteSpline(nodes, motion.states, rates), np.diff(motion.inputs) / np.diff(nodes)
    # It begins as soon as a command can act; each makes up for the drive's lag.
    samples = period * np.maximum(np.arange(count + delay) - delay, 0.0)
    middles = np.minimum(period * (np.arange(count) + 0.5), nodes[-1])
    commands = np.interp(middles, nodes, motion.inputs)
    commands += design.drive.lag * slopes[np.minimum(np.searchsorted(nodes, middles) - 1, INTERVALS - 1)]
    commands = np.concatenate([commands, np.zeros(delay)])
    states = np.zeros((count + delay, 7 + delay))
    states[:, :6], states[:, 6] = along(samples), np.interp(samples, nodes, motion.inputs)
    for place in range(delay):
        states[delay - place :, 7 + place] = commands[: len(commands) - delay + place]
    at = np.minimum(samples + 0.5 * period, nodes[-1])
    derivatives = motion.linear.map(len(at))(along(at).T, np.interp(at, nodes, motion.inputs))[1:]
    A, B, slips = (np.array(of).reshape(6, len(at), -1).transpose(1, 0, 2) for of in derivatives)
    (F, G), (Q, R), (W, V) = design.sampled(A, B), design.weights, design.noises
    gains, filters = np.empty_like(states), np.empty((*states.shape, 3))
    for k in reversed(range(len(states))):
        gains[k] = gain(P, F[k], G[k], R)
        P = Q + F[k].T @ P @ (F[k] - np.outer(G[k], gains[k]))
    S = np.diag([*np.diag(V), *np.zeros(4 + delay)])
    for k in range(len(states)):
        filters[k] = of_surprise(S, V)
        S = F[k] @ (S - filters[k] @ S[:3]) @ F[k].T + W
    own = Schedule(states, commands, F, G, gains, filters, design.of_friction(slips[:, 4:]))
    return Schedule(*(np.concatenate([getattr(of, field.name) for of in (own, last)]) for field in fields(Schedule)))


def main(arguments: list[str]) -> int:
    """Design, write, try, and tell how it went; return 1 where the rods fell."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_design_arguments(parser)
    parser.add_argument("--out", type=Path, metavar="FILE", help="JSON file to write")
    parser.add_argument("--force", action="store_true", help="replace a file that is there already")
    options = parser.parse_args(arguments)
    if options.out is not None and options.out.exists() and not options.force:
        parser.error(f"{options.out} is there already: give another --out, or --force to replace it")
    try:
        fitted = read_fitted_model(options.fitted, "swing_up")
        schedule = swing_up_schedule(fitted, design_of(options))
        if options.out is not None:
            write_schedule(options.out, schedule)
    except CdpIdentError as error:
        parser.error(str(error))
    duration = PERIOD * (len(schedule.states) - 1)
    travel, fastest = np.ptp(schedule.states[:, 0]), np.abs(schedule.states[:, 3]).max()
    for key in RodsMotion(fitted).left_out:
        print(f"left out of the plan: {key}")
    print(f"planned: upright after {duration:.2f} s, the cart moves {travel:.3f} m, at most at {fastest:.2f} m/s")

    seconds = duration + AFTERWARDS
    deviations, commands = balance(fitted, Controller(schedule), np.full(2, np.pi), seconds)
    degrees = np.degrees(np.abs(deviations[:, 1:]).max(axis=1))
    print(f"commanded at most {np.abs(commands).max():.2f} m/s^2, at most {degrees.max():.2g} degrees off the plan")
    if degrees[-1] > np.degrees(FALLEN):
        print(f"lost after {PERIOD * len(deviations):.2f} s")
        return 1
    print(f"stood until {seconds:.1f} s, within {degrees[-round(1.0 / PERIOD) :].max():.2g} degrees in the last second")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

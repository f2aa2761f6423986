# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What one who knows chaotic motions writes: multiple shooting, by CasADi with IPOPT and by scipy.

The swing is cut into windows. Each has a state of its own at its beginning, which is fitted beside the five base
parameters; in the end every window begins where the one before it ends, so that it is one motion again. Both begin with
states that are filtered from the measured angles, take steps of one sample of the classical Runge-Kutta method, have
exact derivatives, and weigh what either encoder shows alike.
"""

import importlib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import savgol_filter

from reference.pendulum import TABLE_2, Array

try:
    casadi: Any = importlib.import_module("casadi")  # mypy would find what it has, or nothing, as it is installed
except ImportError:
    casadi = None

NOISE = 2.3e-4
"""Of both encoders [rad]: of one count of 8000, over sqrt(12)."""
CASADI_WINDOW = 20
"""Samples: short windows make its problem large, but sparse and nearly linear."""
SCIPY_WINDOW = 100
"""Samples: its problem is dense."""
JOINS = (1.0, 1e2, 1e4)
"""Weights of the gaps between windows over that of an encoder's error, one after another: at last there are none."""
_FILTER = 21
"""Samples of the Savitzky-Golay filter: a tenth of a second."""
_TINY = 1e-30
"""Imaginary step by which scipy's derivatives are taken: no digit is lost."""


def has_casadi() -> bool:
    """Return whether CasADi is installed."""
    return casadi is not None


def filtered(time: Array, theta: Array) -> Array:
    """Return theta1, theta2 [rad], omega1, omega2 [rad/s] of measured angles (n, 2) at each sample (n, 4)."""
    spacing = _spacing(time)
    return np.column_stack([savgol_filter(theta, _FILTER, 3, deriv=order, delta=spacing, axis=0) for order in (0, 1)])


def by_casadi(time: Array, theta: Array, groups: Array) -> Array:
    """Return the base parameters (5,) by IPOPT: gaps are constraints, the Hessian is that of Gauss and Newton.

    Raises:
        ArithmeticError: it did not converge.
    """
    count = -(-len(time) // CASADI_WINDOW)
    state, values = casadi.SX.sym("state", 4), casadi.SX.sym("values", 5)
    shown, end = [], state
    for _ in range(CASADI_WINDOW):
        shown += [end[0], end[1] - end[0]]
        end = casadi.vertcat(*_step(casadi.vertsplit(end), casadi.vertsplit(values), _spacing(time), casadi))
    windows = casadi.Function("window", [state, values], [end, casadi.vertcat(*shown)]).map(count)
    scales, starts = casadi.MX.sym("scales", 5), casadi.MX.sym("starts", 4, count)
    ends, readings = windows(starts, casadi.repmat(scales * groups, 1, count))
    errors = (casadi.vec(readings)[: 2 * len(time)] - _readings(theta).ravel()) / NOISE
    unknowns = casadi.veccat(scales, starts)
    gaps = casadi.vec(ends[:, :-1] - starts[:, 1:])
    by_unknowns = casadi.jacobian(errors, unknowns)
    of_objective, of_gaps = casadi.MX.sym("of_objective"), casadi.MX.sym("of_gaps", gaps.numel())
    hessian = casadi.Function(
        "nlp_hess_l",
        [unknowns, casadi.MX(0, 0), of_objective, of_gaps],
        [of_objective * casadi.triu(by_unknowns.T @ by_unknowns)],
    )
    solver = casadi.nlpsol(
        "solver",
        "ipopt",
        {"x": unknowns, "f": casadi.sumsqr(errors) / 2, "g": gaps},
        {"hess_lag": hessian, "print_time": False, "ipopt": {"print_level": 0, "sb": "yes"}},
    )
    begin = np.concatenate([np.ones(5), filtered(time, theta)[::CASADI_WINDOW].ravel()])
    found = np.array(solver(x0=begin, lbg=0.0, ubg=0.0)["x"]).ravel()
    if not solver.stats()["success"]:
        raise ArithmeticError(solver.stats()["return_status"])
    return np.asarray(found[:5] * groups)


def by_scipy(time: Array, theta: Array, groups: Array) -> Array:
    """Return the base parameters (5,) by `least_squares`: gaps are residuals, which weigh more and more."""
    starts = filtered(time, theta)[::SCIPY_WINDOW]
    windows = _Windows(_spacing(time), _readings(theta), groups)
    unknowns = np.concatenate([np.ones(5), starts.ravel()])
    for join in JOINS:
        unknowns = least_squares(
            windows.residuals, unknowns, windows.derivatives, x_scale="jac", method="lm", args=(join,)
        ).x
    return np.asarray(unknowns[:5] * groups)


@dataclass(frozen=True)
class _Windows:
    """Residuals of unknowns: factors on the base parameters (5,), and the state at the beginning of each window.

    They are the errors of a window's readings and the gaps at its end, window after window, over the encoders' noise;
    they end with the last reading.
    """

    spacing: float
    readings: Array
    groups: Array

    def residuals(self, unknowns: Array, join: float) -> Array:
        """Return the residuals, gaps weighed by `join`."""
        starts = unknowns[5:].reshape(-1, 4)
        shown, ends = self._simulated(unknowns[:5], starts.T)
        measured = np.zeros(shown.shape)
        measured.reshape(-1)[: self.readings.size] = self.readings.ravel()
        gaps = join * (ends - np.concatenate([starts[1:], starts[:1]]))
        return np.concatenate([shown - measured, gaps], axis=1).ravel()[: self._size(len(starts))] / NOISE

    def derivatives(self, unknowns: Array, join: float) -> Array:
        """Return their derivatives by the unknowns."""
        starts = unknowns[5:].reshape(-1, 4)
        steps = 1j * _TINY * np.eye(9)  # all windows' starts at once
        shown, ends = self._simulated(unknowns[:5, None] + steps[:5], starts.T[..., None] + steps[5:, None])
        by_own = np.concatenate([shown, join * ends], axis=1).imag / _TINY
        each = np.arange(len(starts))
        by_starts = np.zeros((*by_own.shape[:2], len(starts), 4))
        by_starts[each, :, each] = by_own[..., 5:]
        by_starts[each[:-1], -4:, each[1:]] -= join * np.eye(4)
        by = np.concatenate([by_own[..., :5], by_starts.reshape(*by_own.shape[:2], -1)], axis=-1)
        return np.asarray(by.reshape(-1, len(unknowns))[: self._size(len(starts))] / NOISE)

    def _simulated(self, factors: Any, starts: Any) -> tuple[Any, Any]:
        """Return each window's readings (windows, 2 samples, ...) and the state at its end (windows, 4, ...)."""
        values = (factors.T * self.groups).T
        state, shown = list(starts), []
        for _ in range(SCIPY_WINDOW):
            shown += [state[0], state[1] - state[0]]
            state = _step(state, list(values), self.spacing, np)
        return np.stack(shown, axis=1), np.stack(state, axis=1)

    def _size(self, windows: int) -> int:
        return self.readings.size + 4 * (windows - 1)


def _step(state: Sequence[Any], values: Sequence[Any], spacing: float, functions: Any) -> list[Any]:
    """Return the state after a step of the classical Runge-Kutta method; `functions` has sin and cos."""

    def after(slopes: Sequence[Any], step: float) -> list[Any]:
        return [x + step * slope for x, slope in zip(state, slopes, strict=True)]

    first = _slopes(state, values, functions)
    second = _slopes(after(first, spacing / 2), values, functions)
    third = _slopes(after(second, spacing / 2), values, functions)
    fourth = _slopes(after(third, spacing), values, functions)
    slopes = zip(first, second, third, fourth, strict=True)
    return after([(a + 2 * b + 2 * c + d) / 6 for a, b, c, d in slopes], spacing)


def _slopes(state: Sequence[Any], values: Sequence[Any], functions: Any) -> list[Any]:
    """Return the derivatives of a state by time: the paper's equations of motion, all over A22."""
    theta1, theta2, omega1, omega2 = state
    A23, A33, a1, c1, c2 = values
    length, gravity = TABLE_2["L"], TABLE_2["g"]
    coupling, whirl = A23 * functions.cos(theta1 - theta2), A23 * functions.sin(theta1 - theta2)
    rub = c2 * (omega1 - omega2)
    torque1 = a1 * gravity * functions.sin(theta1) - whirl * omega2**2 - c1 * omega1 - rub
    torque2 = A23 / length * gravity * functions.sin(theta2) + whirl * omega1**2 + rub
    determinant = A33 - coupling**2
    return [
        omega1,
        omega2,
        (A33 * torque1 - coupling * torque2) / determinant,
        (torque2 - coupling * torque1) / determinant,
    ]


def _readings(theta: Array) -> Array:
    """Return what the encoders of both joints show (n, 2)."""
    return np.diff(theta, axis=1, prepend=0.0)


def _spacing(time: Array) -> float:
    return float(np.median(np.diff(time)))

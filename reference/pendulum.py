# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The cart double pendulum from its Lagrangian, integrated far more finely than the package does.

Nothing here comes from `cdp_ident.model`, so that an error cannot be in both: sympy derives the equations of motion
from the positions of the masses, and scipy's DOP853 integrates them.
"""

import functools
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import sympy
from scipy.integrate import solve_ivp

Array = npt.NDArray[np.float64]
Torque = Callable[[float, Array], tuple[float, float]]

TIME = sympy.Symbol("t", real=True)
"""What a cart's motion is an expression of [s]; for example `0.05 * sympy.sin(3 * TIME)` [m]."""
AT_REST = sympy.Integer(0)

SYMBOLS = ("m1", "m2", "m0", "l1", "l2", "J1", "J2", "c1", "c2", "L", "g")
TABLE_2 = dict(
    zip(SYMBOLS, (0.108, 0.108, 0.208, 0.2, 0.2, 0.00133, 0.00133, 0.00705, 0.00305, 0.4, 9.81), strict=True)
)
"""The paper's estimates."""
TABLE_5 = dict(
    zip(SYMBOLS, (0.1296, 0.1154, 0.2192, 0.2007, 0.1691, 0.0007, 0.0016, 0.0049, 0.0006, 0.4, 9.81), strict=True)
)
"""What the paper's improved algorithm found in the end (last row), with Table 2's L."""
TABLE_3 = (3.36093, 3.88832, -3.45705, 11.15684)
"""The paper's start: theta1, theta2 [rad], their derivatives [rad/s]."""


class _Mechanics:
    """The equations of motion as functions of numbers, derived once."""

    def __init__(self) -> None:
        constants = sympy.symbols(SYMBOLS, positive=True)
        m1, m2, m0, l1, l2, J1, J2, c1, c2, L, g = constants
        x, theta1, theta2 = (sympy.Function(name)(TIME) for name in ("x", "theta1", "theta2"))
        angles = (theta1, theta2)
        rates = [angle.diff(TIME) for angle in angles]

        def along(angle: Any, distance: Any) -> sympy.Matrix:
            return sympy.Matrix([distance * sympy.sin(angle), distance * sympy.cos(angle)])

        base = sympy.Matrix([x, 0])
        joint = base + along(theta1, L)
        bodies = ((m1, base + along(theta1, l1)), (m0, joint), (m2, joint + along(theta2, l2)))
        kinetic = (J1 * rates[0] ** 2 + J2 * rates[1] ** 2) / 2 + sum(
            mass * place.diff(TIME).dot(place.diff(TIME)) / 2 for mass, place in bodies
        )
        potential = sum(mass * g * place[1] for mass, place in bodies)
        dissipation = (c1 * rates[0] ** 2 + c2 * (rates[1] - rates[0]) ** 2) / 2
        lagrangian = kinetic - potential

        u = sympy.Symbol("u")
        plain = sympy.symbols("theta1 theta2 omega1 omega2 alpha1 alpha2")
        values = [
            (x.diff(TIME, 2), u),
            *zip([angle.diff(TIME, 2) for angle in angles], plain[4:], strict=True),
            *zip(rates, plain[2:4], strict=True),
            *zip(angles, plain[:2], strict=True),
        ]
        balance = sympy.Matrix(
            [
                lagrangian.diff(rate).diff(TIME) - lagrangian.diff(angle) + dissipation.diff(rate)
                for angle, rate in zip(angles, rates, strict=True)
            ]
        )
        # Any steady motion of the cart adds or takes nothing (Galilei), so its speed cancels.
        balance = balance.subs(values).expand().subs(x.diff(TIME), 0)
        inertia = balance.jacobian(plain[4:])
        torque = -balance.subs(dict.fromkeys(plain[4:], 0))
        at = (*plain[:4], u, *constants)
        self.inertia_and_torque = sympy.lambdify(at, (*inertia, *torque), modules="math", cse=True)
        still = (kinetic + potential).subs(values).subs(x.diff(TIME), 0)
        self.energy = sympy.lambdify((*plain[:4], *constants), still, modules="numpy")


@functools.cache
def _mechanics() -> _Mechanics:
    return _Mechanics()


def accelerations(
    values: Mapping[str, float], state: Array, u: float, torque: tuple[float, float] = (0.0, 0.0)
) -> tuple[float, float]:
    """Return the angular accelerations [rad/s^2] of one state (4,), for a cart accelerated by u [m/s^2].

    `torque` is what acts on theta1 and theta2 beside gravity and friction [N m].
    """
    M11, M12, _, M22, f1, f2 = _mechanics().inertia_and_torque(*state, u, *(values[symbol] for symbol in SYMBOLS))
    f1, f2 = f1 + torque[0], f2 + torque[1]
    determinant = M11 * M22 - M12 * M12
    return (M22 * f1 - M12 * f2) / determinant, (M11 * f2 - M12 * f1) / determinant


def energy(values: Mapping[str, float], states: Array) -> Array:
    """Return the mechanical energy [J] of states (..., 4) over a cart at rest."""
    return np.asarray(_mechanics().energy(*np.moveaxis(states, -1, 0), *(values[symbol] for symbol in SYMBOLS)))


def cart_position(cart: sympy.Expr, times: Array) -> Array:
    """Return the cart's position [m] at times (n,) from its expression of `TIME`."""
    return np.broadcast_to(np.asarray(sympy.lambdify(TIME, cart, "numpy")(times), dtype=float), times.shape)


def cart_acceleration(cart: sympy.Expr, times: Array) -> Array:
    """Return the cart's acceleration [m/s^2] at times (n,) from its position's expression of `TIME`."""
    return cart_position(sympy.diff(cart, TIME, 2), times)


def motion(
    values: Mapping[str, float],
    start: tuple[float, float, float, float] | Array,
    times: Array,
    cart: sympy.Expr = AT_REST,
    torque: Torque | None = None,
    tolerance: float = 1e-12,
) -> Array:
    """Return the states (n, 4) at times (n,) from 0 on: theta1, theta2 [rad], omega1, omega2 [rad/s].

    Args:
        values: the physical values of all `SYMBOLS`.
        start: (4,) state at time 0.
        times: (n,) ascending times [s].
        cart: the cart's position [m] as an expression of `TIME`.
        torque: what else acts on theta1 and theta2 [N m], from time and state (4,): an effect to be discovered.
        tolerance: relative and absolute tolerance of the integrator.

    Raises:
        ArithmeticError: the integrator could not hold its tolerance.
    """
    u = sympy.lambdify(TIME, sympy.diff(cart, TIME, 2), "math")

    def derivative(t: float, state: Array) -> tuple[float, float, float, float]:
        extra = (0.0, 0.0) if torque is None else torque(t, state)
        return state[2], state[3], *accelerations(values, state, u(t), extra)

    end = float(times[-1])
    if end == 0.0:
        return np.broadcast_to(np.asarray(start, dtype=float), (len(times), 4))
    solution = solve_ivp(
        derivative, (0.0, end), start, method="DOP853", t_eval=times, rtol=tolerance, atol=tolerance, max_step=0.05
    )
    if not solution.success:
        raise ArithmeticError(solution.message)
    return np.asarray(solution.y.T)

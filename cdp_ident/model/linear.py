# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The linear model for small motions about an equilibrium, for controller design.

The equations of motion about angles at which the rods can rest, in the form x' = A x + B u, y = C x + D u, where u is
the cart's acceleration.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import optimize

from cdp_ident.arrays import Array
from cdp_ident.errors import OptionError
from cdp_ident.model.acting import NO_EFFECTS, ActingEffects
from cdp_ident.model.effects.effect import Effect
from cdp_ident.model.motions import accelerations_at, jacobians_at
from cdp_ident.model.parameters import COEFFICIENTS

STATES = {"x": "m", "theta1": "rad", "theta2": "rad", "x'": "m/s", "theta1'": "rad/s", "theta2'": "rad/s"}
"""Name and unit of each state: the cart's position, the rods' absolute angles, and their rates of change."""
INPUTS = {"u": "m/s^2"}
"""The cart's acceleration."""
OUTPUTS = {"x": "m", "theta1": "rad", "theta2": "rad"}
"""What encoders measure, as the model's absolute angles."""

_NEAR = 0.3
"""How far effects may shift an equilibrium before it is another one [rad]."""
_ROUNDING = 1e-12
"""Less than this is rounding [rad/s^2]."""
_AT_REST = 1e-9
"""Acceleration at which a rod counts as resting, as a share of g a1 / A22, which is near the largest there is."""


@dataclass(frozen=True)
class Mode:
    """One way in which small motions decay, swing or grow."""

    eigenvalue: complex
    """[1/s] Of a pair of conjugates, that with the positive imaginary part."""

    @property
    def frequency(self) -> float:
        """Undamped natural frequency [rad/s]."""
        return abs(self.eigenvalue)

    @property
    def damping(self) -> float:
        """Damping ratio: at least 1 without oscillation, negative for unstable modes; 1 for an eigenvalue of 0."""
        return -self.eigenvalue.real / self.frequency if self.frequency else 1.0


@dataclass(frozen=True)
class LinearModel:
    """A linear time-invariant model about an equilibrium, in deviations from it: `scipy.signal.StateSpace(A, B, C, D)`.

    States, inputs and outputs are `STATES`, `INPUTS` and `OUTPUTS`, in their order.
    """

    theta: Array
    """(2,) theta1 and theta2 at the equilibrium [rad]; its cart may rest anywhere."""
    A: Array
    """(6, 6)"""
    B: Array
    """(6, 1)"""

    @property
    def C(self) -> Array:  # noqa: N802 - the usual name
        """(3, 6)."""
        return np.eye(len(OUTPUTS), len(STATES))

    @property
    def D(self) -> Array:  # noqa: N802
        """(3, 1)."""
        return np.zeros((len(OUTPUTS), len(INPUTS)))

    @property
    def modes(self) -> tuple[Mode, ...]:
        """The rods' modes, the slowest first; the cart's own, which stays where it is put, is not among them."""
        rods = np.ix_([1, 2, 4, 5], [1, 2, 4, 5])
        eigenvalues = np.linalg.eigvals(self.A[rods])
        return tuple(Mode(complex(value)) for value in sorted(eigenvalues, key=abs) if value.imag >= 0.0)

    @property
    def controllability(self) -> float:
        """How far the model is from one that the cart cannot control: the test of Popov, Belevitch and Hautus.

        The smallest singular value of [A - s I, B] over the eigenvalues s of A: zero where a mode cannot be moved by
        the cart at all.
        """
        identity = np.eye(len(STATES))
        pencils = [np.hstack([self.A - s * identity, self.B]) for s in np.linalg.eigvals(self.A)]
        return float(min(np.linalg.svd(pencil, compute_uv=False)[-1] for pencil in pencils))

    @property
    def controllable(self) -> bool:
        """Whether the cart can move every mode, to numerical precision."""
        return self.controllability > 1e-9 * float(np.linalg.norm(self.A, 2))


def linearize(coefficients: Array, near: tuple[float, float], effects: ActingEffects = NO_EFFECTS) -> LinearModel:
    """Return the linear model about the equilibrium near given angles.

    Effects may shift the equilibrium (a base that is not level, a spring): it is then found anew.

    Args:
        coefficients: (7,) `COEFFICIENTS` of the pendulum.
        near: theta1, theta2 [rad], one of `EQUILIBRIA`.
        effects: that act; those without a part in small motions are left out, see `without_linear_part`.

    Raises:
        OptionError: the rods have no equilibrium near these angles.
    """
    left_out = without_linear_part(coefficients, near, effects)
    linear = effects.only(lambda effect: effect not in left_out)
    theta = _equilibrium(coefficients, near, linear)
    rest = np.array([*theta, 0.0, 0.0])
    A = np.zeros((len(STATES), len(STATES)))
    A[:3, 3:] = np.eye(3)
    A[np.ix_([4, 5], [1, 2, 4, 5])] = jacobians_at(coefficients, rest[None], linear)[0]
    pushed = accelerations_at(coefficients, np.stack([rest, rest]), np.array([0.0, 1.0]), linear)
    B = np.zeros((len(STATES), len(INPUTS)))
    B[3:, 0] = 1.0, *(pushed[1] - pushed[0])
    return LinearModel(theta, A, B)


def without_linear_part(coefficients: Array, near: tuple[float, float], effects: ActingEffects) -> list[Effect]:
    """Return the effects that have no part in small motions near given angles.

    Errors of encoders and dry friction are such, and drag, which grows with the square of a speed: at rest they change
    neither the accelerations nor their derivatives.
    """
    states = np.array([[*near, 0.0, 0.0]])

    def felt(wanted: Callable[[Effect], bool]) -> Array:
        acting = effects.only(wanted)
        rates = accelerations_at(coefficients, states, np.zeros(1), acting)
        return np.append(rates, jacobians_at(coefficients, states, acting))

    def has_linear_part(effect: Effect) -> bool:
        if not effect.moves or effect.dry or effect.at_an_instant or effect.states:
            return False
        return bool(np.abs(felt(lambda other: other == effect) - felt(lambda other: False)).max() > _ROUNDING)

    return [effect for effect, _ in effects.each() if not has_linear_part(effect)]


def _equilibrium(coefficients: Array, near: tuple[float, float], effects: ActingEffects) -> Array:
    def at_rest(theta: Array) -> Array:
        return accelerations_at(coefficients, np.array([[*theta, 0.0, 0.0]]), np.zeros(1), effects)[0]

    gravity = coefficients[COEFFICIENTS.index("g")] * coefficients[COEFFICIENTS.index("a1_over_A22")]
    solution = optimize.root(at_rest, near, tol=1e-13)
    shift = np.abs(solution.x - near).max()
    if not shift < _NEAR or not np.abs(solution.fun).max() < _AT_REST * gravity:
        raise OptionError(
            f"the rods do not rest anywhere within {_NEAR} rad of theta1 = {near[0]:.4g}, theta2 = {near[1]:.4g}: the "
            "effects in the model are stronger than gravity there; look at effects.* in the file of the fitted model"
        )
    return np.asarray(solution.x)

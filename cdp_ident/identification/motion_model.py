"""The model as the refinement sees it: numbers to adjust, and the motion and its derivatives that follow from them."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.identification.windows import Window
from cdp_ident.model.parameters import COEFFICIENTS, GROUPS, coefficients_of
from cdp_ident.model.sensitivity import DIRECTIONS, simulate_with_sensitivities

Array = npt.NDArray[np.float64]

STATE = 4
"""Numbers in a start: theta1, theta2, omega1, omega2."""
_A23, _OUTER_MOMENT, _GRAVITY = (COEFFICIENTS.index(name) for name in ("A23_over_A22", "m2_l2_over_A22", "g"))


@dataclass(frozen=True)
class MotionModel:
    """The paper's model. Its unknowns are the five groups, and on request the length L and gravity g."""

    length: float
    """L [m], or the value to begin with where it is free."""
    gravity: float
    """g [m/s^2], or the value to begin with where it is free."""
    length_free: bool = False
    gravity_free: bool = False

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the unknowns, in the order of their values."""
        return (
            *(group.symbol for group in GROUPS),
            *(("L",) if self.length_free else ()),
            *(("g",) if self.gravity_free else ()),
        )

    def beginning(self, groups: Array) -> Array:
        """Return the values of the unknowns for given groups (5,), with L and g as they are known beforehand."""
        return np.concatenate([groups, [self.length] * self.length_free, [self.gravity] * self.gravity_free])

    def constants(self, values: Array) -> tuple[float, float]:
        """Return L [m] and g [m/s^2] under given values of the unknowns."""
        length = float(values[len(GROUPS)]) if self.length_free else self.length
        return length, float(values[-1]) if self.gravity_free else self.gravity

    def coefficients(self, values: Array) -> Array:
        """Return the model's coefficients (7,) under given values of the unknowns."""
        return coefficients_of(values[: len(GROUPS)], *self.constants(values))

    @property
    def limits(self) -> tuple[Array, Array]:
        """Lowest and highest value of each unknown: inertias, moments and frictions are not negative."""
        count = len(self.names)
        return np.zeros(count), np.full(count, np.inf)

    def predict(self, values: Array, start: Array, window: Window) -> tuple[Array, Array]:
        """Return the angles in a window and their derivatives.

        Returns:
            Angles (n, 2) [rad] and their derivatives (n, 2, 4 + unknowns) with respect to the start and the unknowns.
        """
        theta = np.empty_like(window.theta)
        directions = np.empty((*theta.shape, DIRECTIONS))
        simulate_with_sensitivities(self.coefficients(values), start, window.grid, window.u, theta, directions)
        return theta, np.concatenate([directions[..., :STATE], directions[..., STATE:] @ self.chain(values)], axis=2)

    def chain(self, values: Array) -> Array:
        """Return the derivatives (7, unknowns) of the coefficients with respect to the unknowns."""
        length, _ = self.constants(values)
        chain = np.zeros((len(COEFFICIENTS), len(self.names)))
        chain[: len(GROUPS), : len(GROUPS)] = np.eye(len(GROUPS))
        chain[_OUTER_MOMENT, _A23] = 1.0 / length
        if self.length_free:
            chain[_OUTER_MOMENT, self.names.index("L")] = -values[_A23] / length**2
        if self.gravity_free:
            chain[_GRAVITY, self.names.index("g")] = 1.0
        return chain


@dataclass(frozen=True)
class Frozen:
    """A model whose unknowns keep given values: only the windows' starts remain to be fitted."""

    model: MotionModel
    values: Array

    @property
    def names(self) -> tuple[str, ...]:
        """No unknowns."""
        return ()

    @property
    def limits(self) -> tuple[Array, Array]:
        """No limits."""
        return np.empty(0), np.empty(0)

    def predict(self, values: Array, start: Array, window: Window) -> tuple[Array, Array]:
        """Return angles (n, 2) [rad] and their derivatives (n, 2, 4) with respect to the start."""
        theta, sensitivities = self.model.predict(self.values, start, window)
        return theta, sensitivities[..., :STATE]

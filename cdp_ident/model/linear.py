"""The linear model for small motions about an equilibrium, for controller design.

The equations of motion about angles at which the rods can rest, in the form x' = A x + B u, y = C x + D u, where u is
the cart's acceleration. The paper's part is the derivative from `equations`; the effects' part is a difference of their
torques.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import optimize

from cdp_ident.errors import OptionError
from cdp_ident.model.compilation import compiled
from cdp_ident.model.effects.catalogue import CATALOGUE, kind_of
from cdp_ident.model.effects.effect import Effect, TorqueEffect
from cdp_ident.model.equations import acceleration_derivatives, sines_and_cosines
from cdp_ident.model.parameters import COEFFICIENTS
from cdp_ident.model.torques import NO_TORQUES, Torques
from cdp_ident.model.trajectory import accelerations_at

Array = npt.NDArray[np.float64]

STATES = {"x": "m", "theta1": "rad", "theta2": "rad", "x'": "m/s", "theta1'": "rad/s", "theta2'": "rad/s"}
"""Name and unit of each state: the cart's position, the rods' absolute angles, and their rates of change."""
INPUTS = {"u": "m/s^2"}
"""The cart's acceleration."""
OUTPUTS = {"x": "m", "theta1": "rad", "theta2": "rad"}
"""What encoders measure, as the model's absolute angles."""

EQUILIBRIA = {
    "upright": (0.0, 0.0),
    "hanging": (np.pi, np.pi),
    "up-down": (0.0, np.pi),
    "down-up": (np.pi, 0.0),
}
"""Angles theta1, theta2 [rad] at which the paper's model rests, by name: the inner rod's direction comes first."""

_NUDGE = 1e-4
"""Step of the symmetric differences of effects' torques [rad], [rad/s]."""
_NEAR = 0.3
"""How far effects may shift an equilibrium before it is another one [rad]."""
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


def has_linear_part(effect: Effect) -> bool:
    """Return whether an effect can change a linear model: neither errors of encoders nor dry friction, for example."""
    return isinstance(effect, TorqueEffect) and effect.linear


def linearize(coefficients: Array, near: tuple[float, float], torques: Torques = NO_TORQUES) -> LinearModel:
    """Return the linear model about the equilibrium near given angles.

    Effects may shift the equilibrium (a base that is not level, a spring): it is then found anew.

    Args:
        coefficients: (7,) `COEFFICIENTS` of the pendulum.
        near: theta1, theta2 [rad], one of `EQUILIBRIA`.
        torques: of effects; those without a linear part (see `has_linear_part`) are left out.

    Raises:
        OptionError: the rods have no equilibrium near these angles.
    """
    torques = _linear(torques)
    theta = _equilibrium(coefficients, near, torques)
    rest = np.array([*theta, 0.0, 0.0])
    by_state = np.empty((2, 4))
    _paper_derivatives(coefficients, rest, by_state)
    A = np.zeros((len(STATES), len(STATES)))
    A[:3, 3:] = np.eye(3)
    A[np.ix_([4, 5], [1, 2, 4, 5])] = by_state + _derivatives_of_effects(coefficients, rest, torques)
    pushed = accelerations_at(coefficients, np.stack([rest, rest]), np.array([0.0, 1.0]), torques)
    B = np.zeros((len(STATES), len(INPUTS)))
    B[3:, 0] = 1.0, *(pushed[1] - pushed[0])
    return LinearModel(theta, A, B)


def _linear(torques: Torques) -> Torques:
    nonlinear = {
        (kind_of(effect), int(effect.form), effect.dry)
        for effect in CATALOGUE
        if isinstance(effect, TorqueEffect) and not effect.linear
    }
    return torques.of_rods(
        np.array([(kind, form, bool(dry)) not in nonlinear for kind, form, _, dry, *_ in torques.table.tolist()], bool)
    )


def _equilibrium(coefficients: Array, near: tuple[float, float], torques: Torques) -> Array:
    def at_rest(theta: Array) -> Array:
        return accelerations_at(coefficients, np.array([[*theta, 0.0, 0.0]]), np.zeros(1), torques)[0]

    gravity = coefficients[COEFFICIENTS.index("g")] * coefficients[COEFFICIENTS.index("a1_over_A22")]
    solution = optimize.root(at_rest, near, tol=1e-13)
    shift = np.abs(solution.x - near).max()
    if not shift < _NEAR or not np.abs(solution.fun).max() < _AT_REST * gravity:
        raise OptionError(
            f"the rods do not rest anywhere within {_NEAR} rad of theta1 = {near[0]:.4g}, theta2 = {near[1]:.4g}: the "
            "effects in the model are stronger than gravity there; look at effects.* in the file of the fitted model"
        )
    return np.asarray(solution.x)


def _derivatives_of_effects(coefficients: Array, rest: Array, torques: Torques) -> Array:
    """Return what effects add to the accelerations' derivatives (2, 4) with respect to the rods' state.

    The differences are symmetric, so that terms of second order, such as drag, add nothing.
    """
    nudged = rest + _NUDGE * np.vstack([np.eye(4), -np.eye(4)])
    still = np.zeros(len(nudged))
    added = accelerations_at(coefficients, nudged, still, torques) - accelerations_at(coefficients, nudged, still)
    return np.asarray(added[:4] - added[4:]).T / (2.0 * _NUDGE)


@compiled
def _paper_derivatives(coefficients: Array, state: Array, by_state: Array) -> None:
    A23, A33, a1, c1, c2, m2_l2, g = (
        coefficients[0], coefficients[1], coefficients[2], coefficients[3], coefficients[4], coefficients[5],
        coefficients[6],
    )  # fmt: skip
    derivatives = acceleration_derivatives(
        sines_and_cosines(state[0], state[1]), state[2], state[3], 0.0, A23, A33, a1, c1, c2, m2_l2, g, 0.0, 0.0
    )
    for k in range(4):
        by_state[0, k], by_state[1, k] = derivatives[3][k]

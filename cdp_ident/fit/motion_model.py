"""The model as the refinement sees it: numbers to adjust, and the motion and its derivatives that follow from them."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt
from scipy.linalg import block_diag

from cdp_ident.fit.prior import Prior
from cdp_ident.fit.stiffness import Stiffness, penalty
from cdp_ident.fit.windows import Window
from cdp_ident.model.effects.constants import effect_constants, outer_rod_length
from cdp_ident.model.effects.effect import Effect, EffectParameter, Form, TorqueEffect
from cdp_ident.model.effects.readings import encoder_readings
from cdp_ident.model.parameters import COEFFICIENTS, GROUPS, SYMBOLS, coefficients_of
from cdp_ident.model.time_grid import TimeGrid
from cdp_ident.model.torques import Torques
from cdp_ident.model.trajectory import trajectory, trajectory_with_derivatives

Array = npt.NDArray[np.float64]

JOINTS = ("inner", "outer")
_A23, _OUTER_MOMENT, _GRAVITY = (COEFFICIENTS.index(name) for name in ("A23_over_A22", "m2_l2_over_A22", "g"))
_LARGEST_ZERO = 0.5
"""No encoder's zero is off by more than this in a trial [rad]."""
LATEST = 0.05
"""No encoder is later or earlier than this [s]."""


@dataclass(frozen=True)
class ActiveEffect:
    """An effect that a model has."""

    effect: Effect
    trial: int | None = None
    """For an effect that happens once: in which trial."""
    stiffness: Stiffness = ()
    """For a curve that is fitted: the weights of its penalties."""

    @cached_property
    def fitted(self) -> tuple[EffectParameter, ...]:
        """Its parameters that are fitted."""
        return tuple(parameter for parameter in self.effect.parameters if not parameter.fixed)

    @property
    def penalty(self) -> Array:
        """(k, k) what its fitted parameters add to the cost, as a quadratic form [rad^2]."""
        if self.effect.curve is None or not self.stiffness:
            return np.zeros((len(self.fitted),) * 2)
        return penalty(self.effect.curve, self.stiffness)

    def all_values(self, fitted: Array) -> list[float]:
        """Return the values of all its parameters, given those of the fitted ones."""
        remaining = iter(fitted)
        return [p.typical if p.fixed else float(next(remaining)) for p in self.effect.parameters]


@dataclass(frozen=True)
class Mechanism:
    """What the model must know of the rig beforehand, because no zero-input trial shows it."""

    length: float
    """L [m], or the value to begin with where it is free."""
    gravity: float
    """g [m/s^2], or the value to begin with where it is free."""
    outer_length: float
    """Length of the outer rod [m]."""

    @classmethod
    def of(cls, prior: Prior) -> "Mechanism":
        """Take it from what is known before any trial."""
        l2 = float(prior.centre[SYMBOLS.index("l2")])
        return cls(prior.length, prior.gravity, outer_rod_length(prior.length, l2))


@dataclass(frozen=True)
class MotionModel:
    """The paper's model with any effects.

    Its unknowns are the five groups, on request the length L and gravity g, and the effects' parameters, torques
    being relative to A22.
    """

    mechanism: Mechanism
    length_free: bool = False
    gravity_free: bool = False
    effects: tuple[ActiveEffect, ...] = ()
    zeros: tuple[int, ...] = ()
    """Trials whose encoders have a zero of their own; none where the zeros are right, or the same for all trials."""

    @cached_property
    def base_names(self) -> tuple[str, ...]:
        """Names of the unknowns that are not of effects."""
        return (
            *(group.symbol for group in GROUPS),
            *(("L",) if self.length_free else ()),
            *(("g",) if self.gravity_free else ()),
        )

    @cached_property
    def labels(self) -> tuple[str, ...]:
        """One name for each effect: its key, with a number from the second of a kind on, as of knocks."""
        keys = [active.effect.key for active in self.effects]
        counts = [keys[: index + 1].count(key) for index, key in enumerate(keys)]
        return tuple(key if count == 1 else f"{key}.{count}" for key, count in zip(keys, counts, strict=True))

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the unknowns, in the order of their values."""
        of_effects = (
            f"{k}.{p.name}" for k, active in zip(self.labels, self.effects, strict=True) for p in active.fitted
        )
        of_zeros = (f"zero.{joint}.trial_{trial + 1}" for trial in self.zeros for joint in JOINTS)
        return (*self.base_names, *of_zeros, *of_effects)

    @cached_property
    def limits(self) -> tuple[Array, Array]:
        """Lowest and highest value of each unknown: inertias, moments and frictions are not negative."""
        base, zeros = len(self.base_names), np.full(len(JOINTS) * len(self.zeros), _LARGEST_ZERO)
        parameters = [p for active in self.effects for p in active.fitted]
        lower = np.concatenate([np.zeros(base), -zeros, [p.lower for p in parameters]])
        return lower, np.concatenate([np.full(base, np.inf), zeros, [p.upper for p in parameters]])

    @cached_property
    def penalty(self) -> Array:
        """(unknowns, unknowns) what the unknowns add to the cost of a fit, as a quadratic form [rad^2]."""
        others = len(self.base_names) + len(JOINTS) * len(self.zeros)
        return block_diag(np.zeros((others, others)), *(active.penalty for active in self.effects))

    @cached_property
    def states(self) -> int:
        """Numbers in an initial state: theta1, theta2, omega1, omega2, and what effects bring; see `Torques.states`."""
        moves = any(isinstance(a.effect, TorqueEffect) and a.effect.form is Form.BASE for a in self.effects)
        return Torques.count_of_states(moves)

    def initial_state(self, start: Array) -> Array:
        """Return an initial state of as many numbers as this model has; what another model's does not tell is zero."""
        whole = np.zeros(self.states)
        whole[: len(start)] = start[: self.states]
        return whole

    def beginning(self, groups: Array) -> Array:
        """Return values of the unknowns without effects, for given groups (5,), L and g as known beforehand."""
        constants = [self.mechanism.length] * self.length_free + [self.mechanism.gravity] * self.gravity_free
        return np.concatenate([groups, constants])

    def with_effect(self, effect: ActiveEffect) -> "MotionModel":
        """Return this model with one effect more, whose unknowns come last."""
        return replace(self, effects=(*self.effects, effect))

    def without_effect(self, index: int) -> tuple["MotionModel", npt.NDArray[np.bool_]]:
        """Return this model without an effect, and which of the unknowns remain."""
        remain = np.ones(len(self.names), dtype=bool)
        remain[self.places(index)] = False
        return replace(self, effects=self.effects[:index] + self.effects[index + 1 :]), remain

    def with_zeros(self, values: Array, trials: Iterable[int]) -> tuple["MotionModel", Array]:
        """Return this model and its values with encoders that have a zero of their own in more trials, 0 at first."""
        more = tuple(trial for trial in sorted(set(trials)) if trial not in self.zeros)
        end = len(self.base_names) + len(JOINTS) * len(self.zeros)
        added = np.zeros(len(JOINTS) * len(more))
        return replace(self, zeros=self.zeros + more), np.concatenate([values[:end], added, values[end:]])

    def without_zeros(self, values: Array) -> tuple["MotionModel", Array]:
        """Return this model and its values with encoders whose zeros are right in all trials."""
        return replace(self, zeros=()), values[self.of_rig]

    def zero_places(self, trial: int) -> slice:
        """Return where the unknowns of a trial's zeros are: empty for a trial that has none of its own."""
        first = len(self.base_names)
        if trial not in self.zeros:
            return slice(first, first)
        first += len(JOINTS) * self.zeros.index(trial)
        return slice(first, first + len(JOINTS))

    @property
    def of_rig(self) -> npt.NDArray[np.bool_]:
        """Which of the unknowns are the rig's, and not the zeros of a trial."""
        first = len(self.base_names)
        of_rig = np.ones(len(self.names), dtype=bool)
        of_rig[first : first + len(JOINTS) * len(self.zeros)] = False
        return of_rig

    @property
    def of_curves(self) -> npt.NDArray[np.bool_]:
        """Which of the unknowns are coefficients of curves, which say nothing one by one."""
        of_curves = np.zeros(len(self.names), dtype=bool)
        for index, active in enumerate(self.effects):
            of_curves[self.places(index)] = active.effect.curve is not None
        return of_curves

    def places(self, index: int) -> slice:
        """Return where the unknowns of an effect are."""
        return self._places[index]

    @cached_property
    def _places(self) -> list[slice]:
        counts = [len(active.fitted) for active in self.effects]
        ends = len(self.base_names) + len(JOINTS) * len(self.zeros) + np.cumsum(counts, dtype=int)
        return [slice(int(end) - count, int(end)) for end, count in zip(ends, counts, strict=True)]

    def constants(self, values: Array) -> tuple[float, float]:
        """Return L [m] and g [m/s^2] under given values of the unknowns."""
        names = self.base_names
        length = float(values[names.index("L")]) if self.length_free else self.mechanism.length
        return length, float(values[names.index("g")]) if self.gravity_free else self.mechanism.gravity

    def coefficients(self, values: Array) -> Array:
        """Return the model's coefficients (7,) under given values of the unknowns."""
        return coefficients_of(values[: len(GROUPS)], *self.constants(values))

    def torques(self, values: Array, trial: int) -> Torques:
        """Return the torques of the effects in a trial, and as directions their fitted parameters."""
        chosen: list[tuple[TorqueEffect, Sequence[float]]] = []
        directions: list[tuple[int, int]] = []
        for index, active in enumerate(self.effects):
            if isinstance(active.effect, TorqueEffect) and active.trial in (None, trial):
                parameters = active.effect.parameters
                directions += [(len(chosen), k) for k, p in enumerate(parameters) if not p.fixed]
                chosen.append((active.effect, active.all_values(values[self.places(index)])))
        length, _ = self.constants(values)
        constants = effect_constants(self.coefficients(values), length, self.mechanism.outer_length)
        return Torques.of(chosen, constants, directions)

    def predict(self, values: Array, start: Array, window: Window, derivatives: bool = True) -> tuple[Array, Array]:
        """Return the angles that the encoders show in a window, and their derivatives.

        Returns:
            Angles (n, 2) [rad] and their derivatives (n, 2, states + unknowns) by the initial state and the unknowns;
            (n, 2, 0) where none are asked for.
        """
        coefficients, torques = self.coefficients(values), self.torques(values, window.trial)
        start = self.initial_state(start)

        def motion(delay: float) -> tuple[Array, Array]:
            grid, u = window.grid, window.u
            if delay:
                grid = TimeGrid.over(window.time - delay, grid.step, earliest=-LATEST)
                u = np.pad(u, (0, max(2 * grid.steps + 1 - len(u), 0)), mode="edge")
            if not derivatives:
                states = trajectory(coefficients, start, grid, u, torques, window.begin)
                return states, np.empty((*states.shape, 0))
            states, by_directions = trajectory_with_derivatives(coefficients, start, grid, u, torques, window.begin)
            return states, self._by_unknowns(values, by_directions, window.trial)

        sensors = [
            (active.effect, active.all_values(values[self.places(index)]), self.places(index))
            for index, active in enumerate(self.effects)
            if not isinstance(active.effect, TorqueEffect) and active.trial in (None, window.trial)
        ]
        theta, by_unknowns = encoder_readings(motion, sensors, window.begin + window.time, self.states)
        place = self.zero_places(window.trial)
        if place.start < place.stop:
            # The inner encoder's angle is in both absolute ones.
            theta = theta + np.cumsum(values[place])
            if derivatives:
                by_unknowns[:, :, self.states + place.start] = 1.0
                by_unknowns[:, 1, self.states + place.start + 1] = 1.0
        return theta, by_unknowns

    def _by_unknowns(self, values: Array, derivatives: Array, trial: int) -> Array:
        """Return derivatives (n, 2, states + unknowns) of the angles from those that compiled code gives."""
        base, states = len(self.base_names), self.states
        derivatives = derivatives[:, :2]
        result = np.zeros((*derivatives.shape[:2], states + len(self.names)))
        result[..., :states] = derivatives[..., :states]
        direction = states + len(COEFFICIENTS)
        result[..., states : states + base] = derivatives[..., states:direction] @ self._chain(values)
        for index, active in enumerate(self.effects):
            if isinstance(active.effect, TorqueEffect) and active.trial in (None, trial):
                place = self.places(index)
                count = place.stop - place.start
                result[..., states + place.start : states + place.stop] = derivatives[
                    ..., direction : direction + count
                ]
                direction += count
        return result

    def _chain(self, values: Array) -> Array:
        """Return the derivatives (7, base unknowns) of the coefficients with respect to the unknowns."""
        length, _ = self.constants(values)
        chain = np.zeros((len(COEFFICIENTS), len(self.base_names)))
        chain[: len(GROUPS), : len(GROUPS)] = np.eye(len(GROUPS))
        chain[_OUTER_MOMENT, _A23] = 1.0 / length
        if self.length_free:
            chain[_OUTER_MOMENT, self.base_names.index("L")] = -values[_A23] / length**2
        if self.gravity_free:
            chain[_GRAVITY, self.base_names.index("g")] = 1.0
        return chain

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The numbers that a fit adjusts."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeVar

import numpy as np

from cdp_ident.arrays import Array, Mask
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.prior import FARTHEST, Mechanism
from cdp_ident.fit.weighted import Layout, Weighted
from cdp_ident.model.effects.effect import JOINTS, EffectParameter
from cdp_ident.model.effects.forces import MOTORS
from cdp_ident.model.parameters import GROUPS, INVERSE_INERTIA, time_unit
from cdp_ident.model.weights import ErrorOf, Weight

Model = TypeVar("Model", bound="ModelUnknowns")

TORQUE_STD = 0.05
"""Relative standard deviation of a torque constant, where nothing else is known."""
_LARGEST_ZERO = 0.5
"""No encoder's zero is off by more than this in a trial [rad]."""


@dataclass(frozen=True)
class ModelUnknowns:
    """The numbers that are adjusted: which there are, where each is, and what is known of them beforehand.

    They are the five base parameters, the length L and gravity g where they are not taken for exact, 1 / A22 where
    weights show it, errors of weights, the zeros of trials' encoders, and the effects' parameters, torques being
    relative to A22. They are those of the rig without the weights that some trials may have.
    """

    mechanism: Mechanism
    length_std: float = 0.0
    """How well L is known beforehand: its relative standard deviation, 0 where it is taken for exact."""
    gravity_std: float = 0.0
    """The same of g."""
    inertia_free: bool = False
    """Whether 1 / A22 is an unknown, which only trials with different weights or known torques determine."""
    motors: bool = False
    """Whether torques of motors in the joints are known."""
    torque_std: float = TORQUE_STD
    """How well they are, that of each joint for itself: their relative standard deviation."""
    weight_errors: tuple[ErrorOf, ...] = ()
    """Errors of the weights' masses and places: unknowns, in units of their standard deviations."""
    effects: tuple[ActiveEffect, ...] = ()
    zeros: tuple[int, ...] = ()
    """Trials in which encoders have a zero of their own; none where zeros are right, or the same for all trials."""
    zero_joints: tuple[str, ...] = JOINTS
    """Whose encoders these are."""

    @cached_property
    def base_names(self) -> tuple[str, ...]:
        """Names of the unknowns that do not belong to effects or zeros."""
        return (
            *(group.symbol for group in GROUPS),
            *self._constants,
            *((INVERSE_INERTIA.symbol,) if self.inertia_free else ()),
            *(f"{MOTORS.name}.{parameter.name}" for parameter in self.of_motors),
            *(_name_of(error) for error in self.weight_errors),
        )

    @property
    def of_motors(self) -> tuple[EffectParameter, ...]:
        """Unknowns of the motors; the gain of their torques is 1 / A22."""
        return MOTORS.parameters[1:] if self.motors else ()

    @property
    def places_of_motors(self) -> slice:
        """Where they are."""
        end = len(self.base_names) - len(self.weight_errors)
        return slice(end - len(self.of_motors), end)

    @cached_property
    def _constants(self) -> dict[str, tuple[float, float]]:
        """L and g where they are unknowns, with what is known of them: value and standard deviation."""
        both = {
            "L": (self.mechanism.length, self.length_std * self.mechanism.length),
            "g": (self.mechanism.gravity, self.gravity_std * self.mechanism.gravity),
        }
        return {name: known for name, known in both.items() if known[1] > 0.0}

    @cached_property
    def known(self) -> tuple[Array, Array]:
        """(unknowns,) what is known of the unknowns before any motion, effects apart: value, and precision."""
        centre, precision = np.zeros(len(self.names)), self.of_weights.astype(float)
        for name, (value, std) in self._constants.items():
            place = self.base_names.index(name)
            centre[place], precision[place] = value, std**-2
        precision[self.of_zeros] = 3.0 / _LARGEST_ZERO**2  # anywhere between the limits
        precision[self.places_of_motors] = [(p.width or np.sqrt(2.0) * self.torque_std) ** -2 for p in self.of_motors]
        return centre, precision

    @cached_property
    def labels(self) -> tuple[str, ...]:
        """One name for each effect: its key, with a number from the second of a kind on, such as impulses."""
        keys = [active.effect.key for active in self.effects]
        counts = [keys[: index + 1].count(key) for index, key in enumerate(keys)]
        return tuple(key if count == 1 else f"{key}.{count}" for key, count in zip(keys, counts, strict=True))

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of the unknowns, in the order of their values."""
        of_effects = (
            f"{k}.{p.name}" for k, active in zip(self.labels, self.effects, strict=True) for p in active.fitted
        )
        of_zeros = (f"zero.{joint}.trial_{trial + 1}" for trial in self.zeros for joint in self.zero_joints)
        return (*self.base_names, *of_zeros, *of_effects)

    @cached_property
    def limits(self) -> tuple[Array, Array]:
        """Lowest and highest value of each unknown: inertias, moments and frictions are not negative."""
        base, zeros = len(self.base_names), np.full(self._zeros, _LARGEST_ZERO)
        parameters = [p for active in self.effects for p in active.fitted]
        lower = np.concatenate([np.zeros(base), -zeros, [p.lower for p in parameters]])
        upper = np.concatenate([np.full(base, np.inf), zeros, [p.upper for p in parameters]])
        lower[self.of_weights], upper[self.of_weights] = -FARTHEST, FARTHEST
        lower[self.places_of_motors] = [parameter.lower for parameter in self.of_motors]
        upper[self.places_of_motors] = [parameter.upper for parameter in self.of_motors]
        return lower, upper

    @cached_property
    def reach(self) -> Array:
        """(unknowns,) by how much each may change in a step: an instant by a time unit, where a step is linear."""
        unit = time_unit(self.mechanism.length, self.mechanism.gravity)
        reach = np.full(len(self.names), np.inf)
        for index, active in enumerate(self.effects):
            instants = [active.effect.at_an_instant and np.isinf(parameter.width) for parameter in active.fitted]
            reach[self.places(index)] = np.where(instants, unit, np.inf)
        return reach

    @property
    def of_weights(self) -> Mask:
        """Which of the unknowns are errors of weights."""
        end = len(self.base_names)
        of_weights = np.zeros(len(self.names), dtype=bool)
        of_weights[end - len(self.weight_errors) : end] = True
        return of_weights

    def initial_values(self, groups: Array, inertia: float | None = None, length: float | None = None) -> Array:
        """Return values of the unknowns without effects, for given base parameters (5,), A22 [kg m^2] and L [m].

        g, and A22 and L where they are not given, are as known beforehand.
        """
        constants = [length or value if name == "L" else value for name, (value, _) in self._constants.items()]
        inverse = [1.0 / (inertia or self.mechanism.inertia)] * self.inertia_free
        return np.concatenate([groups, constants, inverse, np.zeros(len(self.of_motors) + len(self.weight_errors))])

    def with_effect(self: Model, effect: ActiveEffect) -> Model:
        """Return this model with one effect more, whose unknowns come last."""
        return replace(self, effects=(*self.effects, effect))

    def without_effect(self: Model, index: int) -> tuple[Model, Mask]:
        """Return this model without an effect, and which of the unknowns remain."""
        remain = np.ones(len(self.names), dtype=bool)
        remain[self.places(index)] = False
        return replace(self, effects=self.effects[:index] + self.effects[index + 1 :]), remain

    def with_zeros(self: Model, values: Array, trials: Iterable[int]) -> tuple[Model, Array]:
        """Return this model and its values with encoders that have a zero of their own in more trials, 0 at first."""
        more = tuple(trial for trial in sorted(set(trials)) if trial not in self.zeros)
        end = len(self.base_names) + self._zeros
        added = np.zeros(len(self.zero_joints) * len(more))
        return replace(self, zeros=self.zeros + more), np.concatenate([values[:end], added, values[end:]])

    def zero_places(self, trial: int) -> slice:
        """Return where the unknowns of a trial's zeros are: empty for a trial that has none of its own."""
        first = len(self.base_names)
        if trial not in self.zeros:
            return slice(first, first)
        first += len(self.zero_joints) * self.zeros.index(trial)
        return slice(first, first + len(self.zero_joints))

    @cached_property
    def by_zeros(self) -> Array:
        """(2, zeros of a trial) derivatives of what both encoders show by the zeros of a trial that has its own."""
        return np.eye(len(JOINTS))[:, [JOINTS.index(joint) for joint in self.zero_joints]]

    @property
    def _zeros(self) -> int:
        """How many zeros there are."""
        return len(self.zero_joints) * len(self.zeros)

    @property
    def of_zeros(self) -> Mask:
        """Which of the unknowns are zeros of a trial."""
        first = len(self.base_names)
        of_zeros = np.zeros(len(self.names), dtype=bool)
        of_zeros[first : first + self._zeros] = True
        return of_zeros

    @property
    def of_rig(self) -> Mask:
        """Which of the unknowns are the rig's, and neither zeros of a trial nor errors of a weight."""
        return ~self.of_zeros & ~self.of_weights

    @property
    def of_curves(self) -> Mask:
        """Which of the unknowns are coefficients of curves, which have no meaning one by one."""
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
        ends = len(self.base_names) + self._zeros + np.cumsum(counts, dtype=int)
        return [slice(int(end) - count, int(end)) for end, count in zip(ends, counts, strict=True)]

    def constants(self, values: Array) -> tuple[float, float]:
        """Return L [m] and g [m/s^2] under given values of the unknowns."""
        given = {"L": self.mechanism.length, "g": self.mechanism.gravity}
        found = {name: float(values[self.base_names.index(name)]) for name in self._constants}
        length, gravity = (given | found).values()
        return length, gravity

    def inverse_inertia(self, values: Array) -> float:
        """Return 1 / A22 [1/(kg m^2)] under given values of the unknowns."""
        if not self.inertia_free:
            return 1.0 / self.mechanism.inertia
        return float(values[self.base_names.index(INVERSE_INERTIA.symbol)])

    def with_inertia_known(self: Model, values: Array) -> tuple[Model, Mask]:
        """Return this model with the A22 that values give as one that is known, and which unknowns remain."""
        remain = np.array([name != INVERSE_INERTIA.symbol for name in self.names])
        inertia = 1.0 / max(self.inverse_inertia(values), np.finfo(float).tiny)
        return replace(self, inertia_free=False, mechanism=replace(self.mechanism, inertia=inertia)), remain

    def with_weights(self, values: Array, weights: Sequence[Weight]) -> Weighted:
        """Return the unknowns as they are in a trial with weights clamped to the rods."""
        length, _ = self.constants(values)
        return Weighted(self._layout, values, weights, length, self.inverse_inertia(values))

    @cached_property
    def _layout(self) -> Layout:
        powers, carrying = np.zeros(len(self.names)), [""] * len(self.names)
        powers[: len(GROUPS)] = 1.0
        for index, active in enumerate(self.effects):
            powers[self.places(index)] = [p.inertia_power for p in active.fitted]
            carrying[self.places(index)] = [active.effect.joint if p.includes_weights else "" for p in active.fitted]
        names = self.base_names
        if self.inertia_free:
            powers[names.index(INVERSE_INERTIA.symbol)] = 1.0
        return Layout(
            powers,
            tuple(carrying),
            names.index("L") if "L" in names else None,
            names.index(INVERSE_INERTIA.symbol) if self.inertia_free else None,
            dict(zip(self.weight_errors, np.flatnonzero(self.of_weights).tolist(), strict=True)),
        )


def _name_of(error: ErrorOf) -> str:
    kind, rod, value = error
    return f"weight_error.mass.{1e3 * value:.10g} g" if kind == "mass" else f"weight_error.{rod}.{1e3 * value:.10g} mm"

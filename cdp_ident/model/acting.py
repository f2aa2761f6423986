# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The effects that act on a pendulum, with their parameters, laid out for compiled code."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache
from itertools import compress, pairwise

import numpy as np

from cdp_ident.arrays import Array, Indices, Mask
from cdp_ident.model import layout as at
from cdp_ident.model.effects.effect import JOINTS, Effect
from cdp_ident.model.formulas.compiled import compiled_law
from cdp_ident.model.formulas.language import COEFFICIENTS, PARAMETERS, ROWS
from cdp_ident.model.layout import Laws

_PLACES = (*JOINTS, "base")
_ALL_COEFFICIENTS = tuple(range(len(COEFFICIENTS)))


def outer_rod_length(length: float, l2: float) -> float:
    """Return how long the outer rod is taken to be [m]: as long as the inner one, or twice as far as its centre."""
    return max(length, 2.0 * l2)


@dataclass(frozen=True)
class ActingEffects:
    """Effects with their parameters."""

    effects: tuple[Effect, ...] = ()
    values: Array = field(default_factory=lambda: np.empty(0))
    """Parameters of all of them, one after the other, in the unit of the fit."""
    outer_length: float = 1.0
    """Of the outer rod [m]."""
    carried: float = 0.0
    """Mass of the weights clamped to the rods, over the inertia about the cart's joint [1/m^2]."""
    coefficients: tuple[int, ...] = _ALL_COEFFICIENTS
    """Which of the coefficients are directions of derivatives, after the initial state's."""
    parameters: tuple[int, ...] = ()
    """Which of the parameters are, after these."""

    @classmethod
    def of(
        cls,
        effects: Sequence[tuple[Effect, Sequence[float]]],
        outer_length: float,
        carried: float = 0.0,
        fitted: bool = False,
    ) -> "ActingEffects":
        """Lay out effects, each with the values of all its parameters; these are directions where they are `fitted`."""
        values = np.array([value for _, parameters in effects for value in parameters], dtype=float)
        kinds = tuple(effect for effect, _ in effects)
        every = [parameter for effect in kinds for parameter in effect.parameters]
        free = tuple(k for k, parameter in enumerate(every) if fitted and not parameter.fixed)
        return cls(kinds, values, outer_length, carried, parameters=free)

    @cached_property
    def states(self) -> int:
        """Numbers in a state: those of the rods, and of each effect its own."""
        return at.RODS_STATES + sum(effect.states for effect in self.effects)

    @property
    def directions(self) -> int:
        """How many directions of derivatives there are."""
        return self.states + len(self.coefficients) + len(self.parameters)

    def laws(self, values: Array) -> Laws:
        """Return the laws as compiled code takes them, for motions with values (motions, parameters)."""
        laid_out = _laid_out(self.effects, self.coefficients, self.parameters)
        strengths = np.abs(values).max(axis=0, initial=0.0) * self._are_strengths
        table = laid_out.table.copy()
        of_laws = np.split(strengths, table[1:, at.VALUES_AT])
        for row, effect, of_law in zip(table, self.effects, of_laws, strict=False):
            is_zero = not of_law.any()
            row[at.CODE] = compiled_law(effect, is_zero)
            if is_zero and effect.known_at_zero:
                row[at.OWNS] = 0
                row[at.KIND] += at.OF_NO_STRENGTH - at.MOVES * (not effect.moves and effect.states > 0)
        return laid_out._replace(table=table)

    @cached_property
    def _are_strengths(self) -> Array:
        return np.array([not (p.shape or p.fixed) for effect in self.effects for p in effect.parameters], dtype=float)

    def each(self) -> Iterator[tuple[Effect, list[float]]]:
        """Return each effect with the values of its parameters."""
        bounds = np.cumsum([0, *(len(effect.parameters) for effect in self.effects)])
        for effect, (first, end) in zip(self.effects, pairwise(bounds.tolist()), strict=True):
            yield effect, self.values[first:end].tolist()

    def only(self, wanted: Callable[[Effect], bool]) -> "ActingEffects":
        """Return some of the effects, without directions."""
        kept = [(effect, values) for effect, values in self.each() if wanted(effect)]
        return ActingEffects.of(kept, self.outer_length, self.carried).without_directions()

    def with_directions(self, wanted: Mask) -> "ActingEffects":
        """Return the same, with derivatives by those of its coefficients and parameters (k,) that are wanted."""
        count = len(self.coefficients)
        coefficients = tuple(compress(self.coefficients, wanted[:count]))
        return replace(self, coefficients=coefficients, parameters=tuple(compress(self.parameters, wanted[count:])))

    def without_directions(self) -> "ActingEffects":
        """Return the same, of which no derivatives but those by the initial state are wanted."""
        return replace(self, coefficients=(), parameters=())


@lru_cache(maxsize=256)
def _laid_out(effects: tuple[Effect, ...], coefficients: tuple[int, ...], parameters: tuple[int, ...]) -> Laws:
    """Return the laws of effects, but for their code."""
    counts = [len(effect.parameters) for effect in effects]
    owns = [effect.states for effect in effects]
    values_at, own_at = _begins(counts), at.RODS_STATES + _begins(owns)
    places = np.full(len(COEFFICIENTS) + sum(counts), -1, dtype=np.int64)
    directions = (*coefficients, *(len(COEFFICIENTS) + k for k in parameters))
    places[list(directions)] = 2 * (at.RODS_STATES + sum(owns)) + np.arange(len(directions))
    shared = np.full(PARAMETERS, -1, dtype=np.int64)
    shared[1 : 1 + at.RODS_STATES] = np.arange(at.RODS_STATES)
    shared[at.BY_COEFFICIENT :] = places[: len(COEFFICIENTS)]
    lanes: list[Indices] = [shared]
    for first, count, own, states in zip(values_at + len(COEFFICIENTS), counts, own_at, owns, strict=True):
        lanes.append(np.concatenate([shared, places[first : first + count]]))
        lanes[-1][at.BY_OWN : at.BY_OWN + states] = own + np.arange(states)
    limits = [state.limit for effect in effects for state in effect.law.states]
    widths = np.array([PARAMETERS + count for count in counts], dtype=np.int64)
    columns: dict[int, Sequence[int] | Indices] = {
        at.KIND: [_kind(effect) for effect in effects],
        at.JOINT: [_PLACES.index(effect.joint) for effect in effects],
        at.VALUES_AT: values_at,
        at.WIDTH: widths,
        at.LANES_AT: PARAMETERS + _begins(widths),
        at.ROWS_AT: ROWS * _begins(widths),
        at.OWN_AT: own_at,
        at.OWNS: owns,
        at.RESOLVES: [next((k for k, p in enumerate(effect.parameters) if p.resolves), -1) for effect in effects],
        at.TURNS: [
            effect.dry or "direction" in effect.words or any(np.isfinite(state.limit) for state in effect.law.states)
            for effect in effects
        ],
    }
    table = np.zeros((len(effects), at.LAW_COLUMNS), dtype=np.int64)
    for column, of_laws in columns.items():
        table[:, column] = of_laws
    return Laws(table, np.concatenate(lanes), np.array([np.inf] * at.RODS_STATES + limits))


def _begins(lengths: Sequence[int] | Indices) -> Indices:
    """Return where each of some stretches begins that are one after the other."""
    return (np.cumsum(lengths) - lengths).astype(np.int64)


def _kind(effect: Effect) -> int:
    return (
        at.MOVES * (effect.moves or effect.states > 0)
        + at.FRICTION_KIND * effect.dry
        + at.CART_KIND * bool(effect.law.cart)
        + at.ACCELERATED * effect.uses_accelerations
        + at.WITHIN_ANGLE * any(p.resolves == "angle" for p in effect.parameters)
        + at.LATE * bool(effect.law.lateness)
        + at.SHOWN * bool(effect.law.reading or any(effect.law.readings))
    )


NO_EFFECTS = ActingEffects()

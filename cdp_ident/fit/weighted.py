# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The unknowns of a model as a trial shows them in which known weights are clamped to the rods.

Everything is seen over the inertia about the cart's joint. With weights that is s times A22, s = 1 + a / A22, and an
unknown x, over A22 to the power k, to whose numerator the weights add b, is seen as (x + b / A22) / s^k.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.model.parameters import GROUPS
from cdp_ident.model.weights import INERTIA, ErrorOf, Weight, added_by, mass_beyond


@dataclass(frozen=True)
class Layout:
    """How each unknown of a model depends on weights; the base parameters come first."""

    powers: Array
    """(unknowns,) to which power of 1 / A22 each goes: 1 for the base parameters and for torques."""
    carrying: tuple[str, ...]
    """For each unknown that is a mass carried by a joint, that joint; empty for the others."""
    length: int | None
    """Where L is among them, if it is."""
    inverse_inertia: int | None
    """Where 1 / A22 is among them, if it is."""
    errors: Mapping[ErrorOf, int]
    """Where the errors of weights are among them, in standard deviations."""


@dataclass(frozen=True)
class Weighted:
    """The unknowns of a rig with weights."""

    layout: Layout
    rig: Array
    """(unknowns,) those without the weights."""
    weights: Sequence[Weight]
    length: float
    """L [m]."""
    inverse_inertia: float
    """1 / A22 of the rig without the weights [1/(kg m^2)]."""

    @property
    def share(self) -> float:
        """The inertia about the cart's joint over A22."""
        return 1.0 + self.inverse_inertia * float(self._added[INERTIA])

    @property
    def carried(self) -> float:
        """The mass of the weights over the inertia about the cart's joint [1/m^2].

        Only a base that swings by itself asks for it, and so little of its mass is in weights that its derivatives by
        what these may be wrong by are left out.
        """
        return self.inverse_inertia * mass_beyond(self._actual, "inner") / self.share

    @property
    def values(self) -> Array:
        """(unknowns,) as the trial shows them."""
        return (self.rig + self.inverse_inertia * self._numerators(self._added, self._actual)) * self._shrinking

    @property
    def by_rig(self) -> Array:
        """(unknowns, unknowns) derivatives of these values by those of the rig without weights."""
        result = np.diag(self._shrinking)
        if self.layout.length is not None:
            by_length = sum((weight.by_length(self.length) for weight in self._actual), np.zeros_like(self._added))
            result[:, self.layout.length] += self.inverse_inertia * self._change(by_length)
        if self.layout.inverse_inertia is not None:
            result[:, self.layout.inverse_inertia] += self._change(self._added, self._actual)
        for weight, actual in zip(self.weights, self._actual, strict=True):
            for error in weight.errors:
                if (place := self.layout.errors.get(error)) is not None:
                    by_error = actual.by_error(error, self.length)
                    carried = (replace(weight, mass=weight.mass_std),) if error[0] == "mass" else ()
                    result[:, place] += self.inverse_inertia * self._change(by_error, carried)
        return result

    @cached_property
    def _actual(self) -> tuple[Weight, ...]:
        """The weights with their errors."""
        errors = {error: float(self.rig[place]) for error, place in self.layout.errors.items()}
        return tuple(weight.with_errors(errors) for weight in self.weights)

    @cached_property
    def _added(self) -> Array:
        return added_by(self._actual, self.length)

    @property
    def _shrinking(self) -> Array:
        return np.asarray(self.share**-self.layout.powers)

    def _numerators(self, added: Array, weights: Sequence[Weight] = ()) -> Array:
        """Return the additions to the unknowns' numerators (unknowns,), given those to A22 and the others (6,)."""
        carried = [mass_beyond(weights, joint) if joint else 0.0 for joint in self.layout.carrying]
        numerators = np.array(carried)
        numerators[: len(GROUPS)] = np.delete(added, INERTIA)
        return numerators

    def _change(self, added: Array, weights: Sequence[Weight] = ()) -> Array:
        """Return the change (unknowns,) of the values by so much more, times 1 / A22, of what is added."""
        by_numerators = self._shrinking * self._numerators(added, weights)
        return by_numerators - self.layout.powers * self.values * float(added[INERTIA]) / self.share

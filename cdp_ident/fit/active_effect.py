# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""An effect as a part of a model that is fitted."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cdp_ident.arrays import Array, Mask
from cdp_ident.model.effects.effect import Effect, EffectParameter


@dataclass(frozen=True)
class ActiveEffect:
    """An effect that a model has."""

    effect: Effect
    trial: int | None = None
    """The only trial in which it acts, of an effect that happens once, or by which a trial differs from the others."""
    bend: float = 1.0
    """For a curve that is fitted: standard deviation of the second differences of its coefficients beforehand, over
    that of a coefficient."""

    @property
    def is_difference(self) -> bool:
        """Whether it is what one trial has more than the others."""
        return self.trial is not None and not self.effect.at_an_instant

    @property
    def key(self) -> str:
        """The effect's; of a difference that it is one."""
        return f"more {self.effect.key} in one trial" if self.is_difference else self.effect.key

    @cached_property
    def fitted(self) -> tuple[EffectParameter, ...]:
        """Its parameters that are fitted."""
        return tuple(parameter for parameter in self.effect.parameters if not parameter.fixed)

    @cached_property
    def strengths(self) -> Mask:
        """(k,) which of these are strengths, without which the others have no meaning."""
        return np.array([not parameter.shape for parameter in self.fitted], dtype=bool)

    def all_values(self, fitted: Array) -> list[float]:
        """Return the values of all its parameters, given those of the fitted ones."""
        remaining = iter(fitted)
        return [p.typical if p.fixed else float(next(remaining)) for p in self.effect.parameters]

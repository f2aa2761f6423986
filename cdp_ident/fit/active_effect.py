"""An effect as a part of a model that is fitted."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from cdp_ident.fit.stiffness import Stiffness, penalty
from cdp_ident.model.effects.effect import Effect, EffectParameter

Array = npt.NDArray[np.float64]


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

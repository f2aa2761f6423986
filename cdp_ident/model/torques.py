"""The torques of effects as compiled code takes them."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from cdp_ident.model.effects.catalogue import kind_of
from cdp_ident.model.effects.constants import COUNT
from cdp_ident.model.effects.effect import JOINTS, Form, TorqueEffect

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

_PLACES = (*JOINTS, "base")
_OF_RODS = 4
"""Size of the rods' state."""
_OF_BASE = 2
"""Size of the base's state: position and speed."""


@dataclass(frozen=True)
class Torques:
    """Effects with their parameters, laid out for compiled code."""

    table: Indices = field(default_factory=lambda: np.empty((0, 5), dtype=np.int64))
    """(effects, 5) of each effect the number of its law, its form, its joint (0 inner, 1 outer), whether it is dry, and
    which parameter is the speed within which it changes, -1 for none."""
    values: Array = field(default_factory=lambda: np.empty((0, 1)))
    """(effects, p) their parameters."""
    constants: Array = field(default_factory=lambda: np.zeros(COUNT))
    """What laws know of the mechanism: see `effect_constants`."""
    lanes: Indices = field(default_factory=lambda: np.empty((0, 1), dtype=np.int64))
    """(effects, p) which of the further directions each parameter is, -1 where it is none."""

    @classmethod
    def of(
        cls,
        effects: Sequence[tuple[TorqueEffect, Sequence[float]]],
        constants: Array,
        directions: Sequence[tuple[int, int]] = (),
    ) -> "Torques":
        """Lay out effects with their parameters.

        Args:
            effects: each with the values of all its parameters, in the unit of the fit.
            constants: see `effect_constants`.
            directions: effect and parameter of each further direction in which derivatives are wanted.
        """
        width = max((len(parameters) for _, parameters in effects), default=1)
        values, lanes = np.zeros((len(effects), width)), np.full((len(effects), width), -1, dtype=np.int64)
        for row, (_, parameters) in zip(values, effects, strict=True):
            row[: len(parameters)] = parameters
        for lane, (effect, parameter) in enumerate(directions):
            lanes[effect, parameter] = lane
        table = [
            (kind_of(effect), effect.form, _PLACES.index(effect.joint), effect.dry, _turning_parameter(effect))
            for effect, _ in effects
        ]
        return cls(np.array(table, dtype=np.int64).reshape(-1, 5), values, constants, lanes)

    @cached_property
    def directions(self) -> int:
        """How many further directions there are."""
        return sum(lane >= 0 for row in self.lanes.tolist() for lane in row)

    @cached_property
    def states(self) -> int:
        """Numbers in a state: theta1, theta2, omega1, omega2 and, where the base moves, its position and speed."""
        return self.count_of_states(int(Form.BASE) in self.table[:, 1].tolist())

    @staticmethod
    def count_of_states(base_moves: bool) -> int:
        """Return how many numbers a state has."""
        return _OF_RODS + _OF_BASE * base_moves

    def of_rods(self, kept: npt.NDArray[np.bool_]) -> "Torques":
        """Return some of the effects, without directions; never those that bring states of their own."""
        kept = kept & (self.table[:, 1] != Form.BASE)
        return replace(self, table=self.table[kept], values=self.values[kept], lanes=np.full_like(self.lanes[kept], -1))


def _turning_parameter(effect: TorqueEffect) -> int:
    return [parameter.name for parameter in effect.parameters].index(effect.turns_over) if effect.turns_over else -1


NO_TORQUES = Torques()

"""The torques of effects as compiled code takes them."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from cdp_ident.model.effects.catalogue import kind_of
from cdp_ident.model.effects.constants import COUNT
from cdp_ident.model.effects.effect import JOINTS, MOST_OF_A_LAW, Form, TorqueEffect
from cdp_ident.model.equations import RODS_STATES
from cdp_ident.model.tangents import MOST_STATES

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

_PLACES = (*JOINTS, "base")


@dataclass(frozen=True)
class Torques:
    """Effects with their parameters, laid out for compiled code."""

    table: Indices = field(default_factory=lambda: np.empty((0, 6), dtype=np.int64))
    """(effects, 6) of each effect the number of its law, its form, its joint (0 inner, 1 outer), whether its torque has
    a kink or a step where the joint's speed is zero, which parameter is the speed or angle within which it changes, and
    where its own states begin, the last two -1 for none."""
    values: Array = field(default_factory=lambda: np.empty((0, 1)))
    """(effects, p) their parameters."""
    constants: Array = field(default_factory=lambda: np.zeros(COUNT))
    """What laws know of the mechanism: see `effect_constants`."""
    lanes: Indices = field(default_factory=lambda: np.empty((0, 1), dtype=np.int64))
    """(effects, p) which of the further directions each parameter is, -1 where it is none."""
    states: int = RODS_STATES
    """Numbers in a state: those of the rods, and of each effect its own."""

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

        Raises:
            ValueError: the effects bring more states of their own than there is room for.
        """
        width = max((len(parameters) for _, parameters in effects), default=0)
        width = max(width, MOST_OF_A_LAW)
        values, lanes = np.zeros((len(effects), width)), np.full((len(effects), width), -1, dtype=np.int64)
        for row, (_, parameters) in zip(values, effects, strict=True):
            row[: len(parameters)] = parameters
        for lane, (place, parameter) in enumerate(directions):
            lanes[place, parameter] = lane
        table, states = [], RODS_STATES
        for effect, _ in effects:
            own = states if effect.states else -1
            joint, turning = _PLACES.index(effect.joint), _turning_parameter(effect)
            has_kink = effect.dry or effect.form is Form.MEMORY
            table.append((kind_of(effect), effect.form, joint, has_kink, turning, own))
            states += effect.states
        if states > MOST_STATES:
            raise ValueError(
                f"a state of {states} numbers: compiled code has room for {MOST_STATES} (model/tangents.py)"
            )
        return cls(np.array(table, dtype=np.int64).reshape(-1, 6), values, constants, lanes, states)

    @cached_property
    def layout(self) -> tuple[bytes, bytes, int]:
        """What is the same for all torques that are simulated together: effects and directions, but no values."""
        return self.table.tobytes(), self.lanes.tobytes(), self.values.shape[1]

    @cached_property
    def directions(self) -> int:
        """How many further directions there are."""
        return sum(lane >= 0 for row in self.lanes.tolist() for lane in row)

    def without_directions(self) -> "Torques":
        """Return the same torques, of which no derivatives by parameters are wanted."""
        return replace(self, lanes=np.full_like(self.lanes, -1))

    def of_rods(self, kept: npt.NDArray[np.bool_]) -> "Torques":
        """Return some of the effects, without directions; never those that bring states of their own."""
        kept = kept & (self.table[:, 5] < 0)
        rods = replace(
            self, table=self.table[kept], values=self.values[kept], lanes=self.lanes[kept], states=RODS_STATES
        )
        return rods.without_directions()


def _turning_parameter(effect: TorqueEffect) -> int:
    return [parameter.name for parameter in effect.parameters].index(effect.turns_over) if effect.turns_over else -1


NO_TORQUES = Torques()

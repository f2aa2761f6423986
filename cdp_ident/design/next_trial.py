# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a next trial would tell, start by start, under every criterion."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.design.discrimination import Alternative
from cdp_ident.design.knowledge import Knowledge, Uncertainty
from cdp_ident.design.starts import CandidateTrial, Grid, Survey, information_of, survey
from cdp_ident.errors import IdentificationError
from cdp_ident.model.weights import STANDARD_PLACE_STD, STANDARD_RELATIVE_STD, Weight

Loads = tuple[tuple[Weight, ...], ...]
"""What the rods may carry: each is tried at each start."""
UNLOADED: Loads = ((),)
_SHARE = 0.1
"""Of A22 that a weight adds which is to show it: it changes the base parameters by about as much."""
_TO_ONE_SIDE = CandidateTrial(0.3, 0.5)
_WORTH_CLAMPING = 0.05
"""A weight that brings a smaller share more than the best start without one is not worth the work."""
_ALIKE = 1e-6
"""Informations of mirrored motions differ by rounding alone; these are too calm for it to grow."""


def loads_of(weights: Iterable[tuple[Weight, ...]]) -> Loads:
    """Return nothing, and each of the given sets of weights once."""
    return tuple(dict.fromkeys((*UNLOADED, *weights)))


def telling_weight(knowledge: Knowledge) -> Weight:
    """Return a weight that would show A22: at the end of the outer rod, and adding a tenth of A22 by d L^2 there.

    Mass and place are rounded to what one can have, and as well known as where a user says nothing of it.
    """
    length, _ = knowledge.model.constants(knowledge.values)
    mass = _rounded(_SHARE * knowledge.model.mechanism.inertia / length**2)
    place = _rounded(knowledge.model.mechanism.outer_length)
    return Weight("outer", mass, place, 0.0, STANDARD_RELATIVE_STD * mass, STANDARD_PLACE_STD)


def _rounded(value: float) -> float:
    """Return a number to its two leading digits."""
    return float(np.format_float_scientific(value, precision=1))


class NextTrial:
    """Starts of a next trial, whose information is computed once for all criteria and grids.

    Once `ends` returns true no motion is computed any more: what is asked then raises `IdentificationError`.
    """

    def __init__(self, knowledge: Knowledge, grid: Grid, ends: Callable[[], bool] = lambda: False) -> None:
        self.knowledge, self.grid, self._ends = knowledge, grid, ends
        self._informations: dict[CandidateTrial, Array | None] = {}
        self._symmetric = False
        self._symmetric = self._is_symmetric()

    def _is_symmetric(self) -> bool:
        """Return whether a trial on the other side of hanging tells the same, so that half of them need a look."""
        one, other = self._information(_TO_ONE_SIDE), self._information(_TO_ONE_SIDE.mirrored)
        if one is None or other is None:
            return False
        sizes, mirrored = (np.sum(rows**2, axis=0) for rows in (one, other))
        return bool(np.allclose(sizes, mirrored, rtol=_ALIKE, atol=0.0))

    def _information(self, trial: CandidateTrial) -> Array | None:
        if self._symmetric and trial.inner < 0.0:
            trial = trial.mirrored
        if trial not in self._informations:
            try:
                self._informations[trial] = information_of(trial, self.knowledge)
            except (IdentificationError, np.linalg.LinAlgError):
                self._informations[trial] = None
        return self._informations[trial]

    def uncertainty_after(self, trial: CandidateTrial, names: Sequence[str]) -> Uncertainty:
        """Return that of some unknowns after a trial, if it begins exactly where it is to."""
        return self.knowledge.uncertainty(names, self._information(trial))

    def sharpest(self, names: Sequence[str], loads: Loads = UNLOADED, grid: Grid | None = None) -> Survey:
        """Return by which trial the values of some unknowns are surest: of one, or of several together.

        Losses are the size of their uncertainty then. What the weights of the loads may be wrong by is among the
        knowledge's unknowns (`Knowledge.with_weights`). A grid says from which starts to choose, if not from all.
        """

        def loss(trial: CandidateTrial) -> float:
            return np.inf if self._information(trial) is None else self.uncertainty_after(trial, names).size

        return self._survey(loss, loads, grid or self.grid)

    def furthest_apart(self, alternative: Alternative, loads: Loads = UNLOADED) -> Survey:
        """Return by which trial an effect of the model differs most from its alternative [deviations, negative]."""
        return self._survey(lambda trial: -alternative.deviations(trial), loads, self.grid)

    def _survey(self, loss: Callable[[CandidateTrial], float], loads: Loads, grid: Grid) -> Survey:
        """Return the survey with the load that is best, or without where that is hardly worse."""
        surveys = [survey(lambda trial: np.inf if self._ends() else loss(trial), grid, load) for load in loads]
        if self._ends():
            raise IdentificationError("it was not looked for to the end")
        unloaded = next((each for each in surveys if not each.trial.weights), None)
        best = min(surveys, key=lambda each: each.expected)
        if unloaded and unloaded.expected <= best.expected + _WORTH_CLAMPING * abs(best.expected):
            best = unloaded
        return replace(best, unloaded=unloaded)

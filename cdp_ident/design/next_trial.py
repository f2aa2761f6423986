# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a next trial would tell, start by start, under every criterion."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cdp_ident.design.candidate_trial import CandidateTrial, information_of
from cdp_ident.design.criteria import Uncertainty
from cdp_ident.design.discrimination import Alternative
from cdp_ident.design.knowledge import Knowledge
from cdp_ident.design.loads import UNLOADED, Loads
from cdp_ident.design.starts import Grid, Survey, survey
from cdp_ident.errors import IdentificationError

Array = npt.NDArray[np.float64]
_TO_ONE_SIDE = CandidateTrial(np.pi + 0.3, np.pi + 0.5)
_WORTH_CLAMPING = 0.05
"""A weight that brings a smaller share more than the best start without one is not worth the work."""
_ALIKE = 1e-6
"""Informations of mirrored motions differ by rounding alone; these are too calm for it to grow."""


@dataclass(frozen=True)
class Sharper:
    """The trial that makes values surest."""

    now: Uncertainty
    """Of the values asked for, as they are."""
    then: Uncertainty
    """After the trial, if it begins exactly where it is to."""
    survey: Survey
    """With the load that is best; its losses are that size after a trial."""


class NextTrial:
    """Starts of a next trial, whose information is computed once for all criteria and grids."""

    def __init__(self, knowledge: Knowledge, grid: Grid) -> None:
        self.knowledge, self.grid = knowledge, grid
        self._informations: dict[CandidateTrial, Array | None] = {}
        self._symmetric = self._is_symmetric()

    def _is_symmetric(self) -> bool:
        """Return whether a trial on the other side of hanging tells the same, so that half of them need a look."""
        one, other = self._computed(_TO_ONE_SIDE), self._computed(_TO_ONE_SIDE.mirrored)
        if one is None or other is None:
            return False
        sizes, mirrored = (np.sum(rows**2, axis=0) for rows in (one, other))
        return bool(np.allclose(sizes, mirrored, rtol=_ALIKE, atol=0.0))

    def _computed(self, trial: CandidateTrial) -> Array | None:
        try:
            return information_of(trial, self.knowledge)
        except (IdentificationError, np.linalg.LinAlgError):
            return None

    def _information(self, trial: CandidateTrial) -> Array | None:
        if self._symmetric and trial.theta1 < np.pi:
            trial = trial.mirrored
        if trial not in self._informations:
            self._informations[trial] = self._computed(trial)
        return self._informations[trial]

    def sharpest(self, names: Sequence[str], loads: Loads = UNLOADED, grid: Grid | None = None) -> Sharper:
        """Return the trial that makes the values of these unknowns surest: one of them, or all together.

        What the weights of the loads may be wrong by is among the knowledge's unknowns (`Knowledge.with_weights`).

        Args:
            names: of the unknowns.
            loads: what the rods may carry.
            grid: of starts to choose from, if not all.
        """

        def after(gained: Array) -> Uncertainty:
            return Uncertainty.of(self.knowledge, names, np.concatenate([self.knowledge.rows, gained]))

        def loss(trial: CandidateTrial) -> float:
            rows = self._information(trial)
            return np.inf if rows is None else after(rows).size

        nothing = np.zeros((0, len(self.knowledge.values)))
        found = self._survey(loss, loads, grid or self.grid)
        gained = self._information(found.trial)
        return Sharper(after(nothing), after(nothing if gained is None else gained), found)

    def furthest_apart(self, alternative: Alternative, loads: Loads = UNLOADED) -> Survey:
        """Return by which trial an effect of the model differs most from its alternative [deviations, negative]."""
        return self._survey(lambda trial: -alternative.deviations(trial), loads, self.grid)

    def _survey(self, loss: Callable[[CandidateTrial], float], loads: Loads, grid: Grid) -> Survey:
        """Return the survey with the load that is best, or without where that is hardly worse."""
        surveys = [survey(loss, grid, load) for load in loads]
        unloaded = next((each for each in surveys if not each.weights), None)
        best = min(surveys, key=lambda each: each.expected)
        if unloaded and unloaded.expected <= best.expected + _WORTH_CLAMPING * abs(best.expected):
            best = unloaded
        return replace(best, unloaded=unloaded)

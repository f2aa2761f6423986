# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The outcome of a search for the effects that a model lacks."""

from dataclasses import dataclass
from typing import Literal

from cdp_ident.likelihood.scores import Score
from cdp_ident.likelihood.whole_swing import WholeSwings
from cdp_ident.tracing.odds import log10_odds

Certainty = Literal["named", "probable", "acts_like"]
"""How sure an effect's name is."""


@dataclass(frozen=True)
class Tried:
    """A model that was fitted at a step."""

    effects: tuple[str, ...]
    """Keys of the effects that it has and the model before had not; where none, those that it has no longer."""
    misfit: float
    """Of the model less that of the one before: below zero it is the more likely one."""

    @property
    def log10_odds(self) -> float:
        """Of the model against the one before."""
        return log10_odds(self.misfit)


@dataclass(frozen=True)
class Step:
    """One step of the search."""

    action: str
    """What was done: added, dropped or exchanged, and what."""
    misfit: float
    """Of the model after it less that of the paper's model."""
    tried: tuple[Tried, ...]

    @property
    def log10_odds(self) -> float:
        """Of the model after it against the paper's."""
        return log10_odds(self.misfit)


@dataclass(frozen=True)
class Selection:
    """Where a search ended."""

    before: WholeSwings
    """The paper's model."""
    after: WholeSwings
    """The most probable model."""
    steps: tuple[Step, ...]
    without: tuple[WholeSwings | None, ...]
    """That model without each of its effects; None where that cannot be fitted."""
    probability: tuple[float, ...]
    """That each of its effects is there, among all models that were fitted."""
    also_possible: tuple[tuple[str, ...], ...]
    """Keys of the effects that the data do not distinguish from each one."""
    certainty: tuple[Certainty, ...]
    """How sure the name of each effect of `after` is."""
    scores: tuple[Score, ...]
    """What each effect that it does not have would do for it."""
    failures: tuple[str, ...]
    """What could not be computed, in words."""
    interrupted: bool
    looked_in: float
    """Motion in which effects were looked for [s]."""

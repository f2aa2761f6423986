# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Two roles of motion: what is fitted, by which effects are chosen, too, and what is held out to the end.

The error over motion that was used to choose between models is too small for the chosen model, as is the error over
fitted motion (Hastie, Tibshirani and Friedman, The Elements of Statistical Learning, 2009, Section 7.2). So some motion
is held out before anything is estimated, noise and scales included, and used once, when everything is decided.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cdp_ident.trial.trial import Trial

_PIECE = 8.0
"""Length of a stretch that is held out of a trial, in time units: some two windows of fast motion."""
_CYCLE = 6
"""Where no trials are held out, the fourth of every so many pieces of each trial is, the first after half of them."""


@dataclass(frozen=True)
class PartedTrial:
    """A trial, and which of its stretches are held out."""

    trial: Trial
    held_out: frozenset[int]
    """Indices of the stretches that neither the fit nor the choice of effects uses."""
    measured: Trial
    """The trial as it was measured, without breaks between roles."""

    @property
    def is_fitted(self) -> bool:
        """Whether any of it is fitted."""
        return len(self.held_out) < len(self.trial.bounds)

    @property
    def shown(self) -> Trial:
        """The trial without what is held out; times stay those of the whole trial."""
        bounds = [bound for index, bound in enumerate(self.trial.bounds) if index not in self.held_out]
        samples = np.concatenate([np.arange(first, last) for first, last in bounds])
        lengths = np.cumsum([last - first for first, last in bounds])
        trial = self.trial
        return replace(trial[samples], breaks=tuple(int(end) for end in lengths[:-1]))


def assign_roles(fit: Sequence[Trial], holdout: Sequence[Trial], time_unit: float) -> list[PartedTrial]:
    """Return all trials, those to hold out last; without any of these, stretches of the others are held out.

    Args:
        fit: trials to fit, and to choose effects by.
        holdout: trials to hold out.
        time_unit: sqrt(L / g) [s].
    """
    if holdout:
        whole = [PartedTrial(trial, frozenset(range(len(trial.bounds))), trial) for trial in holdout]
        return [*(PartedTrial(trial, frozenset(), trial) for trial in fit), *whole]
    return [_parted(trial, time_unit) for trial in fit]


def _parted(trial: Trial, time_unit: float) -> PartedTrial:
    cycles = max(1, round(trial.duration / (_CYCLE * _PIECE * time_unit)))
    piece = trial.duration / (_CYCLE * cycles)
    begins = trial.time[0] + piece * (_CYCLE // 2 + _CYCLE * np.arange(cycles))
    edges = np.searchsorted(trial.time, np.concatenate([begins, begins + piece]))
    breaks = sorted({*trial.breaks, *(int(edge) for edge in edges)} - {0, len(trial.time)})
    parted = replace(trial, breaks=tuple(breaks))
    since = [(trial.time[first] - trial.time[0]) / piece for first, _ in parted.bounds]
    held_out = frozenset(index for index, at in enumerate(since) if int(at) % _CYCLE == _CYCLE // 2)
    return PartedTrial(parted, held_out, trial)

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is looked at: the swings of the trials that are fitted, or of everything that was measured."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.fit.data import Data
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.windows import share_of
from cdp_ident.likelihood.swing import Swing
from cdp_ident.likelihood.whole_swing import Recorded
from cdp_ident.trial.trial import Trial

_LEAST_SHARE = 0.3
"""The outer encoder's noise is at least so much of the inner one's."""
_PIECE = 40.0
"""Pieces of long recordings, in time units: eight seconds of the paper's rig, so that effects whose states are unknown
where a piece begins are still seen."""
Piece = tuple[int, int, int]
"""Of a trial: its number, the first sample, and the end."""


def all_recorded(data: Data, spacing: float) -> Recorded:
    """Return everything as it was measured, with nodes of a spacing in time units."""
    swings = [
        swing
        for index, (trial, of_fit) in enumerate(zip(data.measured, data.trials, strict=True))
        for swing in _swings(data, trial, index, spacing, trial.bounds, trial.start - of_fit.start)
    ]
    averaged = sum(len(trial.time) for trial in data.trials) / sum(len(trial.time) for trial in data.measured)
    return _recorded(data, swings, averaged**-0.5)


def fitted_recorded(data: Data, spacing: float, enough: float) -> Recorded:
    """Return what is fitted, averaged as it is; of more motion than enough [s], pieces that are spread evenly."""
    stretches = [
        (index, first, last)
        for index, trial in enumerate(data.trials)
        for first, last in trial.bounds
        if any(window.trial == index and first <= window.first < last for window in data.fit)
    ]
    swings = list[Swing]()
    for index, first, last in spread_evenly(data.trials, stretches, enough, data.scales.time_unit):
        swings += _swings(data, data.trials[index], index, spacing, [(first, last)])
    return _recorded(data, swings)


def one_recorded(data: Data, trial: Trial, index: int, spacing: float) -> Recorded:
    """Return another trial of the rig, with nodes of a spacing in time units; by its number effects of a trial go."""
    return _recorded(data, _swings(data, trial, index, spacing, trial.bounds))


def spread_evenly(trials: Sequence[Trial], stretches: Sequence[Piece], enough: float, unit: float) -> list[Piece]:
    """Return pieces of trials that are spread evenly over stretches of them, and hold enough motion.

    Args:
        trials: of which they are.
        stretches: of these.
        enough: motion [s]; where there is no more, all stretches are returned.
        unit: the rig's time unit [s].
    """

    def lasts(piece: Piece) -> float:
        index, first, last = piece
        return float(trials[index].time[last - 1] - trials[index].time[first])

    if sum(map(lasts, stretches)) <= enough:
        return list(stretches)
    pieces = list[Piece]()
    for index, first, last in stretches:
        count = max(1, round(lasts((index, first, last)) / (_PIECE * unit)))
        edges = np.linspace(first, last, count + 1).astype(int).tolist()
        pieces += [(index, begin, end) for begin, end in pairwise(edges)]
    return [pieces[place] for place in share_of([lasts(piece) for piece in pieces], enough)]


def states_of(recorded: Recorded, model: MotionModel) -> list[Array]:
    """Return states (nodes, states) of each swing to begin with; see `Swing.states`."""
    return [swing.states(model) for swing in recorded.swings]


def _swings(
    data: Data, trial: Trial, index: int, spacing: float, bounds: Sequence[tuple[int, int]], begin: float = 0.0
) -> list[Swing]:
    scales = data.scales
    nodes = spacing * scales.time_unit
    return Swing.of(trial, index, scales.step, nodes, begin, bounds, scales.encoder_steps)


def _recorded(data: Data, swings: Sequence[Swing], noise: float = 1.0) -> Recorded:
    """Return swings whose noise is so many times that of what is fitted."""
    inner, both = (noise * data.noise) ** 2
    encoders = np.sqrt([inner, max(both - inner, _LEAST_SHARE**2 * inner)])
    return Recorded(tuple(swings), encoders, data.scales.encoder_steps, data.scales.time_unit)

"""What is looked at: the swings of the trials that are fitted, or of everything that was measured."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from cdp_ident.fit.data import Data
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.windows import Window
from cdp_ident.likelihood.swing import Swing
from cdp_ident.likelihood.whole_swing import Recorded
from cdp_ident.trial.trial import Trial

Array = npt.NDArray[np.float64]

_LEAST_SHARE = 0.3
"""The outer encoder's noise is at least so much of the inner one's."""
_PIECE = 40.0
"""Pieces of long recordings, in time units: eight seconds of the paper's rig, so that effects whose states are unknown
where a piece begins are still seen."""
_GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0
"""Its multiples, modulo one, are nowhere dense and nowhere sparse (Weyl, Math. Ann. 77, 1916)."""


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
    pieces = [piece for index in range(len(data.trials)) for piece in _pieces(data, index, enough)]
    order = np.argsort(np.arange(len(pieces)) * _GOLDEN % 1.0, kind="stable")
    motion = np.cumsum([pieces[place][3] for place in order])
    chosen = sorted(order[: max(1, int(np.searchsorted(motion, enough * (1.0 + 1e-9))))].tolist())
    swings = list[Swing]()
    for place in chosen:
        index, first, last, _ = pieces[place]
        swings += _swings(data, data.trials[index], index, spacing, [(first, last)])
    return _recorded(data, swings)


def one_recorded(data: Data, trial: Trial, index: int, spacing: float) -> Recorded:
    """Return another trial of the rig, with nodes of a spacing in time units; by its number effects of a trial go."""
    return _recorded(data, _swings(data, trial, index, spacing, trial.bounds))


def _pieces(data: Data, index: int, enough: float) -> list[tuple[int, int, int, float]]:
    """Return trial, first sample, end and duration [s] of the pieces of a trial that are fitted."""
    trial, windows = data.trials[index], [window for window in data.fit if window.trial == index]
    stretches = [bounds for bounds in trial.bounds if any(bounds[0] <= window.first < bounds[1] for window in windows)]
    total = sum(window.duration for window in data.fit)
    length = np.inf if total <= enough else _PIECE * data.scales.time_unit
    pieces = []
    for first, last in stretches:
        count = max(1, round(float(trial.time[last - 1] - trial.time[first]) / length)) if np.isfinite(length) else 1
        edges = np.linspace(first, last, count + 1).astype(int).tolist()
        for begin, end in pairwise(edges):
            pieces.append((index, begin, end, float(trial.time[end - 1] - trial.time[begin])))
    return pieces


def states_of(recorded: Recorded, model: MotionModel, values: Array, windows: Sequence[Window]) -> list[Array]:
    """Return states (nodes, states) of each swing to begin with; see `Swing.states`."""
    return [swing.states(model, values, windows) for swing in recorded.swings]


def _swings(
    data: Data, trial: Trial, index: int, spacing: float, bounds: Sequence[tuple[int, int]], begin: float = 0.0
) -> list[Swing]:
    scales = data.scales
    nodes = spacing * scales.time_unit
    return Swing.of(trial, index, scales.step, nodes, scales.half_width, scales.encoder_steps, begin, bounds)


def _recorded(data: Data, swings: Sequence[Swing], noise: float = 1.0) -> Recorded:
    """Return swings whose noise is so many times that of what is fitted."""
    inner, both = (noise * data.noise) ** 2
    encoders = np.sqrt([inner, max(both - inner, _LEAST_SHARE**2 * inner)])
    return Recorded(tuple(swings), encoders, data.scales.encoder_steps, data.scales.time_unit)

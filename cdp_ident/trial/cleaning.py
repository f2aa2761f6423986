# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From samples as they came to pieces of continuous angles at strictly increasing times."""

from dataclasses import dataclass, replace

import numpy as np

from cdp_ident.arrays import Array, Rows
from cdp_ident.trial.joints import Samples
from cdp_ident.trial.order import elapsed
from cdp_ident.trial.outliers import TURN, outliers
from cdp_ident.trial.sample_times import evened

_TOLD = 3
"""So many gaps, and steps back of the clock, are told with their places."""


@dataclass(frozen=True)
class Piece(Rows):
    """Samples at known times, in the end a stretch without a gap in which full turns could be lost."""

    samples: Samples
    """As recorded, at strictly increasing stamps, except where the clock was set back; angles of a stretch are
    continuous."""
    time: Array
    """(n,) since the recording's first sample [s]; where the clock was set back, it stands still for one sample."""


def clean(samples: Samples, start: float = 0.0, stop: float = np.inf) -> tuple[Piece, Array, list[str]]:
    """Take samples in the order of time from `start` to `stop` [s] after the first, without the outliers.

    Of several with one stamp the first is kept, unless they came in a burst (`evened`). An outlier of one joint makes
    the whole sample one: it is left out, as if its frame had been lost, before angles are unwrapped, as turns would be
    counted by it.

    Returns them, the times at which outliers were left out [s], and what was dropped, in words.
    """
    set_back = np.diff(samples.stamps) < 0
    angles = samples.angles * (TURN / np.array(samples.turns))
    time, notes = evened(elapsed(samples.stamps), angles, np.flatnonzero(set_back) + 1)
    first = np.concatenate([[True], (np.diff(time) > 0) | set_back])[: len(time)]
    if repeated := int(np.count_nonzero(~first)):
        notes.append(f"{repeated} samples with a stamp that was there already are dropped")
    taken = Piece(samples, time)[first & (time >= start) & (time <= stop)]
    joints = zip(taken.samples.angles.T, samples.turns, strict=True)
    outlying = np.logical_or(*(outliers(taken.time - taken.time[:1], angle, turn) for angle, turn in joints))
    return taken[~outlying], taken.time[outlying], notes


def cut_at_gaps(cleaned: Piece, outlying: Array, longest_gap: float) -> tuple[list[Piece], list[str]]:
    """Part a recording at gaps longer than `longest_gap` [s], and unwrap the angles.

    `outlying` are the times at which outliers were left out. Returns the pieces in the order of the recording, and what
    was found in words.
    """
    notes = []
    samples, time = cleaned.samples, cleaned.time
    gaps = np.diff(time)
    long = np.flatnonzero(gaps > longest_gap) + 1
    steps = np.flatnonzero(gaps <= 0.0) + 1
    typical = float(np.median(gaps)) if len(gaps) else 0.0
    short = (gaps > 1.5 * typical) & (gaps <= longest_gap) & (np.diff(np.searchsorted(outlying, time)) == 0)
    if np.any(short):
        notes.append(f"{np.count_nonzero(short)} gaps of up to {gaps[short].max() * 1e3:.0f} ms are kept as they are")
    set_back = -1e-9 * np.diff(samples.stamps)
    for places, sizes, words in (
        (long, gaps, "a gap of {:.3f} s at {:.3f} s parts the recording"),
        (steps, set_back, "the clock was set back by {:.3f} s at {:.3f} s, which parts the recording"),
    ):
        notes += [words.format(sizes[at - 1], time[at - 1]) for at in places[:_TOLD]]
        if len(places) > _TOLD:
            notes.append(f"{len(places) - _TOLD} more such places part it, too")
    edges = np.unique(np.concatenate([long, steps]))
    pieces = [cleaned[part] for part in np.split(np.arange(len(time)), edges)]
    return [replace(of, samples=replace(of.samples, angles=of.samples.unwrapped)) for of in pieces], notes

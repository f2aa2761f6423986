# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From samples as they came to pieces of continuous angles at strictly increasing times."""

from dataclasses import dataclass

import numpy as np

from cdp_ident.arrays import Array, Mask, Rows
from cdp_ident.trial.joints import Samples
from cdp_ident.trial.order import elapsed
from cdp_ident.trial.outliers import TURN, outliers
from cdp_ident.trial.sample_times import evened

_TOLD = 3
"""So many gaps, and steps back of the clock, are told with their places."""


@dataclass(frozen=True)
class Cleaned:
    """The samples of a recording, outliers marked."""

    samples: Samples
    """At strictly increasing stamps, except where the clock was set back."""
    time: Array
    """(n,) since the recording's first sample [s]; where the clock was set back, it stands still for one sample."""
    outlier: Mask
    """(n,) which are outliers of a joint, and to be left out."""
    notes: tuple[str, ...]
    """What was dropped, in words."""


@dataclass(frozen=True)
class Piece(Rows):
    """A stretch of samples without a gap in which full turns could be lost."""

    time: Array
    """(n,) time since the recording's first sample [s], strictly increasing."""
    angles: Array
    """(n, 2) continuous angles of the inner and outer joint as recorded [rad]."""
    cart: Array | None
    """(n,) position of the cart [m]."""
    torques: Array | None
    """(n, 2) torques of motors in the joints, as recorded."""
    outliers: tuple[float, ...]
    """Times between these at which outliers were left out [s]."""


def clean(samples: Samples, start: float = 0.0, stop: float = np.inf) -> Cleaned:
    """Take samples in the order of time from `start` to `stop` [s] after the first, and find the outliers.

    Of several with one stamp the first is kept, unless they came in a burst (`evened`). An outlier of one joint makes
    the whole sample one: it is left out, as if its frame had been lost, before angles are unwrapped, as turns would be
    counted by it.
    """
    set_back = np.diff(samples.stamps) < 0
    angles = samples.angles * (TURN / np.array(samples.turns))
    time, notes = evened(elapsed(samples.stamps), angles, np.flatnonzero(set_back) + 1)
    first = np.concatenate([[True], (np.diff(time) > 0) | set_back])[: len(time)]
    if repeated := int(np.count_nonzero(~first)):
        notes.append(f"{repeated} samples with a stamp that was there already are dropped")
    chosen = first & (time >= start) & (time <= stop)
    kept, time = samples[chosen], time[chosen]
    joints = zip(kept.angles.T, samples.turns, strict=True)
    found = [outliers(time - time[0], angle, turn) for angle, turn in joints] if len(time) else [chosen, chosen]
    return Cleaned(kept, time, np.logical_or(*found), tuple(notes))


def cut_at_gaps(cleaned: Cleaned, longest_gap: float) -> tuple[list[Piece], list[str]]:
    """Part a recording at gaps longer than `longest_gap` [s], leave out its outliers, and unwrap the angles.

    Returns the pieces in the order of the recording, and what was found in words.
    """
    notes = []
    samples, times = cleaned.samples, cleaned.time
    kept = np.flatnonzero(~cleaned.outlier)
    time = times[kept]
    gaps = np.diff(time)
    long = np.flatnonzero(gaps > longest_gap) + 1
    steps = np.flatnonzero(gaps <= 0.0) + 1
    typical = float(np.median(gaps)) if len(gaps) else 0.0
    short = (gaps > 1.5 * typical) & (gaps <= longest_gap) & (np.diff(kept) == 1)
    if np.any(short):
        notes.append(f"{np.count_nonzero(short)} gaps of up to {gaps[short].max() * 1e3:.0f} ms are kept as they are")
    set_back = -1e-9 * np.diff(samples.stamps[kept])
    for places, sizes, words in (
        (long, gaps, "a gap of {:.3f} s at {:.3f} s parts the recording"),
        (steps, set_back, "the clock was set back by {:.3f} s at {:.3f} s, which parts the recording"),
    ):
        notes += [words.format(sizes[at - 1], time[at - 1]) for at in places[:_TOLD]]
        if len(places) > _TOLD:
            notes.append(f"{len(places) - _TOLD} more such places part it, too")
    pieces = []
    for chosen in np.split(kept, np.unique(np.concatenate([long, steps]))):
        between = np.setdiff1d(np.arange(chosen[0], chosen[-1]), chosen)
        measured, left_out = samples[chosen], tuple(times[between].tolist())
        pieces.append(Piece(times[chosen], measured.unwrapped, measured.cart, measured.torques, left_out))
    return pieces, notes

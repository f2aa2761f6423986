"""From samples as they came to pieces of continuous angles at strictly increasing times."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.trial.joints import Samples
from cdp_ident.trial.outliers import TURN, outliers

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]
Mask = npt.NDArray[np.bool_]

_CLOCK_STEP = 5
"""So many samples in a row that go on from an earlier time mean that the clock was set back."""


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

    @property
    def measurements(self) -> Samples:
        """The samples that are not outliers."""
        return self.samples[~self.outlier]


@dataclass(frozen=True)
class Piece:
    """A stretch of samples without a gap in which full turns could be lost."""

    time: Array
    """(n,) time since the recording's first sample [s], strictly increasing."""
    angles: Array
    """(n, 2) continuous angles of the inner and outer joint as recorded [rad]."""
    cart: Array | None
    """(n,) position of the cart [m]."""
    outliers: Array
    """(k,) times between these at which outliers were left out [s]."""


def clean(samples: Samples, start: float = 0.0, stop: float = np.inf) -> Cleaned:
    """Drop repeated and late samples, take those from `start` to `stop` [s] after the first, and find the outliers.

    An outlier of one joint makes the whole sample one: it is left out, as if its frame had been lost, before angles are
    unwrapped, as turns would be counted by it.
    """
    notes = []
    keep, duplicates, backwards = _in_order(samples.stamps)
    if duplicates:
        notes.append(f"{duplicates} samples with a stamp that was there already are dropped")
    if backwards:
        notes.append(f"{backwards} samples with a stamp earlier than the one before are dropped")
    time = elapsed(samples.stamps[keep])
    chosen = (time >= start) & (time <= stop)
    kept, time = samples[keep[chosen]], time[chosen]
    found = [outliers(time - time[0], angle, TURN) for angle in kept.angles.T] if len(time) else [chosen, chosen]
    return Cleaned(kept, time, np.logical_or(*found), tuple(notes))


def elapsed(stamps: Indices) -> Array:
    """Return how long after the first of some stamps each of them was [s], as if no clock had been set back."""
    set_back = np.concatenate([[0], np.minimum(np.diff(stamps), 0)])
    # Differences of the integers first: a float of seconds since 1970 does not resolve nanoseconds.
    return np.asarray(stamps - stamps[0] - np.cumsum(set_back), dtype=float) * 1e-9


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
    for at in long[:3]:
        notes.append(f"a gap of {gaps[at - 1]:.3f} s at {time[at - 1]:.3f} s parts the recording")
    if len(long) > 3:
        notes.append(f"{len(long) - 3} more gaps longer than {longest_gap:.3g} s part it too")
    set_back = -1e-9 * np.diff(samples.stamps[kept])
    for at in steps[:3]:
        notes.append(
            f"the clock was set back by {set_back[at - 1]:.3f} s at {time[at - 1]:.3f} s, which parts the recording"
        )
    pieces = []
    for chosen in np.split(kept, np.unique(np.concatenate([long, steps]))):
        between = np.setdiff1d(np.arange(chosen[0], chosen[-1]), chosen)
        measured = samples[chosen]
        pieces.append(
            Piece(times[chosen], np.asarray(np.unwrap(measured.angles, axis=0)), measured.cart, times[between])
        )
    return pieces, notes


def _in_order(stamps: Indices) -> tuple[Indices, int, int]:
    """Choose the samples to keep.

    Returns their indices, and how many samples are left out because their stamp was there already or because it is
    earlier than the one before. Where the clock was set back, the kept go on from an earlier time.
    """
    if np.all(np.diff(stamps) > 0):
        return np.arange(len(stamps)), 0, 0
    keep: list[int] = []
    late: list[int] = []
    duplicates = backwards = 0
    for i, stamp in enumerate(stamps.tolist()):
        if not keep or stamp > stamps[keep[-1]]:
            backwards += len(late)
            late.clear()
            keep.append(i)
        elif stamp == stamps[keep[-1]] or (late and stamp == stamps[late[-1]]):
            duplicates += 1
        else:
            if late and stamp < stamps[late[-1]]:
                backwards += len(late)
                late.clear()
            late.append(i)
            if len(late) == _CLOCK_STEP:
                keep += late
                late.clear()
    return np.array(keep), duplicates, backwards + len(late)

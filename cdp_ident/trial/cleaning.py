"""From samples as they came to pieces of continuous angles at strictly increasing times."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.trial.joints import Samples
from cdp_ident.trial.outliers import outlier_notes, outliers

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

_CLOCK_STEP = 5
"""So many samples in a row that go on from an earlier time mean that the clock was set back."""


@dataclass(frozen=True)
class Piece:
    """A stretch of samples without a gap that turns could be lost in."""

    time: Array
    """(n,) time since the origin [s], strictly increasing."""
    angles: Array
    """(n, 2) continuous angles of the inner and outer joint as recorded [rad]."""
    cart: Array | None
    """(n,) position of the cart [m]."""


def clean(samples: Samples, longest_gap: float, origin: int) -> tuple[list[Piece], list[str]]:
    """Drop repeated and late samples, part the recording at gaps longer than `longest_gap` [s], and unwrap the angles.

    `origin` is the stamp that times are counted from [ns since the epoch]. Returns the pieces in the order of the
    recording, and what was done in words.
    """
    notes = []
    keep, steps, duplicates, backwards = _in_order(samples.stamps)
    if duplicates:
        notes.append(f"{duplicates} samples with a stamp that was there already are dropped")
    if backwards:
        notes.append(f"{backwards} samples with a stamp earlier than the one before are dropped")
    # Differences of the integers first: seconds since 1970 have no room for nanoseconds in a float.
    time = np.asarray(samples.stamps[keep] - origin, dtype=float) * 1e-9
    gaps = np.diff(time)
    long = np.flatnonzero(gaps > longest_gap) + 1
    typical = float(np.median(gaps)) if len(gaps) else 0.0
    short = np.count_nonzero((gaps > 1.5 * typical) & (gaps <= longest_gap))
    if short:
        notes.append(f"{short} gaps of up to {gaps[gaps <= longest_gap].max() * 1e3:.0f} ms are kept as they are")
    for at in long[:3]:
        notes.append(f"a gap of {gaps[at - 1]:.3f} s at {time[at - 1]:.3f} s parts the recording")
    if len(long) > 3:
        notes.append(f"{len(long) - 3} more gaps longer than {longest_gap:.3g} s part it too")
    for at in steps[:3]:
        notes.append(
            f"the clock was set back by {-gaps[at - 1]:.3f} s at {time[at - 1]:.3f} s, which parts the recording"
        )
    borders = np.unique(np.concatenate([long, steps]))
    angles, cart = samples.angles[keep], None if samples.cart is None else samples.cart[keep]
    pieces = [
        Piece(time[part], np.asarray(np.unwrap(angles[part], axis=0)), None if cart is None else cart[part])
        for part in np.split(np.arange(len(time)), borders)
    ]
    found = [outliers(piece.time, piece.angles) for piece in pieces]
    notes += outlier_notes(np.concatenate([time for time, _ in found]), np.concatenate([size for _, size in found]))
    return pieces, notes


def _in_order(stamps: Indices) -> tuple[Indices, Indices, int, int]:
    """Choose the samples to keep.

    Returns their indices, the places among them where the clock was set back, and how many samples are left out
    because their stamp was there already or because it is earlier than the one before.
    """
    if np.all(np.diff(stamps) > 0):
        return np.arange(len(stamps)), np.empty(0, dtype=np.int64), 0, 0
    keep: list[int] = []
    steps: list[int] = []
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
                steps.append(len(keep))
                keep += late
                late.clear()
    return np.array(keep), np.array(steps, dtype=np.int64), duplicates, backwards + len(late)

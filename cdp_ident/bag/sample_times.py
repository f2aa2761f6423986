"""When samples were measured: by the stamps of their headers, or by the times of receipt."""

from typing import Literal

import numpy as np
import numpy.typing as npt

Times = npt.NDArray[np.int64]
Time = Literal["auto", "stamps", "receipt"]

_FEWEST = 20
_BLOCKS = 4
"""Parts of a recording that are looked at, each by itself: a clock may be set in one of them."""
_FEW = 20
"""With so many times fewer stamps than times of receipt, stamps tell nothing."""
_OFF = 0.25
"""Stamps are wrong where they stray from the times of receipt by more than this share of the spacing (rms), ..."""
_WORSE = 5.0
"""... and by so many times what the times of receipt themselves stray from even ones."""
_EVEN = 0.5
"""Share of that by which stamps, sorted, may stray from even times and be good."""
_RATE = 0.02
"""Share by which the durations by both clocks may differ, and beside it the rounding of stamps to whole seconds."""
_SECOND = 1_000_000_000


def sample_times(stamps: Times, receipts: Times, time: Time) -> tuple[Times, Times, list[str]]:
    """Return the times of samples (n,) [ns since the epoch], which samples have one, and what there is to say about it.

    Args:
        stamps: (n,) of the headers [ns since the epoch]; 0 where there is none.
        receipts: (n,) times of receipt, ascending [ns since the epoch].
        time: what to take; by itself it is the time of receipt only where stamps are missing or tell nothing.
    """
    stamped = stamps > 0
    missing = len(stamps) - int(np.count_nonzero(stamped))
    fault = "are missing" if 2 * missing > len(stamps) else _fault(stamps[stamped], receipts[stamped])
    if time == "receipt" or (time == "auto" and fault):
        why = f"the stamps {fault}: " if fault else ""
        return receipts, np.arange(len(stamps)), [f"{why}the time of receipt is used, with its jitter"]
    notes = [f"the stamps {fault}; they are used all the same"] if fault else []
    if missing:
        notes.append(f"{missing} messages without a stamp are dropped")
    return stamps, np.flatnonzero(stamped), notes


def _fault(stamps: Times, receipts: Times) -> str:
    """Say why stamps tell nothing where the times of receipt do; empty where they are good, or both are bad."""
    if len(stamps) < _FEWEST or receipts[-1] == receipts[0]:
        return ""
    # Differences of the integers first: a float does not resolve nanoseconds since 1970.
    by_stamp, by_receipt = ((times - times[0]) * 1e-9 for times in (stamps, receipts))
    lasts = float(by_receipt[-1])
    says_nothing = _FEW * len(np.unique(stamps)) <= len(np.unique(receipts))
    if not says_nothing and abs(by_stamp[-1] - lasts) > max(_RATE * lasts, 1.0 + lasts / len(stamps)):
        return ""
    even = _chords(np.arange(len(stamps), dtype=float), by_receipt)
    off, uneven = _scatter(by_stamp - by_receipt), _scatter(by_receipt - even)
    if off < max(_OFF * lasts / len(stamps), _WORSE * uneven):
        return ""
    # Stored in another order, stamps are far from the times of receipt, too, but even ones by themselves.
    in_order = np.sort(by_stamp)
    if not says_nothing and np.std(in_order - np.linspace(in_order[0], in_order[-1], len(in_order))) < _EVEN * off:
        return ""
    largest = int(np.max(stamps % _SECOND))
    if largest == 0:
        return "are whole seconds"
    if largest < 1_000_000:
        return f"hold {'milli' if largest < 1000 else 'micro'}seconds where nanoseconds belong"
    return f"are not the times of the samples ({len(np.unique(stamps))} different ones in {lasts:.3g} s)"


def _chords(x: npt.NDArray[np.float64], y: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return straight lines from the first to the last y (n,) of each block, over x."""
    parts = zip(np.array_split(x, _BLOCKS), np.array_split(y, _BLOCKS), strict=True)
    return np.concatenate([np.interp(at, at[[0, -1]], values[[0, -1]]) for at, values in parts])


def _scatter(values: npt.NDArray[np.float64]) -> float:
    """Return the standard deviation of values in the typical block."""
    return float(np.median([np.std(part) for part in np.array_split(values, _BLOCKS)]))

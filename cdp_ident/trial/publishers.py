"""Two publishers on one topic: samples go to and fro between two motions."""

import numpy as np

from cdp_ident.arrays import Array, Mask
from cdp_ident.errors import TrialError

_FEWEST = 10
"""Turns of a second publisher before it is one."""
_SHARE = 0.05
"""Least share of the samples that a second publisher has."""
_RUN = 3.0
"""A publisher that never moves says the same not much more often than this in a row, as the other speaks between."""
_FAR = 0.05
"""Distance from one motion to the other that is no noise [rad or degrees]."""
_NEARER = 5.0
"""So many times nearer is a sample to one of the next few than to the next one, where two motions alternate."""
_NEXT = 4


def still_publisher(readings: Array) -> tuple[Mask, str]:
    """Return which samples (n, 2) come from a second publisher that never moves (n,), and in words that it is there."""
    none = np.zeros(len(readings), dtype=bool)
    if not len(readings):
        return none, ""
    values, place, counts = np.unique(readings @ [1.0, 1.0j], return_inverse=True, return_counts=True)
    most = int(np.argmax(counts))
    still = np.asarray(place == most)
    before = np.flatnonzero(still[1:] & ~still[:-1])
    is_rare = len(before) < _FEWEST or counts[most] < _SHARE * len(readings)
    if is_rare or counts[most] > _RUN * (len(before) + 1):
        return none, ""
    value = np.array([values[most].real, values[most].imag])
    if np.median(np.max(np.abs(readings[before] - value), axis=1)) < _FAR:
        return none, ""
    shown = " and ".join(f"{position:.4g}" for position in value)
    return still, (
        f"a second publisher that never moves says {shown} on the same topic: its {counts[most]} messages are left out"
    )


def alternates(readings: Array) -> bool:
    """Return whether samples (n, 2) go to and fro between two motions."""
    if len(readings) < 4 * _NEXT:
        return False
    apart = [np.max(np.abs(readings[k:] - readings[:-k])[: len(readings) - _NEXT], axis=1) for k in range(1, _NEXT + 1)]
    next_one, nearest = np.median(apart[0]), np.median(np.min(apart[1:], axis=0))
    return bool(next_one > max(_FAR, _NEARER * nearest))


def check_publishers(readings: Array, topic: str) -> None:
    """Raise TrialError where samples of a topic (n, 2) go to and fro between two motions."""
    if alternates(readings):
        raise TrialError(
            f"samples on {topic} alternate between two motions (two publishers, two rigs?): record one of them, or "
            "give each a topic of its own"
        )

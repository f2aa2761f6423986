"""What readings are before they are angles: repeated, wrapped at the limits of a counter, or of two publishers."""

import numpy as np

from cdp_ident.arrays import Array, Mask
from cdp_ident.errors import TrialError
from cdp_ident.trial.differences import encoder_step

_FAST = 3.5
"""Steps of the encoder in a change of readings that is motion, in which none is repeated by rounding."""
_FEWEST = 20
_REPEATED, _STEPS = 1.05, 100.0
"""Mean numbers of equal readings in fast motion between which they are repetitions; beyond, they are no angle's."""
_AT_REST = 0.9
"""At rest one of so many equal readings is kept as this quantile of their numbers in fast motion."""
_JUMP = 0.5
"""A change by more than this share of all that the readings go through is not motion."""
_STAYS = 3
"""A jump back within so many samples is that of a spike."""
_LIKE = 0.02
"""Share by which a wrap may seem to differ from a power of two of the encoder's steps, or from a turn."""
_TURNS = 10
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


def new_readings(readings: Array) -> tuple[Mask, str]:
    """Return which readings (n,) are measured anew (n,), and in words what the others are; empty if all are.

    An encoder that is read less often than it is published, or a film's repeated frame, gives the same reading again
    in the midst of fast motion. At rest, where readings are the same anyway, as many are kept as in motion.
    """
    every = np.ones(len(readings), dtype=bool)
    changes = np.flatnonzero(np.diff(readings)) + 1
    starts = np.concatenate([[0], changes, [len(readings)]])
    fast = np.abs(np.diff(readings)[changes - 1]) > _FAST * encoder_step(readings)
    lengths = np.diff(starts)
    in_motion = lengths[1:-1][fast[:-1] & fast[1:]]
    if len(in_motion) < _FEWEST or not _REPEATED <= np.mean(in_motion) < _STEPS:
        return every, ""
    keep = np.ceil(np.quantile(in_motion, _AT_REST))
    new = (np.arange(len(readings)) - np.repeat(starts[:-1], lengths)) % keep == 0
    note = f"repeat {np.mean(in_motion):.2g} times in motion: {np.count_nonzero(~new)} repetitions are left out"
    return np.asarray(new), note


def continuous(readings: Array) -> tuple[Array, float, str]:
    """Return readings (n,) without the jumps of a counter of a few bits or of degrees, and in words what was found.

    The second value is the counter's range, 0 where there is none: from which of its ranges it began is not known.
    Readings that go on after a full turn of 2 pi are left as they are.
    """
    steps = np.diff(readings)
    if len(steps) <= _STAYS:
        return readings, 0.0, ""
    sizes = []
    for at in np.flatnonzero(np.abs(steps) > _JUMP * np.ptp(readings)):
        back = steps[at + 1 : at + 1 + _STAYS]
        if 0 < at < len(steps) - 1 and not np.any(np.abs(back + steps[at]) < _JUMP * abs(steps[at])):
            sizes.append(abs(steps[at] - 0.5 * (steps[at - 1] + steps[at + 1])))
    if not sizes:
        return readings, 0.0, ""
    size = float(np.median(sizes))
    turns = size / (2.0 * np.pi)
    if round(turns) and abs(turns - round(turns)) < _LIKE:
        return readings, 0.0, ""
    counts = size / step if (step := encoder_step(readings)) else 1.0
    bits = round(np.log2(max(counts, 1.0)))
    if bits >= 8 and abs(counts / 2**bits - 1.0) < _LIKE:
        period = 2**bits * step
        counted_on = np.asarray(np.unwrap(readings, period=period))
        return counted_on, float(period), f"wrap after {2**bits} counts ({bits} bits): they are counted on"
    if abs(size / 360.0 - 1.0) < _LIKE:
        return np.asarray(np.unwrap(readings, period=360.0)), 0.0, "wrap after 360"
    return readings, 0.0, ""


def still_publisher(readings: Array) -> tuple[Mask, str]:
    """Return which samples (n, 2) come from a second publisher that never moves (n,), and in words that it is there."""
    none = np.zeros(len(readings), dtype=bool)
    if not len(readings):
        return none, ""
    values, place, counts = np.unique(readings @ [1.0, 1.0j], return_inverse=True, return_counts=True)
    most = int(np.argmax(counts))
    still = np.asarray(place == most)
    before = np.flatnonzero(still[1:] & ~still[:-1])
    is_rare = len(before) < _TURNS or counts[most] < _SHARE * len(readings)
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

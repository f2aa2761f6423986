# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What readings are before they are angles: repeated, wrapped at the limits of a counter, or of two publishers."""

from collections.abc import Sequence

import numpy as np

from cdp_ident.arrays import Array, Indices, Mask
from cdp_ident.errors import TrialError
from cdp_ident.model.effects.effect import JOINTS
from cdp_ident.trial.kinematics import SAME, encoder_step
from cdp_ident.trial.scales import too_slow

_FAST = 3.5
"""Steps of the encoder in a change of readings that is motion, in which none is repeated by rounding."""
_ROUNDED = 2.5
"""A sum or difference of rounded readings changes by less than so many of their last digits where it does not."""
_AT_RANDOM = 0.005
"""Readings repeat at random where more than this share of them does so more often than evenly read ones would."""
_FROZEN = 10.0
"""One reading is repeated less than so many times as often as others in motion; longer, a joint is at rest."""
_BY_CHANCE = 1.2
"""Two encoders may turn by as many steps, or a spike be taken for rounding: less often than this, what is computed of
both repeats by chance."""
_FEWEST = 20
_SLOW = 0.25
"""Motion below this share of its mean speed is not in the midst of it."""
_STANDS = 4
"""So many times as many equal readings as usual in the midst of motion are those of a sensor that stands still."""
_ABRUPT = 3.0
"""Motion that stops or begins at once changes by less than one part in so many in the moment beside that."""
_CATCHES_UP = 2.0
"""A rod's first move from rest is no more than this times the next one."""
_REPEATED, _STEPS = 1.05, 100.0
"""Mean numbers of equal readings in fast motion between which they are repetitions; beyond, they are no angle's."""
_LONGEST_LINE, _STRAIGHT, _MOVING = 20, 0.05, 0.2
"""Readings of a line between two at most, and how much less it bends, in which share of the greatest speed."""
_ALIKE = 1.05
"""Joints of which one repeats no more often than the other by this factor are read together."""
_JUMP = 0.5
"""A change by more than this share of all that the readings go through is not motion."""
_STAYS = 3
"""A jump there and back within so many samples is that of a spike."""
_LIKE = 0.02
"""Share by which a wrap may seem to differ from a power of two of the encoder's steps, or from a turn."""
_FEWEST_WRAPS = 5
"""So many of the same size are wraps whatever it is."""
_COUNTED = 16
"""Of so many bits at most, the digits of readings tell a counter's range better than its jumps do."""
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
_OFTEN = 0.15
"""Share of the samples that do so where there is another motion; spikes are fewer."""
_NEXT = 4
_RELAYED = 100
"""So many samples later at most a second publisher says the same."""


def new_readings(readings: Array, known: Mask, turns: Array) -> tuple[Mask, list[str]]:
    """Return which of the `known` readings of joints (n, k) are measured anew (n, k), and of each in words why not all.

    An encoder that is read less often than it is published, or a film's repeated frame, gives the same reading again
    in the midst of fast motion; who makes one rate of several puts straight lines between. At rest, where readings are
    the same anyway, as many are kept as in motion. Joints that are read together are new together. Readings change by
    `turns` (k,) in a full turn.
    """
    known, together, still = known.copy(), bool(np.all(known == known[:, :1])), []
    for column, has in zip(readings.T, known.T, strict=True):
        stands = _stands(column[has])
        has[has] = ~stands
        times = np.count_nonzero(np.diff(stands, prepend=False) & stands)
        words = f"stand still {times} times in the midst of motion (a sensor that freezes, or is at its limit?): "
        still.append(f"{words}{np.count_nonzero(stands)} of them are left out" if times else "")
    if together:
        known[:] = np.all(known, axis=1, keepdims=True)
    columns = [column[has] for column, has in zip(readings.T, known.T, strict=True)]
    said = [""] * len(columns)
    changed = [np.flatnonzero(np.diff(column)) + 1 for column in columns]
    often = [_repeats(column, changes) for column, changes in zip(columns, changed, strict=True)]
    if together and max(often) == 1.0 and (found := _of_two_encoders(columns, turns)):
        columns[-1], said[-1] = found
        changed[-1] = np.flatnonzero(np.diff(columns[-1])) + 1
        often[-1] = _repeats(columns[-1], changed[-1])
    fast = [_in_motion(column, changes) for column, changes in zip(columns, changed, strict=True)]
    at_once = together and max(often) < _ALIKE * min(often) and _at_once(changed, fast, max(often))
    if at_once:
        changed = [np.unique(np.concatenate(changed))] * len(changed)
        fast = [_in_motion(column, changes) for column, changes in zip(columns, changed, strict=True)]
        fast = [np.any(fast, axis=0)] * len(fast)
    notes = []
    for has, column, changes, moves, times, whose in zip(known.T, columns, changed, fast, often, said, strict=True):
        if times > 1.0:
            kept = _spread(len(column), changes, moves, times)
            has[has] = kept
            left_out = np.count_nonzero(~kept)
            notes.append(f"{whose}repeat {times:.2g} times in motion: {left_out} repetitions are left out")
        else:
            every, first = _made_up(column)
            has[has] = np.arange(len(column)) % every == first
            lines = f"lie on straight lines between one in {every}: the others are no measurements, and left out"
            notes.append(lines if every > 1 else "")
    return known, ["; ".join(filter(None, both)) for both in zip(still, notes, strict=True)]


def _stands(readings: Array) -> Mask:
    """Return which readings (n,) are the one before over again as a sensor stands still, or is at its limit, in motion.

    Motion stops there from one moment to the next, goes on so, or catches up: two of these. A rod that stops, sticks or
    turns back slows down before, and gathers speed after it. Where readings repeat at random, none is told from these.
    """
    stands, moves = np.zeros(len(readings), dtype=bool), np.diff(readings)
    starts = np.flatnonzero(moves) + 1
    lengths, fast, step = np.diff(starts), _in_motion(readings, starts), encoder_step(readings)
    in_motion = lengths[fast[:-1] & fast[1:]]
    usual = float(np.median(in_motion)) if len(in_motion) >= _FEWEST else 1.0
    # A moment is so many readings that motion shows beside the encoder's steps.
    mean = max(float(np.mean(np.abs(moves))), SAME) if len(moves) else SAME
    moment = int(np.ceil(max(usual, 2.0 * _FAST * step / mean)))
    # Where a rod turns back, an encoder with play stands still, too, and catches up by little.
    least = max(_FAST * step, _SLOW * mean * moment)
    first, last = starts[:-1], starts[1:]
    tried = (lengths > usual) & (first >= 2 * moment) & (last < len(readings) - 2 * moment)
    first, last, lengths = first[tried], last[tried], lengths[tried]

    def is_abrupt(toward: int, at: Indices) -> Mask:
        near, far = readings[at + toward] - readings[at], readings[at + 2 * toward] - readings[at + toward]
        return np.asarray(np.abs(near) > np.maximum(least, _ABRUPT * np.abs(far - near)))

    jump, after = np.abs(readings[last] - readings[first]), np.abs(readings[last + moment] - readings[last])
    catches_up = jump > np.maximum(least, _CATCHES_UP * after)
    odd = np.sum([is_abrupt(-moment, first), catches_up, is_abrupt(moment, last)], axis=0) >= 2
    long = odd & (lengths >= _STANDS * moment)
    if np.count_nonzero(odd & ~long & (lengths >= 2 * moment)) <= max(np.count_nonzero(long), _AT_RANDOM * len(starts)):
        for begin, end in zip(first[long], last[long], strict=True):
            stands[begin + 1 : end] = True
    return stands


def _of_two_encoders(columns: Sequence[Array], turns: Array) -> tuple[Array, str] | None:
    """Return what of two joints' readings (n,) repeats, their sum or difference, and its name; None where neither does.

    An absolute angle may be computed of one encoder that is fresh and a relative one that is held, or the other way.
    """
    if len(columns) < len(JOINTS):
        return None
    inner, outer = (np.asarray(np.unwrap(column, period=turn)) for column, turn in zip(columns, turns, strict=True))
    # What is computed has rounding of its own, below a step of the encoder, or in the last digit that is written.
    digit = float(np.min(np.diff(np.unique(columns[0])), initial=np.inf))
    rounding = max(SAME, 0.5 * encoder_step(inner) or _ROUNDED * digit)
    for of_inner, name in ((-inner, "less the inner joint's "), (inner, "plus the inner joint's ")):
        steps = np.diff(outer + of_inner, prepend=0.0)
        combined = np.cumsum(np.where(np.abs(steps) > rounding, steps, 0.0))
        if _repeats(combined, np.flatnonzero(np.diff(combined)) + 1, rounding) > _BY_CHANCE:
            return combined, name
    return None


def _made_up(readings: Array) -> tuple[int, int]:
    """Return one in how many readings (n,) is measured where those between lie on straight lines, and the first one.

    Motion is bent between all measurements alike.
    """
    steps = np.abs(np.diff(readings))
    moving = steps[1:] > _MOVING * (np.quantile(steps, 0.99) if len(steps) else 0.0)
    if np.count_nonzero(moving) < _LONGEST_LINE * _FEWEST:
        return 1, 0
    bend = np.where(moving, np.abs(np.diff(readings, 2)), 0.0)
    lines = np.arange(_LONGEST_LINE, 1, -1)
    for every, usual in zip(lines.tolist(), np.quantile(bend[moving], 1.0 - 0.5 / lines), strict=True):
        # Jumps, as over gaps, bend no more than usual.
        bends = np.sum(np.minimum(bend[: len(bend) // every * every], usual).reshape(-1, every), axis=0)
        sharp = int(np.argmax(bends))
        if np.max(np.delete(bends, sharp)) < _STRAIGHT * bends[sharp]:
            return every, (sharp + 1) % every
    return 1, 0


def _repeats(readings: Array, changes: Indices, rounding: float = 0.0) -> float:
    """Return how often readings (n,), rounded to so much, repeat in fast motion on average; 1 where they do not."""
    fast = _in_motion(readings, changes, rounding)
    in_motion = np.diff(changes)[fast[:-1] & fast[1:]]
    if len(in_motion) < _FEWEST or not _REPEATED <= (mean := float(np.mean(in_motion))) < _STEPS:
        return 1.0
    return mean


def _at_once(changed: Sequence[Indices], fast: Sequence[Mask], often: float) -> bool:
    """Return whether fast changes of one joint are those of the other more often than by chance, one in so many."""
    if len(changed) < len(JOINTS):
        return True
    one, other = changed
    after = np.searchsorted(other, one)
    both = fast[0] & np.append(fast[1], False)[after]
    same = np.append(other, -1)[after][both] == one[both]
    return not len(same) or bool(np.mean(same) >= 0.5 + 0.5 / often)


def _in_motion(readings: Array, changes: Indices, rounding: float = 0.0) -> Mask:
    """Return which changes of readings (n,) are those of fast motion.

    Where readings are rounded, but not to a step of an encoder, as what is computed of whole pixels, those are by which
    half of the way is made.
    """
    sizes = np.abs(np.diff(readings)[changes - 1])
    least = _FAST * max(encoder_step(readings), rounding)
    if least == 0.0 and len(sizes):
        usual = np.sort(sizes[sizes <= _JUMP * np.ptp(readings)])
        least = usual[np.searchsorted(np.cumsum(usual), usual.sum() / 2)] if len(usual) else 0.0
    return np.asarray(sizes > least)


def _spread(count: int, changes: Indices, fast: Mask, times: float) -> Mask:
    """Return which of some readings that change at some of them are kept (count,): evenly one of so many.

    Where they repeat at random, it is the first of those that are the same between two `fast` changes.
    """
    starts = np.concatenate([[0], changes])
    lengths = np.diff(starts, append=count)
    new = np.maximum(1, np.round((lengths - 0.5) / times)).astype(np.int64)
    in_motion = np.append(False, fast) & np.append(fast, False) & (lengths < _FROZEN * times)
    # Twice as many are two readings that happen to be the same.
    odd = (lengths > np.ceil(times)) & (lengths != np.round(2.0 * times))
    if np.mean(odd[in_motion]) > _AT_RANDOM:
        new[in_motion] = 1
    number = np.arange(new.sum()) - np.repeat(np.cumsum(new) - new, new)
    kept = np.zeros(count, dtype=bool)
    kept[np.repeat(starts, new) + number * np.repeat(lengths, new) // np.repeat(new, new)] = True
    return kept


def continuous(readings: Array) -> tuple[Array, float, str]:
    """Return readings (n,) without the jumps of a counter of a few bits or of degrees, and in words what was found.

    The second value is the counter's range, 0 where there is none: from which of its ranges it began is not known.
    Readings that go on after a full turn of 2 pi are continued without a word.
    """
    steps = np.diff(readings)
    if len(steps) <= _STAYS:
        return readings, 0.0, ""
    sizes, jumps = [], []
    for at in np.flatnonzero(np.abs(steps) > _JUMP * np.ptp(readings)):
        near = steps[max(0, at - _STAYS) : at + 1 + _STAYS]
        if 0 < at < len(steps) - 1 and not np.any(np.abs(near + steps[at]) < _JUMP * abs(steps[at])):
            sizes.append(abs(steps[at] - 0.5 * (steps[at - 1] + steps[at + 1])))
            jumps.append(abs(steps[at]))
    if not sizes:
        return readings, 0.0, ""
    size = float(np.median(sizes))
    turns = size / (2.0 * np.pi)
    if round(turns) and abs(turns - round(turns)) < _LIKE:
        return np.asarray(np.unwrap(readings)), 0.0, ""
    if abs(size / 360.0 - 1.0) < _LIKE:
        return np.asarray(np.unwrap(readings, period=360.0)), 0.0, "wrap after 360"
    # In the order of readings, counts show also where motion is fast, and their gaps tell a count to the last digit.
    gaps = np.diff(np.sort(readings))
    if step := encoder_step(readings) or encoder_step(np.sort(readings)):
        near = gaps < _STEPS * step
        step = float(np.sum(gaps[near]) / np.sum(np.round(gaps[near] / step)))
    step = step or 1.0
    bits = round(np.log2(max(size / step, 1.0)))
    is_binary = bits >= 8 and abs(size / step / 2**bits - 1.0) < _LIKE
    if not is_binary and (len(sizes) < _FEWEST_WRAPS or np.ptp(sizes) > _LIKE * size):
        return readings, 0.0, ""
    if is_binary and bits <= _COUNTED:
        size = step * 2**bits
    # A whole number of steps from one reading to the next: so many billions of them would add up their rounding.
    period = jumps[0] + step * round((size - jumps[0]) / step)
    limit = f"{2**bits} counts ({bits} bits)" if is_binary else f"{period:.4g}"
    return np.asarray(np.unwrap(readings, period=period)), float(period), f"wrap after {limit}: they are counted on"


def still_publisher(readings: Array, stamps: Indices) -> tuple[Mask, str]:
    """Return which samples (n, 2) come from a second publisher that never moves (n,), and in words that it is there.

    Its samples are between the others' as they are stored, and as they are stamped (n,): else they were out of order.
    """
    none = np.zeros(len(readings), dtype=bool)
    if not len(readings):
        return none, ""
    values, place, counts = np.unique(readings @ [1.0, 1.0j], return_inverse=True, return_counts=True)
    most = int(np.argmax(counts))
    still = np.asarray(place == most)
    before = np.flatnonzero(still[1:] & ~still[:-1])
    stamped = still[np.argsort(stamps, kind="stable")]
    turns = min(len(before), np.count_nonzero(stamped[1:] & ~stamped[:-1]))
    if turns < _TURNS or counts[most] < _SHARE * len(readings) or counts[most] > _RUN * (turns + 1):
        return none, ""
    value = np.array([values[most].real, values[most].imag])
    if np.median(np.max(np.abs(readings[before] - value), axis=1)) < _FAR:
        return none, ""
    shown = " and ".join(f"{position:.4g}" for position in value)
    return still, (
        f"a second publisher that never moves says {shown} on the same topic: its {counts[most]} messages are left out"
    )


def said_again(readings: Array) -> tuple[Mask, str]:
    """Return which samples (n, 2), in the order of time, say what was measured a little before, and that in words.

    A second publisher or a relay says the same later, with stamps of its own. In the midst of motion, no two samples
    have the same readings of both joints unless they follow one another; what is often said stands for none, or rests.
    """
    again = np.zeros(len(readings), dtype=bool)
    if not len(readings):
        return again, ""
    _, which, counts = np.unique(readings @ [1.0, 1.0j], return_inverse=True, return_counts=True)
    order = np.argsort(which, kind="stable")
    before, after = order[:-1], order[1:]
    again[after[(which[before] == which[after]) & (after - before > 1) & (after - before <= _RELAYED)]] = True
    moves = np.abs(np.diff(readings, axis=0, prepend=readings[:1]))
    steps = np.array([encoder_step(column) for column in readings.T])
    fast = np.any(moves > _FAST * steps, axis=1) & (counts[which] <= _NEXT)
    if np.count_nonzero(fast) < _FEWEST or np.mean(again[fast]) < _OFTEN:
        return np.zeros_like(again), ""
    return again, (
        f"{np.count_nonzero(again)} samples say later what others said before (a second publisher, a relay?): left out"
    )


def check_publishers(readings: Array, time: Array, topic: str) -> None:
    """Raise TrialError where samples of a topic (n, 2) go to and fro between two motions.

    One motion may seem to do so where samples at `time` (n,) [s] are too far apart.
    """
    count = len(readings) - _NEXT
    if count < 3 * _NEXT or too_slow(time):
        return
    apart = [np.max(np.abs(readings[k:] - readings[:-k])[:count], axis=1) for k in range(1, _NEXT + 1)]
    # The next ones are those of the other motion, too, where it is heard more often.
    to_and_fro = apart[0] > np.maximum(_FAR, _NEARER * np.min(apart[1:], axis=0))
    if np.mean(to_and_fro) > _OFTEN:
        raise TrialError(
            f"samples on {topic} alternate between two motions (two publishers, two rigs?): record one of them, or "
            "give each a topic of its own"
        )

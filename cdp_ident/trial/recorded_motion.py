# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From samples as they came to the motion in them, before anything is known of what its angles mean."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import reduce

import numpy as np
from scipy import ndimage

from cdp_ident.arrays import Array, Mask
from cdp_ident.errors import TrialError
from cdp_ident.model.effects.effect import JOINTS
from cdp_ident.trial.balance import WINDOW, Motion, motion_on_grid, over_windows
from cdp_ident.trial.clock import measured_times
from cdp_ident.trial.joints import Piece, Samples, in_angles, model_angles
from cdp_ident.trial.kinematics import SAME, encoder_step
from cdp_ident.trial.options import TrialOptions
from cdp_ident.trial.order import elapsed
from cdp_ident.trial.outliers import TURN, outliers, steps
from cdp_ident.trial.scales import PER_UNIT, Scales, sampling_step

_FASTEST, _SAMPLED = 0.02, 0.5
"""Time scale of a rig of 4 mm [s], and the share of a recording in which samples follow one another as usual."""
_FEWEST_SAMPLES = 4
"""Samples in one unit of the motion's time scale below which its velocities cannot be estimated."""
_TOLD = 3
"""So many gaps, steps of readings, and steps back of the clock, are told with their places."""
_ANOTHER_ZERO = 1.0
"""Readings that step by more [rad] go on from another zero: no motion is followed over so many lost counts."""
_REST_WINDOW = 8 * PER_UNIT
_BURIED = 4.0
"""Motion of so many times the noise tells next to nothing beside the motion before it: minutes of it would be most of
the error that is to be lowered, and each window's initial state takes up what they tell."""
_CART_WINDOW = 5 * PER_UNIT // 2
_FAST = 0.4
"""Share of the typical speed at which the rods show what moves them."""
_TURNING = 0.15
"""Share of the typical speed at which a joint cannot be said to stick."""
_MOST_WINDOWS = 1 << 15
"""Of more, which show it well, only some are taken, for neighbours overlap."""
_FEWEST = 5 * PER_UNIT
"""Windows without a joint that sticks, below which the others are taken too."""


@dataclass(frozen=True)
class Recorded:
    """The motion in a recording, before anything is known of what its angles mean."""

    pieces: tuple[Piece, ...]
    """Those that are long enough."""
    motions: tuple[Motion, ...]
    """Of each piece, of the recorded joints, without steps of lost counts."""
    moving: tuple[Mask, ...]
    """Of each motion, the windows (as many as `balance.windows` returns) that show it well."""
    notes: tuple[str, ...] = ()
    """What was dropped and parted, in words."""
    outliers: tuple[float, ...] = ()
    """Times since the recording's first sample at which outliers were left out [s]."""

    @property
    def moving_parts(self) -> Iterator[tuple[Motion, Mask]]:
        """Parts of the motions, and their windows that show it well, of which each part has some."""
        motions = zip(self.motions, self.moving, strict=True)
        parts = (part for motion, moving in motions for part in motion.parted(moving))
        return ((part, moving) for part, moving in parts if np.any(moving))


def recorded_motion(samples: Samples, options: TrialOptions) -> Recorded:
    """Return the motion in samples. Raises TrialError where no piece of them is long enough."""
    samples = in_angles(samples, options)
    cleaned, outlying, notes = clean(samples, options.start, options.stop)
    if not len(cleaned.time):
        limits = {name: at for name in ("start", "stop") if np.isfinite(at := getattr(options, name))}
        asked = " and ".join(options.setting(name, f"{at} s") for name, at in limits.items())
        raise TrialError(f"no sample lies within {asked}: the recording has {clean(samples)[0].time[-1]:.2f} s")
    time = cleaned.time
    scales = Scales.of(time - time[0], model_angles(cleaned.samples.angles, options))
    step = sampling_step(time)
    if scales.unit < _FASTEST and step * len(time) < _SAMPLED * (time[-1] - time[0]):
        raise TrialError(
            f"half of the samples are less than {1e3 * step:.2g} ms after the one before, and nothing swings so fast: "
            "are they stamped in bursts?"
        )
    longest_gap, shortest = options.longest_gap or scales.longest_gap, options.shortest or scales.shortest
    pieces, gaps = cut_at_gaps(cleaned, outlying, longest_gap)
    notes += gaps
    pieces = [
        piece
        for piece in pieces
        if (lasts := np.ptp(piece.time)) >= shortest
        and len(piece.time) >= max(6.0, _FEWEST_SAMPLES * lasts / scales.unit)
    ]
    if not pieces:
        length = time[-1] - time[0]
        rules = f"at least {_FEWEST_SAMPLES / scales.unit:.0f} samples a second and no gap over {longest_gap:.3g} s"
        raise TrialError(
            f"{len(time)} samples over {length:.2f} s hold no stretch of {shortest:.3g} s with {rules}; "
            f"{'; '.join(notes) or 'the recording is too short'}"
        )
    for number, piece in enumerate(pieces):
        stepped = np.column_stack([steps(piece.time, angle) for angle in piece.samples.angles.T])
        zeroed = np.any(np.abs(stepped) > _ANOTHER_ZERO, axis=1, keepdims=True)
        counts = np.array([encoder_step(angle) or SAME for angle in piece.samples.angles.T])
        stepped = np.where(zeroed, counts * np.round(stepped / counts), stepped)
        for rows, words in ((~zeroed, "(lost counts?): kept"), (zeroed, "(another zero, a reset?): taken out")):
            for joint, step in zip(JOINTS, (stepped * rows).T, strict=True):
                places = np.flatnonzero(step)
                shown = [f"{step[at]:.3g} rad at {piece.time[at]:.3f} s" for at in places[:_TOLD]]
                more = " …" if len(places) > _TOLD else ""
                if shown:
                    notes.append(f"readings of the {joint} joint step by {', '.join(shown)}{more} {words}")
        angles = piece.samples.angles - np.cumsum(stepped * zeroed, axis=0)
        pieces[number] = replace(piece, samples=replace(piece.samples, angles=angles))
    recorded = Recorded(tuple(pieces), (), (), tuple(notes), tuple(outlying.tolist()))
    return on_grid(recorded, scales, options)


def on_grid(recorded: Recorded, scales: Scales, options: TrialOptions) -> Recorded:
    """Return a recording with the motion of its pieces at some scales."""
    motions: list[Motion] = []
    for time, of in ((piece.time, piece.samples) for piece in recorded.pieces):
        # What the angles mean and what acts on the rods is that of the motion, not of its readings.
        angles = of.angles - np.cumsum(np.column_stack([steps(time, angle) for angle in of.angles.T]), axis=0)
        motions.append(motion_on_grid(time, angles, of.cart, scales, of.torques))
    moving = moving_windows(motions, options)
    apart = 1 + sum(map(np.count_nonzero, moving)) // _MOST_WINDOWS
    thinned = tuple(mask & (np.arange(len(mask)) % apart == 0) for mask in moving)
    return replace(recorded, motions=tuple(motions), moving=thinned)


def clean(samples: Samples, start: float = 0.0, stop: float = np.inf) -> tuple[Piece, Array, list[str]]:
    """Take samples in the order of time from `start` to `stop` [s] after the first, without the outliers.

    Of several with one stamp the first is kept, unless they came in a burst (`measured_times`). An outlier of one joint
    makes the whole sample one: it is left out, as if its frame had been lost, before angles are unwrapped, as turns
    would be counted by it.

    Returns them, the times at which outliers were left out [s], and what was dropped, in words.
    """
    set_back = np.diff(samples.stamps) < 0
    angles = samples.angles * (TURN / np.array(samples.turns))
    parts = np.flatnonzero(set_back) + 1
    time, notes, pace_std = measured_times(elapsed(samples.stamps), angles, parts)
    first = np.concatenate([[True], (np.diff(time) > 0) | set_back])[: len(time)]
    if repeated := int(np.count_nonzero(~first)):
        notes.append(f"{repeated} samples with a stamp that was there already are dropped")
    taken = Piece(replace(samples, pace_std=max(samples.pace_std, pace_std)), time)[
        first & (time >= start) & (time <= stop)
    ]
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


def at_rest(motion: Motion, amplitude: float) -> Mask:
    """Return which grid points (m,) lie in a long time in which neither rod moves more than `amplitude` [rad rms].

    Nor does one move more than a few times the noise, where that is larger.
    """
    amplitude = max(amplitude, _BURIED * float(np.max(motion.angle_noise)))
    deviation = motion.angles - np.median(motion.angles, axis=0)
    width = min(_REST_WINDOW, len(deviation))
    mean = np.ones(width) / width
    inner, outer = (np.convolve(of**2, mean, "valid") - np.convolve(of, mean, "valid") ** 2 for of in deviation.T)
    return covered(np.maximum(inner, outer) <= amplitude**2, width)


def cart_driven(motion: Motion, limit: float) -> Mask:
    """Return near which grid points (m,) the cart moves further than `limit` [m] within 2.5 units of time."""
    travel = ndimage.maximum_filter1d(motion.cart, _CART_WINDOW) - ndimage.minimum_filter1d(motion.cart, _CART_WINDOW)
    return np.asarray(travel > limit)


def moving_windows(motions: Sequence[Motion], options: TrialOptions) -> tuple[Mask, ...]:
    """Return which windows of the balance show the motion well, of each of the motions in a recording.

    The rods are fast, for this recording, the cart is not driven, no samples are missing, and no joint sticks: while
    one does, meanings of the angles that contradict each other can all be right. Where that leaves next to nothing, a
    joint may stick, or samples be missing.
    """
    idle = [at_rest(of, options.rest_amplitude) | cart_driven(of, options.cart_limit) for of in motions]
    speeds = [np.linalg.norm(of.rates, axis=1) for of in motions]
    fast = np.concatenate(speeds)[~np.concatenate(idle)]
    typical = float(np.quantile(fast, 0.9)) if len(fast) else np.inf
    moving, lively = [], []
    for motion, rests, speed in zip(motions, idle, speeds, strict=True):
        (inner, outer), window = motion.rates.T, np.ones(WINDOW)
        # Whichever way the outer angle is meant, one of these is the speed of its joint.
        rates = (inner, outer, outer - inner, outer + inner)
        slowest = reduce(np.minimum, (over_windows(rate**2, window / WINDOW) for rate in rates))
        lively.append(slowest > (_TURNING * typical) ** 2)
        moving.append((over_windows(rests, window) < 0.5) & (speed[WINDOW // 2 :][: len(slowest)] >= _FAST * typical))
    whole = [mask & of.is_whole for mask, of in zip(moving, motions, strict=True)]
    for well in ([mask & of for mask, of in zip(whole, lively, strict=True)], whole):
        if sum(map(np.count_nonzero, well)) >= _FEWEST:
            return tuple(well)
    return tuple(moving)


def covered(flags: Mask, width: int) -> Mask:
    """Return which points lie in a flagged window, of windows of `width` points that start at each flag."""
    return np.asarray(np.convolve(flags, np.ones(width), mode="full") > 0.5)

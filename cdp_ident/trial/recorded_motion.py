# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From samples as they came to the motion in them, before anything is known of what its angles mean."""

from dataclasses import replace

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.errors import TrialError
from cdp_ident.trial.balance import motion_on_grid
from cdp_ident.trial.joints import Piece, Samples, in_angles, model_angles
from cdp_ident.trial.meaning import Recorded
from cdp_ident.trial.options import TrialOptions
from cdp_ident.trial.order import elapsed
from cdp_ident.trial.outliers import TURN, outliers
from cdp_ident.trial.sample_times import evened
from cdp_ident.trial.scales import Scales, sampling_step
from cdp_ident.trial.zero_input import moving_windows

_FASTEST, _SAMPLED = 0.02, 0.5
"""Time scale of a rig of 4 mm [s], and the share of a recording in which samples follow one another as usual."""
_FEWEST_SAMPLES = 4
"""Samples in one unit of the motion's time scale below which its velocities cannot be estimated."""
_TOLD = 3
"""So many gaps, and steps back of the clock, are told with their places."""


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
    measured = [(piece.time, piece.samples) for piece in pieces]
    motions = tuple(motion_on_grid(time, of.angles, of.cart, scales, of.torques) for time, of in measured)
    moving = tuple(moving_windows(motion, options) for motion in motions)
    return Recorded(tuple(pieces), motions, moving, tuple(notes), tuple(outlying.tolist()))


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

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The motion in a recording, before anything is known of what its angles mean."""

import numpy as np

from cdp_ident.errors import TrialError
from cdp_ident.trial.balance import motion_on_grid
from cdp_ident.trial.cleaning import Piece, clean, cut_at_gaps
from cdp_ident.trial.joints import Samples, in_angles, model_angles
from cdp_ident.trial.meaning import Recorded
from cdp_ident.trial.options import TrialOptions
from cdp_ident.trial.scales import Scales, sampling_step
from cdp_ident.trial.zero_input import moving_windows

_FASTEST, _SAMPLED = 0.02, 0.5
"""Time scale of a rig of 4 mm [s], and the share of a recording in which samples follow one another as usual."""
_FEWEST_SAMPLES = 4
"""Samples in one unit of the motion's time scale below which its velocities cannot be estimated."""


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
    pieces = [piece for piece in pieces if _is_long_enough(piece, shortest, scales)]
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


def _is_long_enough(piece: Piece, shortest: float, scales: Scales) -> bool:
    duration = piece.time[-1] - piece.time[0]
    enough = max(6.0, _FEWEST_SAMPLES * duration / scales.unit)
    return bool(duration >= shortest and len(piece.time) >= enough)

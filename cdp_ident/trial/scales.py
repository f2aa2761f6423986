# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The scales of a rig's motion, from the motion itself: nothing about the rig needs to be known.

A double pendulum of 5 cm swings six times as fast as one of 2 m, so nothing that looks at its motion can be so many
seconds long. What follows is in units of the motion's own characteristic time, bounded below by what the sampling can
resolve.
"""

from dataclasses import dataclass

import numpy as np

from cdp_ident.arrays import Array

PER_UNIT = 20
"""Points of the grid on which motion is looked at, in one unit of its time scale."""
_PER_MEDIAN_FREQUENCY = 1.25
"""sqrt(L / g) times the median frequency [rad/s] of the speed, for wide swings; a half more for small ones."""
_SEGMENT = 4096
_NOISE_BAND = 0.75
"""From this share of the highest frequency on, a spectrum shows the noise alone."""
_ABOVE_NOISE = 20.0
"""A frequency shows motion where its power is so many times that of the noise."""
_BRIDGED = 30.0
"""Usual steps that a longer one counts for at most."""
_FEWEST_STEPS = 12
"""Sampling steps in the shortest time that is resolved."""
_FEWEST_UNITS = 8
"""Units of time in a recording: a slower motion shows nothing in it."""
_MOST_POINTS = 1_000_000
"""Grid points that a recording may take."""
_FEWEST = 16
_SLOWEST = 0.1
"""Samples so far apart [s] show no swing of a rig's two rods: at 7 Hz and less, 36 of 36 recordings were refused."""
_NO_MOTION = 0.2
"""Time scale [s] of a recording in which nothing moves: that of a rig of 0.4 m."""


def time_scale(time: Array, angles: Array) -> float:
    """Return the characteristic time of a recorded motion [s], which is near sqrt(L / g) for a swinging pendulum.

    It follows from the median frequency of the speed's power: the one below which half of it lies. Fast swings count
    more than a slow hand, and rest does not count at all. Noise, whose power is taken from the highest frequencies,
    is left out; sine and cosine stand for the angles (n, k) [rad], so that a rod that turns over and wrapped ones do no
    harm. Between samples at `time` (n,) [s] that are further apart than usual they go on evenly, and over long gaps
    for no longer than `_BRIDGED` steps.

    The spectrum is the mean over segments that overlap by half, each less its mean and under Hann's window (Welch, IEEE
    Trans. Audio Electroacoust. 15, 1967): to load `scipy.signal` for it takes longer than all else of scipy.
    """
    spacing = sampling_step(time)
    if len(time) < _FEWEST or spacing <= 0:
        return _NO_MOTION
    steps = np.diff(time, prepend=time[0])
    closed = np.cumsum(np.clip(steps, 0.0, _BRIDGED * spacing))
    even = np.arange(0.0, closed[-1], spacing)
    signals = np.column_stack([np.interp(even, closed, of) for of in (*np.sin(angles).T, *np.cos(angles).T)])
    segment = min(len(even), _SEGMENT)
    hann = 0.5 - 0.5 * np.cos(2.0 * np.pi / segment * np.arange(segment))
    parts = np.lib.stride_tricks.sliding_window_view(signals, segment, axis=0)[:: segment - segment // 2]
    power = np.zeros(segment // 2 + 1)
    for part in parts:  # all at once take several times the memory of the signals
        power += np.sum(np.abs(np.fft.rfft((part - part.mean(axis=-1, keepdims=True)) * hann)) ** 2, axis=0)
    frequency = np.fft.rfftfreq(segment, spacing)
    noise = np.median(power[int(_NOISE_BAND * len(power)) :])
    of_speed = np.cumsum(np.where(power > _ABOVE_NOISE * noise, frequency**2 * (power - noise), 0.0))
    median = 2 * np.pi * frequency[np.argmax(of_speed >= of_speed.max() / 2)]
    return _PER_MEDIAN_FREQUENCY / float(median) if median > 0 else _NO_MOTION


def sampling_step(time: Array) -> float:
    """Return the usual time between samples at `time` (n,) [s]; 0 where there is none."""
    steps = np.diff(time)
    steps = steps[steps > 0]
    return float(np.median(steps)) if len(steps) else 0.0


def too_slow(time: Array) -> str:
    """Return that samples at `time` (n,) [s] are too far apart to show how rods swing, in words; empty if not."""
    if (step := sampling_step(time)) < _SLOWEST:
        return ""
    return (
        f"samples are {step:.2g} s apart ({1.0 / step:.2g} Hz), which is too slow to follow two rods: those of 0.4 m "
        "need 20 Hz, shorter ones more"
    )


@dataclass(frozen=True)
class Scales:
    """How long, how far apart and how slow things are when a recording is looked at."""

    unit: float
    """The motion's time scale, or what the sampling resolves if that is longer [s]."""

    @classmethod
    def of(cls, time: Array, angles: Array) -> "Scales":
        """Return the scales of samples at `time` (n,) [s] of `angles` (n, k) [rad]."""
        step = sampling_step(time)
        duration = step * len(time)
        return cls.at_least(min(time_scale(time, angles), duration / _FEWEST_UNITS), time)

    @classmethod
    def at_least(cls, unit: float, time: Array) -> "Scales":
        """Return the scales of a time scale [s], or of what samples at `time` (n,) [s] resolve if that is longer."""
        step = sampling_step(time)
        return cls(max(unit, _FEWEST_STEPS * step, PER_UNIT * step * len(time) / _MOST_POINTS) or _NO_MOTION)

    @property
    def half_width(self) -> float:
        """Samples this near are smoothed together [s]; what a cubic misses of a swing over them is some thousandths."""
        return self.unit / 4

    @property
    def spacing(self) -> float:
        """Time between grid points [s]."""
        return self.unit / PER_UNIT

    @property
    def longest_gap(self) -> float:
        """A longer gap could hide a turn [s]."""
        return self.unit / 2

    @property
    def shortest(self) -> float:
        """Shorter motion shows less than a swing [s]."""
        return 5 * self.unit

    @property
    def slow(self) -> float:
        """A joint this slow may be held by its dry friction [rad/s]."""
        return 0.03 / self.unit

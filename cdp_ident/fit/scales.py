# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The scales of a rig: every time and speed that the identification needs, from the rig and its data.

Lengths and gravity make the unit of time, sqrt(L / g). Everything that was chosen for the paper's rig (L = 0.4 m) is a
multiple of it here, and is shorter where the measured motion is faster.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.noise import encoder_steps
from cdp_ident.fit.windows import DEFAULT_WINDOW, FEWEST_SAMPLES
from cdp_ident.model.parameters import NOMINAL, time_unit
from cdp_ident.model.time_grid import DEFAULT_STEP
from cdp_ident.trial.balance import Motion, motion_on_grid
from cdp_ident.trial.scales import Scales as TrialScales
from cdp_ident.trial.trial import Trial

_PAPER_S = time_unit(NOMINAL["L"], NOMINAL["g"])
"""Time unit of the paper's rig [s]: its step of the integrator and windows of two small swings are so many units."""
PACE = 2.5
"""Pace of the paper's motion (Table 3), times the time unit, rounded up: its rods go through the full circle. For a
faster motion, steps are shorter by the same factor, since the error of a Runge-Kutta method depends on step times
pace."""
SAMPLES_PER_UNIT = 40.0
"""Samples a time unit that a motion of the paper's pace needs; measured in benchmarks/scales.py: with fewer, fitted
values scatter more than with all of them. So many leave less than 0.1 microradian of error (`fit/thinning.py`)."""
ENOUGH = 400.0
"""Motion in which effects are looked for, where there is more, and of each trial its pace, in time units: 81 s on the
paper's rig. Benchmarks and examples of a minute are below it; of an hour it shows effects down to some seven times what
the hour shows."""
_LIVELY = 0.99
"""Quantile of speeds and accelerations that is their pace: the largest of a spline may be its error."""


@dataclass(frozen=True)
class Scales:
    """Times and speeds that suit a rig and its data."""

    time_unit: float
    """sqrt(L / g) [s]."""
    step: float
    """Of the integrator [s]."""
    window: float
    """Length of the windows over which predictions are judged [s]."""
    together: int
    """How many samples are averaged into one."""
    encoder_steps: Array
    """(2,) step of the inner and the outer encoder, 0 where none shows [rad]."""

    @property
    def enough(self) -> float:
        """Motion in which effects are looked for, where there is more [s]."""
        return ENOUGH * self.time_unit

    @property
    def half_swing(self) -> float:
        """Half a small swing of a pendulum of length L [s]."""
        return np.pi * self.time_unit


def scales_of(trials: Sequence[Trial], length: float, gravity: float) -> Scales:
    """Choose the scales for trials.

    Args:
        trials: what was measured.
        length: L [m].
        gravity: g [m/s^2].

    Raises:
        IdentificationError: no trial has enough samples.
    """
    unit, fewest = time_unit(length, gravity), 2 * FEWEST_SAMPLES
    usable = [trial for trial in trials if len(trial.time) >= fewest and trial.duration > unit]
    if not usable:
        raise IdentificationError(
            f"no trial has {fewest} samples and lasts {unit:.2f} s, the time unit of a rig with L = {length:g} m"
        )
    faster = max(1.0, max(_pace_of(_liveliest(trial, unit)) for trial in usable) * unit / PACE)
    longer = unit / (_PAPER_S * faster)
    spacing = float(np.median(np.concatenate([np.diff(trial.time) for trial in usable])))
    return Scales(
        time_unit=unit,
        step=DEFAULT_STEP * longer,
        window=max(DEFAULT_WINDOW * longer, FEWEST_SAMPLES * spacing),
        together=max(1, int(unit / (faster * SAMPLES_PER_UNIT * spacing))),
        encoder_steps=np.max([encoder_steps(trial) for trial in trials], axis=0),
    )


def _liveliest(trial: Trial, unit: float) -> Motion:
    """Return the motion of the stretch of a trial in which it is fastest, as far as it was recorded."""
    time, theta = trial.time, trial.theta
    if trial.duration > ENOUGH * unit:
        moved = np.concatenate([[0.0], np.cumsum(np.sum(np.diff(theta, axis=0) ** 2, axis=1))])
        last = np.minimum(np.searchsorted(time, time + ENOUGH * unit), len(time) - 1)
        first = int(np.argmax(moved[last] - moved))
        part = slice(first, int(last[first]) + 1)
        time, theta = time[part], theta[part]
    motion = motion_on_grid(time, theta, None, TrialScales.at_least(unit, time))
    before = np.clip(np.searchsorted(time, motion.time, side="right") - 1, 0, len(time) - 2)
    known = np.diff(time)[before] <= motion.scales.half_width
    return replace(motion, time=motion.time[known], angles=motion.angles[known], rates=motion.rates[known])


def _pace_of(motion: Motion) -> float:
    """Return the pace of a motion: the larger of its speed and the root of its acceleration [1/s]."""
    speeds = np.abs(motion.rates)
    accelerations = np.abs(np.gradient(motion.rates, motion.scales.spacing, axis=0))
    return float(max(np.quantile(speeds, _LIVELY), np.sqrt(np.quantile(accelerations, _LIVELY))))

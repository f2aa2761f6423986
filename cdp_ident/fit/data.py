# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Trials cut into windows, each with its role."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.noise import noise_of, rounding_of_averages
from cdp_ident.fit.roles import PartedTrial
from cdp_ident.fit.scales import Scales
from cdp_ident.fit.windows import FEWEST_SAMPLES, Window, cut_at, evenly
from cdp_ident.trial.trial import Trial

_FEWEST_WINDOWS = 4


@dataclass(frozen=True)
class Data:
    """Trials cut into windows."""

    trials: tuple[Trial, ...]
    """Those to fit, then those that are held out as a whole, with breaks where their roles change, and averaged."""
    measured: tuple[Trial, ...]
    """The same as they were measured."""
    fit: tuple[Window, ...]
    """What is fitted."""
    holdout: tuple[Window, ...]
    """Used by neither the fit nor the choice of effects."""
    noise: Array
    """(2,) standard deviation of the noise of theta1 and theta2 over all trials to fit [rad]."""
    window: float
    """Length of a window, in the median [s]."""
    scales: Scales
    """Times and speeds that suit the rig."""

    @property
    def noise_level(self) -> float:
        """Root mean square of both angles' noise [rad]."""
        return float(np.sqrt(np.mean(self.noise**2)))

    def over_shorter_windows(self, longest: float) -> "Data":
        """Return the same in windows that are no longer than so much [s]."""

        def pieces(window: Window) -> list[Window]:
            samples = len(window.theta)
            count = max(1, min(math.ceil(window.duration / longest), samples // FEWEST_SAMPLES))
            bounds = [window.first + samples * part // count for part in range(count + 1)]
            return cut_at(self.trials[window.trial], window.trial, bounds, self.scales.step)

        fit, holdout = (tuple(piece for window in of for piece in pieces(window)) for of in (self.fit, self.holdout))
        return replace(self, fit=fit, holdout=holdout, window=_typical((*fit, *holdout)))

    @property
    def names(self) -> list[str]:
        """Names of the trials."""
        return [trial.name for trial in self.trials]


def noise_over(trials: Sequence[Trial]) -> Array:
    """Return the standard deviation (2,) of the noise of theta1 and theta2 over trials [rad]."""
    return _mean([noise_of(trial) for trial in trials])


def noise_over_averages(trials: Sequence[Trial], thinned: Sequence[Trial], together: int) -> Array:
    """Return the same (2,) over trials in which so many samples are averaged into one [rad].

    Args:
        trials: as they were measured.
        thinned: the same, averaged: these do not show the encoders' steps.
        together: how many samples.
    """
    return _mean(
        [
            np.maximum(noise_of(average), rounding_of_averages(trial, together))
            for trial, average in zip(trials, thinned, strict=True)
        ]
    )


def _mean(deviations: Sequence[Array]) -> Array:
    """Return the root mean square (2,) of standard deviations (2,)."""
    return np.asarray(np.sqrt(np.mean(np.square(deviations), axis=0)))


def prepare(parted: Sequence[PartedTrial], window: float, scales: Scales, noise: Array) -> Data:
    """Cut trials into windows, and give each its role.

    Args:
        parted: the trials, with what is held out of them.
        window: length of windows [s]; they are shorter where there would be too few otherwise.
        scales: of the rig.
        noise: (2,) of theta1 and theta2 over the trials to fit [rad].

    Raises:
        IdentificationError: the trials are too short.
    """
    total = sum(_duration(trial.shown) for trial in parted if trial.is_fitted)
    fit: list[Window] = []
    holdout: list[Window] = []
    for index, trial in enumerate(parted):
        for stretch, (first, last) in enumerate(trial.trial.bounds):
            bounds = evenly(trial.trial, first, last, min(total / _FEWEST_WINDOWS, window))
            windows = cut_at(trial.trial, index, bounds, scales.step)
            (holdout if stretch in trial.held_out else fit).extend(windows)
    if len(fit) < 2 or not holdout:
        raise IdentificationError("the trials have too few samples to fit and to evaluate the fit: record longer ones")
    trials, measured = (tuple(of) for of in zip(*((part.trial, part.measured) for part in parted), strict=True))
    return Data(trials, measured, tuple(fit), tuple(holdout), noise, _typical((*fit, *holdout)), scales)


def _typical(windows: Sequence[Window]) -> float:
    """Return the length of a window, in the median [s]."""
    return float(np.median([window.duration for window in windows]))


def _duration(trial: Trial) -> float:
    return float(sum(trial.time[last - 1] - trial.time[first] for first, last in trial.bounds))

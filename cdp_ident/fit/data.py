"""Which windows of the trials are fitted, and which are kept out of the fit to evaluate it by."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.noise import noise_of
from cdp_ident.fit.scales import Scales
from cdp_ident.fit.window_lengths import Lengths, window_bounds
from cdp_ident.fit.windows import Window, cut_at
from cdp_ident.trial.trial import Trial

Array = npt.NDArray[np.float64]

_EVERY = 4
"""Without trials to evaluate by, every fourth window is kept out of the fit."""
FIRST_KEPT_OUT, FALLBACK_FIRST = 2, 1
"""Index of the first window that is kept out; fallback if one of those is an outlier."""
_FEWEST_WINDOWS = 4


@dataclass(frozen=True)
class Data:
    """Trials cut into the windows that are fitted and those that are only judged by."""

    trials: tuple[Trial, ...]
    """The trials to fit, then those to judge by."""
    held_out: int
    """How many trials, at the end, are only judged by; 0 where windows of the others are kept out instead."""
    fit: tuple[Window, ...]
    holdout: tuple[Window, ...]
    noise: Array
    """(2,) standard deviation of the noise of theta1 and theta2 over all trials to fit [rad]."""
    window: float
    """Length of a window, in the median [s]."""
    scales: Scales
    """Times and speeds that suit the rig."""

    @property
    def names(self) -> list[str]:
        """Names of the trials."""
        return [trial.name for trial in self.trials]


def noise_over(trials: Sequence[Trial]) -> Array:
    """Return the standard deviation (2,) of the noise of theta1 and theta2 over trials [rad]."""
    return np.asarray(np.sqrt(np.mean([noise_of(trial) ** 2 for trial in trials], axis=0)))


def prepare(
    fit: Sequence[Trial],
    holdout: Sequence[Trial],
    lengths: Sequence[Lengths],
    scales: Scales,
    first: int = FIRST_KEPT_OUT,
) -> Data:
    """Cut trials into windows, and decide which are kept out of the fit where no trial is.

    Args:
        fit: trials to fit.
        holdout: trials to judge by; if there is none, every fourth window of the others is kept out of the fit.
        lengths: of the windows of each trial, those to fit first; shorter where there would be too few otherwise.
        scales: of the rig.
        first: index of the first window that is kept out.

    Raises:
        IdentificationError: the trials are too short.
    """
    if not fit:
        raise IdentificationError("there is no trial to fit: give at least one bag")
    trials = (*fit, *holdout)
    total, least = sum(trial.duration for trial in fit), _FEWEST_WINDOWS * scales.shortest_piece
    if not holdout and total < least:
        raise IdentificationError(
            f"the trials hold {total:.2g} s of motion; with this rig's L and sampling at least {least:.2g} s are needed"
        )
    longest = np.inf if holdout else total / _FEWEST_WINDOWS
    windows = [
        window
        for index, (trial, length_at) in enumerate(zip(trials, lengths, strict=True))
        for bounds in window_bounds(trial, length_at, longest)
        for window in cut_at(trial, index, bounds, scales.step, scales.half_width)
    ]
    if holdout:
        fitted = [w for w in windows if w.trial < len(fit)]
        kept_out = [w for w in windows if w.trial >= len(fit)]
    else:
        fitted = [w for index, w in enumerate(windows) if index % _EVERY != first]
        kept_out = windows[first::_EVERY]
    if not fitted or not kept_out:
        raise IdentificationError("the trials have too few samples to fit and to judge by: record longer ones")
    typical = float(np.median([window.duration for window in windows]))
    return Data(trials, len(holdout), tuple(fitted), tuple(kept_out), noise_over(fit), typical, scales)

"""Which windows of the trials are fitted, and which are kept out of the fit to evaluate it by."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.noise import noise_of
from cdp_ident.fit.windows import SHORTEST_WINDOW, Window, cut_into_windows
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

    @property
    def names(self) -> list[str]:
        """Names of the trials."""
        return [trial.name for trial in self.trials]


def prepare(fit: Sequence[Trial], holdout: Sequence[Trial], window: float, first: int = FIRST_KEPT_OUT) -> Data:
    """Cut trials into windows, and decide which are kept out of the fit where no trial is.

    Args:
        fit: trials to fit.
        holdout: trials to judge by; if there is none, every fourth window of the others is kept out of the fit.
        window: length of a window [s]; shorter where the trials would give too few otherwise.
        first: index of the first window that is kept out.

    Raises:
        IdentificationError: the trials are too short.
    """
    if not fit:
        raise IdentificationError("there is no trial to fit: give at least one bag")
    trials = (*fit, *holdout)
    if not holdout:
        window = min(window, sum(trial.duration for trial in fit) / _FEWEST_WINDOWS)
    if window < SHORTEST_WINDOW:
        total = sum(trial.duration for trial in fit)
        raise IdentificationError(
            f"the trials hold {total:.1f} s of motion; at least {_FEWEST_WINDOWS * SHORTEST_WINDOW:.0f} s are needed"
        )
    windows = cut_into_windows(trials, window)
    if holdout:
        fitted = [w for w in windows if w.trial < len(fit)]
        kept_out = [w for w in windows if w.trial >= len(fit)]
    else:
        fitted = [w for index, w in enumerate(windows) if index % _EVERY != first]
        kept_out = windows[first::_EVERY]
    if not fitted or not kept_out:
        raise IdentificationError("the trials have too few samples to fit and to judge by: record longer ones")
    noise = np.sqrt(np.mean([noise_of(trial) ** 2 for trial in fit], axis=0))
    return Data(trials, len(holdout), tuple(fitted), tuple(kept_out), noise)

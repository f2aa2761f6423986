"""Windows that fit far worse than the rest: an event, such as an impulse, affects one of them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.fit.refinement import Fit
from cdp_ident.fit.windows import Window

Array = npt.NDArray[np.float64]

_FEWEST_WINDOWS = 3
"""With fewer, none can be called an outlier."""


@dataclass(frozen=True)
class OutlierWindow:
    """A window that fits far worse than the rest."""

    window: Window
    error: float
    """Root mean square residual of the window: in units of the noise where that was given, else [rad]."""
    usual: float
    """Median of all windows' errors, in the same unit."""

    @property
    def ratio(self) -> float:
        """How many times worse than usual it fits."""
        return self.error / self.usual


def outlier_windows(fits: Sequence[Fit], least: float, noise: Array | None = None) -> list[OutlierWindow]:
    """Return the windows that fit far worse than the rest, the worst first.

    Args:
        fits: what is compared, such as the windows that were fitted and those held out.
        least: how many times the usual error an outlier's is.
        noise: (2,) standard deviation of the noise of theta1 and theta2 [rad]; where given, errors are relative to
            it, and an outlier's is so many times that, too.
    """
    scale = np.ones(2) if noise is None else noise
    windows = [window for fit in fits for window in fit.windows]
    angle_errors = [error for fit in fits for error in fit.errors]
    errors = np.array([np.sqrt(np.mean((error / scale) ** 2)) for error in angle_errors])
    if len(errors) < _FEWEST_WINDOWS:
        return []
    usual = float(np.median(errors))
    limit = least * (usual if noise is None else max(usual, 1.0))
    found = [index for index in np.argsort(-errors, kind="stable") if errors[index] >= limit and errors[index] > 0.0]
    return [OutlierWindow(windows[index], float(errors[index]), usual) for index in found]


def explains_an_outlier(before: Fit, after: Fit, outstanding: float, like_others: float) -> bool:
    """Return whether `after` explains an outlier window, so that its error is like the others'.

    Args:
        before: the fit in which the window is an outlier.
        after: another fit to the same windows.
        outstanding: by how many standard deviations of the others' an outlier's mean squared error is above theirs.
        like_others: how many times theirs it is at most, once it is explained.
    """
    powers = np.array([[np.mean(b**2), np.mean(a**2)] for b, a in zip(before.residuals, after.residuals, strict=True)])
    window = int(np.argmax(powers[:, 0] - powers[:, 1]))
    others = np.delete(powers[:, 1], window) if len(powers) > 1 else powers[:, 1]
    usual = np.median(others)
    # The mean square of n independent residuals varies by the root of 2 / n, relatively; that of unexplained errors, by
    # as much as is observed.
    by_chance = np.sqrt(2.0 * after.autocorrelation.integrated_time / before.residuals[window].size)
    spread = max(by_chance, np.std(others) / usual)
    return bool(powers[window, 0] > (1.0 + outstanding * spread) * usual and powers[window, 1] < like_others * usual)

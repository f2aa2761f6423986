"""Windows that fit far worse than the rest: an event, such as an impulse, affects one of them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cdp_ident.fit.initial_states import Fit
from cdp_ident.fit.windows import Window

_FEWEST_WINDOWS = 3
"""With fewer, none can be called an outlier."""


@dataclass(frozen=True)
class OutlierWindow:
    """A window that fits far worse than the rest."""

    window: Window
    error: float
    """Root mean square residual of the window [rad]."""
    usual: float
    """Median of all windows' errors [rad]."""

    @property
    def ratio(self) -> float:
        """How many times worse than usual it fits."""
        return self.error / self.usual


def outlier_windows(fits: Sequence[Fit], least: float) -> list[OutlierWindow]:
    """Return the windows that fit far worse than the rest, the worst first.

    Args:
        fits: what is compared, such as the windows that were fitted and those held out.
        least: how many times the usual error an outlier's is.
    """
    windows = [window for fit in fits for window in fit.windows]
    angle_errors = [error for fit in fits for error in fit.errors]
    errors = np.array([np.sqrt(np.mean(error**2)) for error in angle_errors])
    if len(errors) < _FEWEST_WINDOWS:
        return []
    usual = float(np.median(errors))
    found = [
        index for index in np.argsort(-errors, kind="stable") if errors[index] >= least * usual and errors[index] > 0.0
    ]
    return [OutlierWindow(windows[index], float(errors[index]), usual) for index in found]

"""Windows whose initial states went astray, fitted again from their own samples.

Where a joint sticks, the motion depends on its initial state by jumps: a rod that is let go rests where it is, or
slides to another place and rests there. Least squares follow derivatives and do not find across such a jump: a rod that
hangs still may end up modelled as one that is thrown and comes back.
"""

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.refinement import Fit, fit_initial_states
from cdp_ident.fit.windows import Window
from cdp_ident.trial.kinematics import local_motion

Array = npt.NDArray[np.float64]

_ASTRAY = 1.5
"""A window is looked at whose error is so many times the median of all windows' …"""
_BETTER = 0.8
"""… and has a better initial state if that leaves at most this share of its squared error."""


def with_starts_found_again(fit: Fit) -> Fit:
    """Return a fit of initial states whose windows all have the best of some; the same, where they have already.

    Those whose error is far above the other windows' are fitted again, from their own samples and from rest.
    """
    errors = [float(np.sum(r**2)) / w.independent for r, w in zip(fit.residuals, fit.windows, strict=True)]
    far = [k for k, error in enumerate(errors) if error > _ASTRAY**2 * np.median(errors)]
    windows = list(fit.windows)
    for index in far:
        found = [_fitted(fit, replace(fit.windows[index], start=start)) for start in _others(fit, index)]
        best = min((other for other in found if other), key=lambda other: other.squared_error, default=None)
        if best and best.squared_error < _BETTER * float(np.sum(fit.residuals[index] ** 2)):
            windows[index] = best.windows[0]
    if all(new is old for new, old in zip(windows, fit.windows, strict=True)):
        return fit
    again = fit_initial_states(fit.model, fit.values, windows)
    return again if again.squared_error < fit.squared_error else fit


def _others(fit: Fit, index: int) -> list[Array]:
    """Return other initial states (states,): as the first samples show it, and at rest where the rods mostly are."""
    window = fit.windows[index]
    if window.start_known:
        return []
    own = fit.model.initial_state(window.start)
    shown = window.theta - fit.errors[index]
    off = shown[0] - own[:2]
    angles, speeds = local_motion(window.time, window.theta, np.zeros(1), window.half_width)
    seen, at_rest = own.copy(), own.copy()
    seen[:2], seen[2:4] = angles[0] - off, speeds[0]
    at_rest[:2], at_rest[2:4] = np.median(window.theta, axis=0) - off, 0.0
    return [seen, at_rest]


def _fitted(fit: Fit, window: Window) -> Fit | None:
    try:
        return fit_initial_states(fit.model, fit.values, [window])
    except IdentificationError:
        return None

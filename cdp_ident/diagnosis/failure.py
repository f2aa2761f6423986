"""Whether a fit failed: whether the best simulated motion differs from the measured one altogether."""

from collections.abc import Sequence

import numpy as np

from cdp_ident.errors import FitFailedError
from cdp_ident.fit.initial_states import Fit
from cdp_ident.fit.predictability import LOST

_MOST_LOST = 0.25
"""Share of the windows in which the simulation may fail to follow the motion: an event affects only a few."""
_NOISE = 2.0
"""An error below so many times the noise is none of the simulation's, however small the motion is."""


def refuse_a_failed_fit(fits: Sequence[Fit], noise: float) -> None:
    """Raise `FitFailedError` where the model follows the motion in too few windows, fitted or predicted.

    Args:
        fits: how the model follows the motion it was fitted to, and how it predicts it.
        noise: root mean square of what the encoders add to both angles [rad].
    """
    scatter = np.sqrt(np.mean([np.var(window.theta, axis=0).mean() for fit in fits for window in fit.windows]))
    limit = max(LOST * min(float(scatter), 1.0), _NOISE * noise)
    for fit, which in zip(fits, ("fitted", "predicted"), strict=True):
        # An encoder that is off by the same all the time shows no other motion: the scatter is about the mean, too.
        errors = [float(np.sqrt(np.var(error, axis=0).mean())) for error in fit.errors]
        lost = [error for error in errors if error > limit]
        if len(lost) > _MOST_LOST * len(errors):
            raise FitFailedError(
                f"the fit failed: in {len(lost)} of {len(errors)} windows {which} the model moves otherwise than the "
                f"rods, by {np.median(lost):.2g} rad; no parameter means anything. Check L, g and what the angles mean "
                "(zero, outer_angle, inner_sign and outer_sign below trial), the counts per turn, whether "
                "somebody touched the rods, and whether all bags are of one rig; or set a shorter window"
            )

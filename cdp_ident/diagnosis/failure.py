"""Whether a fit failed: whether the model's best motion is another one than was measured."""

from collections.abc import Sequence

import numpy as np

from cdp_ident.errors import FitFailedError
from cdp_ident.fit.refinement import Fit

_LOST = 0.2
"""Error of a window, over the scatter of its angles or a radian, beyond which the model does not follow its motion.
The scatter itself is the error of a model that knows nothing but the mean."""
_MOST_LOST = 0.25
"""Share of the windows that may be lost: what happens once is in few of them."""


def refuse_a_failed_fit(fits: Sequence[Fit]) -> None:
    """Raise `FitFailedError` where the model follows the motion in too few windows, fitted or kept out."""
    for fit, which in zip(fits, ("fitted", "kept out of the fit"), strict=True):
        lost = [
            float(np.sqrt(np.mean(residual**2)))
            for window, residual in zip(fit.windows, fit.residuals, strict=True)
            if np.sqrt(np.mean(residual**2)) > _LOST * min(float(np.mean(np.std(window.theta, axis=0))), 1.0)
        ]
        if len(lost) > _MOST_LOST * len(fit.windows):
            raise FitFailedError(
                f"the fit failed: in {len(lost)} of {len(fit.windows)} windows {which} the model moves otherwise than "
                f"the rods, by {np.median(lost):.2g} rad; no parameter means anything. Check L, g and what the angles "
                "mean (trial.zero, trial.outer_angle, trial.inner_sign, trial.outer_sign), whether somebody touched "
                "the rods, and whether all bags are of one rig; or set a shorter window"
            )

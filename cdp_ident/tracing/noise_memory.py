"""Noise with a memory, or more: what a torque leaves is as smooth as the motion that it acts on."""

import numpy as np

from cdp_ident.fit.refinement import Fit
from cdp_ident.model.parameters import time_unit
from cdp_ident.tracing import thresholds

_WHITE = 2.0
"""Samples: residuals whose integrated correlation time is shorter are white, however slowly they are sampled."""
_LENGTHS = 5.0
"""Noise that is forgotten exponentially shows in so many integrated correlation times at most."""


def is_structured(fit: Fit) -> bool:
    """Return whether residuals are correlated for longer than noise is: then more than noise remains."""
    return fit.autocorrelation.integrated_time > _longest(fit)


def forgets_soon(fit: Fit) -> bool:
    """Return whether residuals are correlated for much less time than rods take to move, as noise with a memory is.

    Their size says nothing of that: the noise is estimated from differences of neighbouring samples, which are too
    small where they are correlated.
    """
    return not is_structured(fit) and fit.autocorrelation.length < _LENGTHS * _longest(fit)


def _longest(fit: Fit) -> float:
    """Return the longest integrated correlation time of noise [samples]."""
    step = float(np.median(np.concatenate([np.diff(window.time) for window in fit.windows])))
    return max(_WHITE, thresholds.NOISE_MEMORY * time_unit(*fit.model.constants(fit.values)) / step)

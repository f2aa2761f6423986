"""Noise with a memory, or more: what a torque leaves is as smooth as the motion that it acts on."""

import numpy as np

from cdp_ident.fit.autocorrelation import decay_time
from cdp_ident.fit.refinement import Fit
from cdp_ident.model.parameters import time_unit
from cdp_ident.tracing import thresholds

DECAY = 0.4
"""Residuals with the autocorrelations of a first-order autoregressive process are noise if they decay within less
[sqrt(L / g)]: what missing effects leave decays otherwise, or within 0.5 and more."""
_WHITE = 2.0
"""Samples: residuals whose integrated correlation time is shorter are white, however slowly they are sampled."""
_LENGTHS = 5.0
"""Noise that is forgotten exponentially shows in so many integrated correlation times at most."""


def is_structured(fit: Fit) -> bool:
    """Return whether residuals are correlated for longer than noise is: then more than noise remains."""
    return fit.autocorrelation.integrated_time > _longest(fit) and not _fades(fit)


def forgets_soon(fit: Fit) -> bool:
    """Return whether residuals are correlated for much less time than rods take to move, as noise with a memory is.

    Their size says nothing of that: the noise may be estimated too small where neighbouring samples are correlated.
    """
    is_short = fit.autocorrelation.length < _LENGTHS * _longest(fit)
    return (is_short and fit.autocorrelation.integrated_time <= _longest(fit)) or _fades(fit)


def _fades(fit: Fit) -> bool:
    """Return whether correlations fall as those of noise with a memory do, soon enough to be that."""
    return decay_time(fit.residuals, fit.autocorrelation.length) < DECAY * _samples(fit)


def _longest(fit: Fit) -> float:
    """Return the integrated correlation time up to which residuals are noise of whatever kind [samples]."""
    return max(_WHITE, thresholds.NOISE_MEMORY * _samples(fit))


def _samples(fit: Fit) -> float:
    """Return how many samples there are in the unit of time of the motion, sqrt(L / g)."""
    step = float(np.median(np.concatenate([np.diff(window.time) for window in fit.windows])))
    return time_unit(*fit.model.constants(fit.values)) / step

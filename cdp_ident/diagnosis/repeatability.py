"""Whether the estimates from each trial alone agree with each other."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.special import chdtrc

from cdp_ident.diagnosis.uncertainty import covariance
from cdp_ident.fit.refinement import Fit, refine

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Repeatability:
    """Each trial's own estimate beside the joint one."""

    trials: tuple[str, ...]
    """Names of the trials."""
    names: tuple[str, ...]
    """Of the unknowns that are compared: not 1 / A22, which no trial shows alone."""
    values: Array
    """(trials, unknowns) each trial's own estimate."""
    std: Array
    """(trials, unknowns) its standard deviations."""
    p_value: float
    """Probability that estimates scatter at least so much if all trials have the same parameters."""

    @property
    def agree(self) -> bool:
        """Whether the trials agree, at a level of 1 %."""
        return self.p_value > 0.01


def repeatability(fit: Fit, names: Sequence[str]) -> Repeatability | None:
    """Fit each trial alone, beginning from the joint fit; None where only one trial was fitted.

    The estimates are compared by their weighted sum of squares about their weighted mean, which is chi-squared
    distributed if they agree. A22, where weights show it, is that of the joint fit: by it the estimates of a trial with
    weights are those of the rig without.
    """
    indices = sorted({window.trial for window in fit.windows})
    if len(indices) < 2:
        return None
    model, remain = fit.model.with_inertia_known(fit.values)
    values, covariances = [], []
    for index in indices:
        alone = refine(model, fit.values[remain], [window for window in fit.windows if window.trial == index])
        values.append(alone.values)
        covariances.append(covariance(alone))
    std = np.sqrt([np.diag(spread) for spread in covariances])
    # Coefficients of curves would agree in any case, because of their penalties.
    seen = np.all(np.isfinite(std) & (std > 0), axis=0) & model.of_rig & ~model.of_curves
    inverses = [np.linalg.pinv(spread[np.ix_(seen, seen)], hermitian=True) for spread in covariances]
    estimates = np.array(values)[:, seen]
    mean = np.linalg.pinv(sum(inverses), hermitian=True) @ sum(
        inverse @ estimate for inverse, estimate in zip(inverses, estimates, strict=True)
    )
    scatter = sum(
        (estimate - mean) @ inverse @ (estimate - mean) for inverse, estimate in zip(inverses, estimates, strict=True)
    )
    # The common A22 was chosen so that they agree.
    freedom = (len(indices) - 1) * int(seen.sum()) - int(fit.model.inertia_free)
    return Repeatability(
        trials=tuple(names[index] for index in indices),
        names=model.names,
        values=np.array(values),
        std=std,
        p_value=float(chdtrc(freedom, scatter)) if freedom > 0 else 1.0,
    )

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whether the estimates from each trial alone agree with each other."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from scipy.special import chdtrc

from cdp_ident.likelihood.gauss_newton import GaussNewton
from cdp_ident.likelihood.maxima import ENOUGH_STEPS
from cdp_ident.likelihood.whole_swing import WholeSwings

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


def repeatability(found: WholeSwings, trials: Collection[int], names: Sequence[str]) -> Repeatability | None:
    """Fit each trial alone, beginning from the joint fit; None where only one trial was fitted.

    The estimates are compared by their weighted sum of squares about their weighted mean, which is chi-squared
    distributed if they agree. A22, where weights show it, is that of the joint fit: by it the estimates of a trial with
    weights are those of the rig without.

    Args:
        found: the joint fit.
        trials: which of its trials are compared.
        names: of all trials.

    Raises:
        IdentificationError: a trial alone cannot be fitted.
    """
    indices = sorted({swing.trial for swing in found.recorded.swings} & set(trials))
    if len(indices) < 2:
        return None
    model, remain = found.model.with_inertia_known(found.values)
    values, covariances = [], []
    for index in indices:
        places = [k for k, swing in enumerate(found.recorded.swings) if swing.trial == index]
        recorded = replace(found.recorded, swings=tuple(found.recorded.swings[k] for k in places))
        states = [found.states[k] for k in places]
        noise = replace(found.noise, tails=())
        alone = GaussNewton(model, found.values[remain], recorded, states, noise).run(ENOUGH_STEPS).found()
        values.append(alone.values)
        covariances.append(alone.covariance)
    std = np.sqrt([np.diag(spread) for spread in covariances])
    # Coefficients of curves would agree in any case, as they are smooth; what happens once is of one trial.
    seen = np.all(np.isfinite(std) & (std > 0), axis=0) & model.of_rig & ~model.of_curves
    for index, active in enumerate(model.effects):
        seen[model.places(index)] &= active.trial is None
    inverses = [np.linalg.pinv(spread[np.ix_(seen, seen)], hermitian=True) for spread in covariances]
    estimates = np.array(values)[:, seen]
    mean = np.linalg.pinv(sum(inverses), hermitian=True) @ sum(
        inverse @ estimate for inverse, estimate in zip(inverses, estimates, strict=True)
    )
    scatter = sum(
        (estimate - mean) @ inverse @ (estimate - mean) for inverse, estimate in zip(inverses, estimates, strict=True)
    )
    # The common A22 was chosen so that they agree.
    freedom = (len(indices) - 1) * int(seen.sum()) - int(found.model.inertia_free)
    return Repeatability(
        trials=tuple(names[index] for index in indices),
        names=model.names,
        values=np.array(values),
        std=std,
        p_value=float(chdtrc(freedom, scatter)) if freedom > 0 else 1.0,
    )

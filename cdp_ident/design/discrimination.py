"""Two effects that the trials do not distinguish: which further trial does.

T-optimal is the trial in which the alternative model, its values adjusted as well as they can be, comes least near to
what the fitted model says (Atkinson and Fedorov, Biometrika 62, 1975). The alternative must keep explaining the trials
that there are: it is adjusted to their motion, as the fitted model has it, along with the new one.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cdp_ident.design.candidate_trial import CandidateTrial, predictions, windows_of
from cdp_ident.design.information import curvature, negative_gradient, scaled_inverse
from cdp_ident.design.knowledge import Knowledge
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.initial_states import InitialState
from cdp_ident.fit.refinement import Fit, fit_initial_states, refine
from cdp_ident.fit.scales import ENOUGH
from cdp_ident.fit.share import share_of
from cdp_ident.fit.windows import Window
from cdp_ident.likelihood.prior import typical
from cdp_ident.likelihood.scores import beginning_of
from cdp_ident.model.effects.catalogue import known_effects
from cdp_ident.model.parameters import time_unit

Array = npt.NDArray[np.float64]

_UNOBSERVABLE = 1e-12
_SAME = 0.1
"""An alternative nearer to the model than so many deviations can be it, as an extended model of an effect can."""


@dataclass(frozen=True)
class Alternative:
    """A model with another effect in the place of one, adjusted to what the fitted model says of the trials."""

    knowledge: Knowledge
    """Of the fitted model."""
    fit: Fit
    """Of the alternative, to the trials' motion as the fitted model has it, or to windows spread evenly over it."""
    share: float = 1.0
    """Of the windows to which it was fitted: so much of what all of them show."""

    @property
    def deviations_now(self) -> float:
        """By how many standard deviations the two differ in the trials that there are."""
        return float(np.sqrt(self.fit.squared_error / self.share)) / self.knowledge.noise

    def deviations(self, trial: CandidateTrial) -> float:
        """Return by how many standard deviations the two would differ with a further trial; 0 if it has no motion.

        The alternative is linear about its values.
        """
        try:
            windows = windows_of(trial, self.knowledge)
        except IdentificationError:
            return 0.0
        new = _followed(self.fit, windows)
        if new is None:
            return 0.0
        slope = negative_gradient(new)
        known = curvature(self.fit) / self.share + self.fit.model.penalty
        inverse, _ = scaled_inverse(known + curvature(new), _UNOBSERVABLE)
        left = sum(_beside_the_start(new, index) for index in range(len(new.windows)))
        squared = self.fit.squared_error / self.share + left - float(slope @ inverse @ slope)
        return float(np.sqrt(max(squared, 0.0))) / self.knowledge.noise


def _followed(alternative: Fit, windows: Sequence[Window]) -> Fit | None:
    """Return how an alternative follows the motion of windows from their starts; None where it cannot be computed."""
    residuals, sensitivities = [], []
    predicted = predictions(alternative.model, alternative.values, windows)
    for window, (theta, by_unknowns) in zip(windows, predicted, strict=True):
        residuals.append(window.whitened(window.theta - theta))
        sensitivities.append(window.whitened(by_unknowns))
    if not all(np.all(np.isfinite(values)) for values in (*residuals, *sensitivities)):
        return None
    weights = tuple(np.ones_like(residual) for residual in residuals)
    return replace(
        alternative,
        windows=tuple(windows),
        residuals=tuple(residuals),
        sensitivities=tuple(sensitivities),
        weights=weights,
    )


def _beside_the_start(fit: Fit, index: int) -> float:
    """Return the squared error of a window that no initial state accounts for [rad^2]."""
    sensitivity = fit.sensitivities[index]
    by_state = sensitivity.reshape(-1, sensitivity.shape[2])[:, : fit.model.states]
    return float(np.sum(InitialState.of(by_state).eliminated_from(fit.residuals[index].ravel()) ** 2))


def alternatives(knowledge: Knowledge, windows: Sequence[Window], label: str, key: str) -> Iterator[Alternative]:
    """Yield models with another effect in the place of one; of several forms each that can be fitted.

    They are fitted to a share of the windows, where there is more motion than effects are looked for in.

    Args:
        knowledge: of the fitted model.
        windows: of the trials that there are, their angles being those of the fitted model.
        label: of the effect in the fitted model.
        key: of the effect instead; name and joint alone stand for all of its forms.
    """
    index = knowledge.model.labels.index(label)
    model, remain = knowledge.model.without_effect(index)
    unit = time_unit(*knowledge.model.constants(knowledge.values))
    chosen = share_of(windows, ENOUGH * unit)
    try:
        known = fit_initial_states(knowledge.model, knowledge.values, [windows[k] for k in chosen])
        removed = refine(model, knowledge.values[remain], known.windows)
    except IdentificationError:
        return
    for form in known_effects():
        if key not in (form.key, f"{form.name}.{form.joint}") or form.at_an_instant:
            continue
        new = ActiveEffect(form)
        try:
            begin = np.concatenate([removed.values, _beginning(new, unit)])
            fit = refine(model.with_effect(new), begin, removed.windows)
        except (IdentificationError, np.linalg.LinAlgError):
            continue
        yield Alternative(knowledge, fit, len(chosen) / len(windows))


def _beginning(new: ActiveEffect, unit: float) -> Array:
    """Return values of an effect's parameters to begin with: no strength, where that shows what more of it would do."""
    if not new.effect.has_score:
        return np.array([typical(parameter, unit) for parameter in new.fitted])
    lower, upper = (np.array([getattr(parameter, end) for parameter in new.fitted]) for end in ("lower", "upper"))
    return np.asarray(np.clip(beginning_of(new, unit), lower, upper))


def can_be_the_same(alternative: Alternative) -> bool:
    """Return whether an alternative can say all that the fitted model says, as an extended model of its effect can."""
    return alternative.deviations_now < _SAME

"""Encoders whose zeros differ from trial to trial, because they were set anew for each trial.

A trial's zeros belong to the trial and not to the rig, like its initial states: they are fitted along with everything
else, and those of a held-out trial are fitted to that trial, as its initial states are.
"""

import numpy as np
import numpy.typing as npt

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.model.effects.catalogue import NAMED
from cdp_ident.model.effects.effect import JOINTS
from cdp_ident.tracing import thresholds
from cdp_ident.tracing.acceptance import improves_enough, is_accepted
from cdp_ident.tracing.addition import at_instants
from cdp_ident.tracing.candidates import Candidate
from cdp_ident.tracing.evidence import Attempt, change
from cdp_ident.tracing.noise_memory import is_structured
from cdp_ident.tracing.progress import Progress
from cdp_ident.tracing.refits import left_after

Array = npt.NDArray[np.float64]

_FOR_ALL = tuple(effect for effect in NAMED if effect.acts_as_zero)
_OFFSETS = tuple(effect for effect in _FOR_ALL if not effect.moves)


def fit_zeros_by_trial(progress: Progress) -> None:
    """Let the encoders' zeros differ from trial to trial, if that is better than the same offsets in all.

    Raises:
        InterruptedSelectionError: the selection is asked to stop.
    """
    current = progress.current
    trials = {window.trial for window in current.fit.windows}
    if len(trials) < 2 or current.model.zeros:
        return
    present = {active.effect.key for active in current.model.effects}
    offsets = [effect for effect in _OFFSETS if effect.key not in present]
    same = progress.tried(current, [tuple(Candidate(ActiveEffect(effect), 0.0, np.zeros(1)) for effect in offsets)])
    own = _with_zeros_by_trial(progress, current)
    if not same or own is None:
        return
    (_, in_all) = same[0]
    if _are_rounding(progress, own):
        return
    # Where large effects are missing, zeros explain a small part of any of them.
    slow = is_structured(own.fit)
    if slow and own.validation.rmse() > (1.0 - thresholds.LARGE_SHARE) * in_all.validation.rmse():
        return
    if _is_better(own, in_all) and not _are_lost_counts(progress, own):
        progress.current = own
        of_trials = " and ".join(f"{1e3 * size:.3g}" for size in largest_zeros(own))
        progress.note(
            "zeros by trial",
            own,
            f"each trial has zeros of its own, off by up to {of_trials} mrad: {1e3 * current.validation.rmse():.3g} -> "
            f"{1e3 * own.validation.rmse():.3g} mrad in cross-validation",
        )


def fit_zeros_by_trial_again(progress: Progress) -> None:
    """Do the same again where the encoders are off by the same in all trials, beside the effects found since.

    Raises:
        InterruptedSelectionError: the selection is asked to stop.
    """
    if any(active.effect in _FOR_ALL for active in progress.current.model.effects):
        fit_zeros_by_trial(progress)


def drop_superfluous_zeros(progress: Progress) -> None:
    """Take the encoders' zeros for right again, where effects that came in later explain what zeros by trial did.

    Raises:
        InterruptedSelectionError: the selection is asked to stop.
    """
    current = progress.current
    if not current.model.zeros:
        return
    model, remain = current.model.without_zeros()
    right = progress.refitted(model, current.fit.values[remain], current, "zeros that are right")
    if right is None:
        return
    if not _are_rounding(progress, current) and _is_better(current, right):
        return
    progress.current = progress.finished(right)
    errors = f"{1e3 * current.validation.rmse():.3g} -> {1e3 * progress.current.validation.rmse():.3g} mrad"
    progress.note("dropped zeros by trial", progress.current, f"zeros of each trial no longer help: {errors}")


def _is_better(own: Attempt, others: Attempt) -> bool:
    """Return whether zeros of each trial explain enough more than none or common ones."""
    return improves_enough(others, own) and change(others, own).bic < 0


def _are_lost_counts(progress: Progress, own: Attempt) -> bool:
    """Return whether counts that an encoder lost at an instant explain the motion better than zeros by trial do.

    All windows after that instant are off by the same, as if the trial had a zero of its own.
    """
    current = progress.current
    slips = [c for c in at_instants(progress, (current.fit,)) if not c.active.effect.moves]
    tried = [attempt for _, attempt in progress.tried(current, ((candidate,) for candidate in slips))]
    return any(is_accepted(current, slip) and change(own, slip).bic < 0 for slip in tried)


def _are_rounding(progress: Progress, own: Attempt) -> bool:
    """Return whether zeros differ by less than the encoders show."""
    differ = zip(JOINTS, np.ptp(_zeros_of(own), axis=0), strict=True)
    return all(progress.is_rounding(joint, difference) for joint, difference in differ)


def largest_zeros(attempt: Attempt) -> list[float]:
    """Return the largest zero of each encoder [rad]."""
    return list(np.max(np.abs(_zeros_of(attempt)), axis=0))


def _zeros_of(attempt: Attempt) -> Array:
    """Return the zeros (trials, 2) of both encoders in the trials that are fitted [rad]."""
    return np.array([attempt.fit.values[attempt.model.zero_places(trial)] for trial in attempt.model.zeros])


def _with_zeros_by_trial(progress: Progress, attempt: Attempt) -> Attempt | None:
    """Return a model with zeros by trial in the place of common offsets; None where it cannot be fitted."""
    in_all = [index for index, active in enumerate(attempt.model.effects) if active.effect in _FOR_ALL]
    model, values = left_after(attempt, in_all)
    model, values = model.with_zeros(values, {window.trial for window in attempt.fit.windows})
    return progress.refitted(model, values, attempt, "zeros by trial")

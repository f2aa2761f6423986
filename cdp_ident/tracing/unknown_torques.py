"""Torques that no effect of the catalogue explains, identified as smooth curves.

They are tried when the selection of named effects has ended and more than noise remains; so a named effect that
explains as much is preferred. After a curve was added, the named effects are tested again. Harmonics of a turn alone
have to stand against a curve even where only noise remains: several of them imitate any torque that depends on the
angle.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeGuard

import numpy as np
import numpy.typing as npt

from cdp_ident.diagnosis.cross_validation import error_from_other_trials
from cdp_ident.diagnosis.uncertainty import curvature, negative_gradient
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.refinement import Fit, fit_initial_states_near, with_all_derivatives
from cdp_ident.model.effects.catalogue import NAMED
from cdp_ident.model.effects.curves import CURVES
from cdp_ident.model.effects.effect import Effect
from cdp_ident.tracing import thresholds
from cdp_ident.tracing.acceptance import fits_of, is_accepted
from cdp_ident.tracing.candidates import Candidate, ScoreTest
from cdp_ident.tracing.evidence import Attempt, change
from cdp_ident.tracing.preference import is_better
from cdp_ident.tracing.progress import Progress
from cdp_ident.tracing.refits import left_after
from cdp_ident.tracing.screening import expected_variance
from cdp_ident.tracing.smoothness import Smooth, smooth_curve

Array = npt.NDArray[np.float64]

_MOST_CURVES = 3
_MANY_HARMONICS = 3
"""So many harmonics of one joint are one torque that depends on the angle, if a curve explains as much."""
_REFITS = 2
"""Number of curves that are fitted, the best by each of two score tests."""


def add_unknown_torques(progress: Progress) -> None:
    """Add torques without a name as long as they are accepted.

    Raises:
        InterruptedSelectionError: the selection is asked to stop.
    """
    _exchange_harmonics(progress)
    for _ in range(_MOST_CURVES):
        current = progress.current
        accepted: list[tuple[Candidate, Attempt]] = []
        for candidate in _promising(current, _possible(current, progress.noise)):
            fitted = _fitted(progress, current, candidate)
            accepted += [
                (candidate, attempt)
                for attempt in fitted
                if _is_accepted(current, attempt) and _predicts_other_trials(progress, attempt)
            ]
            if any(_leaves_only_noise(attempt, progress.noise) for _, attempt in accepted):
                break  # nothing is missing
        if not accepted:
            return
        candidate, best = min(accepted, key=lambda found: change(current, found[1]).bic)
        best = _even_instead(progress, _without_compensating(progress, current, best, candidate))
        best = progress.finished(best)
        key = best.model.effects[-1].effect.key
        before_and_after = f"{1e3 * current.validation.rmse():.3g} -> {1e3 * best.validation.rmse():.3g} mrad"
        progress.note(f"added {key}", best, f"added {key}: {before_and_after} in cross-validation")
        progress.current = _without_imitations(progress, best)


def _exchange_harmonics(progress: Progress) -> None:
    """Exchange all harmonics of a joint for one curve over its angle where that is better; many where it is as good.

    Few that leave only noise stay if the score test of the curve beside them shows nothing that they lack. Where a
    curve is no better beside a spring, another torque over the angle, it may be in the place of both.
    """
    for over_angle in (c for c in CURVES if c.curve and c.curve.over == "angle" and not c.dry):
        effects = [active.effect for active in progress.current.model.effects]
        of_angle = [
            place
            for place, effect in enumerate(effects)
            if effect.moves and effect.of_angle and effect.joint == over_angle.joint
        ]
        harmonics = [place for place in of_angle if effects[place].harmonic]
        if not harmonics or over_angle in effects:
            continue
        if not _exchange_for_curve(progress, harmonics, over_angle) and of_angle != harmonics:
            _exchange_for_curve(progress, of_angle, over_angle)


def _exchange_for_curve(progress: Progress, places: Sequence[int], over_angle: Effect) -> bool:
    """Exchange torques of a joint for one curve over its angle; return whether that was better, or as good for many.

    Args:
        progress: of the selection.
        places: indices of the torques.
        over_angle: the curve.
    """
    current = progress.current
    few_leave_only_noise = len(places) < _MANY_HARMONICS and _leaves_only_noise(current, progress.noise)
    if few_leave_only_noise and not _promising(current, [over_angle]):
        return False
    removed = progress.without(current, places)
    many = len(places) >= _MANY_HARMONICS and all(current.model.effects[place].effect.harmonic for place in places)
    for candidate in _promising(removed, [over_angle]):
        for attempt in _fitted(progress, removed, candidate):
            better = is_better(attempt, current)
            as_good = many and attempt.validation.rmse() < thresholds.AS_GOOD * current.validation.rmse()
            if (better or as_good) and is_accepted(removed, attempt, [len(attempt.model.effects) - 1]):
                best, old = progress.finished(attempt), " and ".join(current.model.labels[k] for k in places)
                how = "better than" if better else "as well as"
                line = f"{over_angle.key} explains the motion {how} {old}"
                progress.note(f"exchanged {old} for {over_angle.key}", best, line)
                progress.current = _without_imitations(progress, best)
                return True
    return False


def _possible(attempt: Attempt, noise: float) -> list[Effect]:
    """Return the curves to try; where only noise remains, only those that could replace constant dry friction."""
    effects = [active.effect for active in attempt.model.effects]
    curves = [curve for curve in CURVES if curve not in effects]
    if not _leaves_only_noise(attempt, noise):
        return curves
    even = {effect.joint for effect in effects if _is_even_friction(effect)}
    return [curve for curve in curves if curve.dry and curve.joint in even]


def _leaves_only_noise(attempt: Attempt, noise: float) -> bool:
    return max(fit.rmse() for fit in fits_of(attempt)) <= thresholds.ABOVE_NOISE * noise


def _is_even_friction(effect: Effect) -> bool:
    """Return whether an effect is dry friction that does not depend on the joint's angle."""
    return _is_dry(effect) and effect.of_joint


def _is_dry(effect: Effect) -> TypeGuard[Effect]:
    return effect.moves and effect.dry


def _promising(attempt: Attempt, curves: Sequence[Effect]) -> list[Candidate]:
    """Return the best curves by score tests over the windows and over short pieces of them."""
    found: dict[str, Candidate] = {}
    for fit in (attempt.closely, attempt.fit) if curves else ():
        ranked = []
        for effect in curves:
            assert effect.curve
            # One by one: all together would take a gigabyte for a long recording.
            matrix, right = ScoreTest(fit, [ActiveEffect(effect)]).reduced(0)
            smooth = smooth_curve(effect.curve, matrix, right, expected_variance(fit, 0.0))
            gain = smooth.gain / expected_variance(fit, smooth.gain)
            candidate = Candidate(
                ActiveEffect(effect, stiffness=smooth.stiffness), max(smooth.gain, 0.0), smooth.coefficients
            )
            ranked.append((gain - thresholds.least_score(smooth.freedom), gain, candidate))
        ranked.sort(key=lambda found: -found[0])
        for beyond_chance, gain, candidate in ranked[:_REFITS]:
            if beyond_chance > 0.0 and gain > thresholds.CURVE_NEAR_THE_BEST * ranked[0][1]:
                found.setdefault(candidate.active.effect.key, candidate)
    return list(found.values())


def _fitted(progress: Progress, before: Attempt, candidate: Candidate) -> list[Attempt]:
    """Return a model with a curve more; none where it cannot be fitted.

    Its stiffness is first that of the score test and then that of the fit, as long as that lowers the validation error,
    by a share or, where most of it is noise, by more than chance does. A fit that is worse than without the curve, or
    than the friction that it replaces, has failed.
    """
    best: Attempt | None = None
    attempts = _begun(progress, before, candidate)
    while attempts and attempts[-1].fit.squared_error < before.fit.squared_error:
        if best is not None and not _predicts_better(best, attempts[-1]):
            break
        best = attempts[-1]
        last = len(best.model.effects) - 1
        changed = replace(best.model.effects[last], stiffness=_smoothed(best.fit).stiffness)
        attempts = progress.replaced(best, [last], [(changed, best.fit.values[best.model.places(last)])])
    return [best] if best else []


def _predicts_better(before: Attempt, after: Attempt) -> bool:
    """Return whether a curve of another stiffness predicts better, by a share or by more than chance."""
    by_a_share = after.validation.rmse() <= before.validation.rmse() / thresholds.AS_GOOD
    return by_a_share or change(before, after).validation > thresholds.VALIDATION_GAIN


def _without_compensating(progress: Progress, current: Attempt, best: Attempt, candidate: Candidate) -> Attempt:
    """Return a model with a curve, but without two effects that compensate each other, if that is as good.

    A base that is not level and an offset of the inner encoder turn the angles of its joint together: they move the
    curve, which is therefore fitted anew without them.
    """
    for pair in best.compensating:
        effects = [best.model.effects[index] for index in pair]
        if any(active.effect.curve for active in effects):
            continue
        removed = progress.without(current, [current.model.effects.index(active) for active in effects])
        for attempt in _fitted(progress, removed, candidate):
            if attempt.validation.rmse() < thresholds.AS_GOOD * best.validation.rmse():
                keys = " and ".join(active.effect.key for active in effects)
                progress.note(f"dropped {keys}", attempt, f"dropped {keys}: they only compensate each other")
                return attempt
    return best


def _even_instead(progress: Progress, attempt: Attempt) -> Attempt:
    """Return a model with constant dry friction in the place of its last effect, if that is as good."""
    last = len(attempt.model.effects) - 1
    curve = attempt.model.effects[last].effect
    if not _is_dry(curve):
        return attempt
    mean = np.array([np.mean(attempt.fit.values[attempt.model.places(last)])])
    even = next(e for e in NAMED if _is_even_friction(e) and e.joint == curve.joint and len(e.parameters) == 1)
    named = progress.replaced(attempt, [last], [(ActiveEffect(even), mean)])
    as_good = [model for model in named if model.validation.rmse() < thresholds.AS_GOOD * attempt.validation.rmse()]
    return as_good[0] if as_good else attempt


def _smoothed(fit: Fit) -> Smooth:
    """Return the last effect of a fit, a curve, as smooth as the fit says."""
    model, values = fit.model, fit.values
    active, place = model.effects[-1], model.places(len(model.effects) - 1)
    assert active.effect.curve
    information, gradient = curvature(fit) + model.penalty, negative_gradient(fit) - model.penalty @ values
    others, across = information[: place.start, : place.start], information[: place.start, place]
    held = np.linalg.pinv(others, rcond=1e-14, hermitian=True) @ np.column_stack([across, gradient[: place.start]])
    matrix = information[place, place] - active.penalty - across.T @ held[:, :-1]
    right = (matrix + active.penalty) @ values[place] + gradient[place] - across.T @ held[:, -1]
    return smooth_curve(active.effect.curve, matrix, right, expected_variance(fit, 0.0))


def _begun(progress: Progress, before: Attempt, candidate: Candidate) -> list[Attempt]:
    """Return a model with a curve, as smooth as a score test says; dry friction replaces constant dry friction."""
    active = candidate.active
    if not _is_dry(active.effect):
        return [attempt for _, attempt in progress.tried(before, [(candidate,)])]
    for index, other in enumerate(before.model.effects):
        if _is_even_friction(other.effect) and other.effect.joint == active.effect.joint:
            return _instead_of_even(progress, before, index, candidate)
    begun = replace(candidate, strengths=np.maximum(candidate.strengths, 0.0))
    return [attempt for _, attempt in progress.tried(before, [(begun,)])]


def _instead_of_even(progress: Progress, before: Attempt, index: int, candidate: Candidate) -> list[Attempt]:
    """Return a model with a curve in the place of constant dry friction; none where it cannot be fitted.

    The score test's curve is what would be added to the constant. How smooth the whole one is, the fit tells in which
    it stands for the constant.
    """
    model, values = left_after(before, [index])
    even = np.full(len(candidate.active.fitted), before.fit.values[before.model.places(index)][0])
    constant = model.with_effect(ActiveEffect(candidate.active.effect)), np.concatenate([values, even])
    try:
        smooth = _smoothed(with_all_derivatives(fit_initial_states_near(*constant, before.fit.windows, np.inf)))
    except (IdentificationError, np.linalg.LinAlgError) as error:
        progress.fail(f"{candidate.active.effect.key} could not be fitted: {error}")
        return []
    active = replace(candidate.active, stiffness=smooth.stiffness)
    return progress.enriched(
        before, index, replace(candidate, active=active, strengths=np.maximum(smooth.coefficients, 0.0))
    )


def _is_accepted(before: Attempt, after: Attempt) -> bool:
    """Return whether a curve improves the model enough, given its number of free parameters."""
    curve = len(after.model.effects) - 1
    enough = after.validation.rmse() < (1.0 - thresholds.LARGE_SHARE) * before.validation.rmse()
    return (enough or _is_dry(after.model.effects[curve].effect)) and is_accepted(before, after, [curve])


def _predicts_other_trials(progress: Progress, attempt: Attempt) -> bool:
    """Return whether a curve lowers the error over each of two trials when it is fitted to the other one alone.

    With three trials or more, cross-validation by trials tests that already; windows of one trial are too similar for a
    test of so many parameters.
    """
    trial_of = [window.trial for window in attempt.fit.windows]
    by_fold = [{trial_of[index] for index in fold} for fold in attempt.folds]
    folds_are_trials = len(by_fold) == len(set(trial_of)) and all(len(trials) == 1 for trials in by_fold)
    if len(set(trial_of)) == 1 or folds_are_trials:
        return True
    key = attempt.model.effects[-1].effect.key
    try:
        with_it, without_it = (error_from_other_trials(model.fit) for model in (attempt, progress.current))
    except (IdentificationError, np.linalg.LinAlgError) as error:
        progress.fail(f"{key} is not added, for a fit of one trial alone could not be computed: {error}")
        return False
    if with_it < without_it:
        return True
    errors = f"{1e3 * without_it:.3g} -> {1e3 * with_it:.3g} mrad"
    progress.say(f"{key} is not added: fitted to one trial, it does not help in the other ({errors})")
    return False


def _without_imitations(progress: Progress, attempt: Attempt) -> Attempt:
    """Return a model without the effects that are no longer accepted beside its new curve."""
    for index in reversed(range(len(attempt.model.effects) - 1)):
        effect = attempt.model.effects[index].effect
        if effect.curve:
            continue
        removed = progress.without(attempt, [index])
        as_good = removed.validation.rmse() < thresholds.AS_GOOD * attempt.validation.rmse()
        if as_good and not is_accepted(removed, attempt, [index]):
            attempt, key = removed, effect.key
            progress.note(f"dropped {key}", attempt, f"dropped {key}: what it explained is explained otherwise")
    return attempt

"""Forward steps: effects are added one by one, each accepted by windows that it was not fitted to.

At each step all candidates get a score test and the promising ones a full refit; the best is added if it helps.
"""

import math
from collections.abc import Iterable, Sequence
from functools import partial

import numpy as np

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.force_balance import ForceBalance
from cdp_ident.fit.refinement import Fit
from cdp_ident.tracing import thresholds
from cdp_ident.tracing.acceptance import fit_gains_by_more_than_chance, fits_of, is_accepted, may_be_accepted
from cdp_ident.tracing.candidates import Candidate, ScoreTest, addable
from cdp_ident.tracing.evidence import Attempt, change
from cdp_ident.tracing.exchange import try_states, try_without_memory, try_without_states
from cdp_ident.tracing.instants import instants
from cdp_ident.tracing.preference import is_better
from cdp_ident.tracing.progress import Progress
from cdp_ident.tracing.pruning import drop_superfluous, without_superfluous_ones
from cdp_ident.tracing.screening import expected_variance, gains_enough, is_worth_a_look, promising
from cdp_ident.tracing.selection import Tried

_MOST_EFFECTS = 8
_REFITS = 6
"""Candidates that get a full refit at a step."""
_WEAK_REFITS = 2
"""The same where the windows are many."""
_WORST = 20
"""Where the windows are many, effects of an instant are looked for in so many, in which the model fits worst."""
_STRONGEST, _SECONDS = 2, 3
"""Where no candidate helps alone, so many of them are combined with so many others each."""

_Refitted = tuple[tuple[Candidate, ...], Attempt]
"""The candidates that were added, and the refitted model."""


def add_balanced(progress: Progress, balances: Sequence[ForceBalance]) -> None:
    """Begin with the effects that balances of forces show, such as dry friction, if they are accepted.

    Where these are strong, the paper's model fits so badly that its residuals do not show them.
    """
    current, seen = progress.current, set[tuple[str, ...]]()
    refitted: list[_Refitted] = []
    for balance in balances:
        candidates = tuple(Candidate(ActiveEffect(effect), 0.0, strengths) for effect, strengths in balance.found)
        # All of them, and without the first, which is the most unusual.
        for chosen in (candidates, candidates[1:]):
            keys = tuple(candidate.active.effect.key for candidate in chosen)
            if chosen and keys not in seen:
                seen.add(keys)
                begin = current.model.with_base_parameters(current.fit.values, balance.groups, balance.inertia)
                attempt = progress.from_balance(current, begin, chosen)
                if attempt is not None:
                    refitted.append((chosen, attempt))
    accepted = [attempt for _, attempt in refitted if is_accepted(current, attempt)]
    if not accepted:
        # One of them may stand in the others' way: a balance of forces of a joint that soon sticks is uncertain.
        fewer = (without_superfluous_ones(progress, attempt) for _, attempt in refitted)
        accepted = [attempt for attempt in fewer if attempt.model.effects and is_accepted(current, attempt)]
    if accepted:
        best = progress.finished(min(accepted, key=lambda attempt: change(current, attempt).bic))
        _note(progress, best, refitted)
        progress.current = best


def add_effects(progress: Progress) -> None:
    """Add effects until none helps any more; after each, those are dropped that no longer help.

    Raises:
        InterruptedSelectionError: the selection is asked to stop.
    """
    while len(progress.current.model.effects) < _MOST_EFFECTS:
        current = progress.current
        test = ScoreTest(current.fit, addable(current.model, with_states=False))
        refitted = singly = _one_by_one(progress, test)
        best = _best(progress, refitted)
        # The next ones take longer, and imitate more.
        if best is None and current.fit.rmse() > thresholds.ABOVE_NOISE * progress.noise:
            try_without_states(progress)  # a simpler form may leave so much that nothing else helps
            if progress.current is not current:
                continue
        if best is None:
            refitted = [*refitted, *_oscillating(progress)]
            best = _best(progress, refitted)
        if best is None:
            refitted = [*refitted, *_together(progress, test, singly)]
            best = _best(progress, refitted)
        best = best and progress.finished(best)
        _note(progress, best, refitted)
        if best is None:
            return
        better = drop_superfluous(progress, best)
        if better.validation.squared_error >= current.validation.squared_error:
            return  # an addition made another effect superfluous, without further improvement
        progress.current = better
        try_without_memory(progress)
        try_states(progress, lambda effect: effect.swings)


def add_weak_effects(progress: Progress) -> None:
    """Add effects that a score test over many windows shows, as long as they are accepted.

    Effects with states of their own are not among them.

    Raises:
        InterruptedSelectionError: the selection is asked to stop.
    """
    while len(progress.current.model.effects) < _MOST_EFFECTS:
        progress.go_on()
        current = progress.current
        test = ScoreTest(current.fit, addable(current.model, with_states=False))
        worth = [c for c in test.ranked() if is_worth_a_look(current.fit, c)]
        errors = [float(np.mean(residual**2)) for residual in current.fit.residuals]
        worst = sorted(np.argsort(errors, kind="stable")[-_WORST:].tolist())
        candidates = (*worth[:_WEAK_REFITS], *at_instants(progress, [current.fit.over(worst)]))
        refitted = _tried(progress, ((candidate,) for candidate in candidates))
        best = _best(progress, refitted)
        best = best and progress.finished(best)
        _note(progress, best, refitted)
        if best is None:
            return
        progress.rivals[best.model.labels[-1]] = tuple(attempt for _, attempt in refitted)
        better = drop_superfluous(progress, best)
        if better.validation.squared_error >= current.validation.squared_error:
            return  # as in `add_effects`
        progress.current = better


def _one_by_one(progress: Progress, test: ScoreTest) -> list[_Refitted]:
    """Return refits with each of the promising effects, but for those that bring states of their own."""
    current = progress.current
    once = at_instants(progress, (current.fit, current.closely))
    return _tried(progress, ((candidate,) for candidate in (*promising(current, test, _REFITS), *once)))


def _oscillating(progress: Progress) -> list[_Refitted]:
    """Return refits with each effect that oscillates by itself."""
    current = progress.current
    effects = [active for active in addable(current.model) if active.effect.brings_states]
    ranked = promising(current, ScoreTest(current.fit, effects), _REFITS) if effects else []
    refitted = _tried(progress, ((candidate,) for candidate in ranked))
    best = _best(progress, refitted)
    if best and best.fit.rmse() > thresholds.ABOVE_NOISE * progress.noise:
        # It has a minimum at several frequencies.
        refitted += _tried(progress, ((other,) for candidate in ranked for other in candidate.elsewhere))
    return refitted


def _together(progress: Progress, test: ScoreTest, singly: Sequence[_Refitted]) -> list[_Refitted]:
    """Return refits with two effects, of which none helps alone: those of the best pairs, and others.

    The stronger effect of each is tried alone as well: one that fits far from where its score test points, or that the
    test does not show at all, may be found beside another one that it then does not need.

    Args:
        progress: of the selection.
        test: of the candidates.
        singly: refits with one of them.
    """
    pairs = (pair for pair in test.pairs(_REFITS // 2) if gains_enough(progress.current.fit, pair))
    refitted = [*_tried(progress, (pair.members for pair in pairs)), *_with_seconds(progress, singly)]
    return [*refitted, *_stronger_alone(progress, refitted)]


def _stronger_alone(progress: Progress, pairs: Sequence[_Refitted]) -> list[_Refitted]:
    """Return refits with the stronger effect of each of some pairs, from the values that it has beside the other.

    Of pairs with the same stronger effect the one that explains most is taken.
    """
    current = progress.current
    first = len(current.model.effects)
    found: dict[str, tuple[Candidate, tuple[Attempt, int]]] = {}
    for members, attempt in sorted(pairs, key=lambda pair: pair[1].fit.squared_error):
        if fit_gains_by_more_than_chance(change(current, attempt)):
            stronger = max((0, 1), key=lambda place: attempt.strength(first + place))
            of_both = members[stronger], (attempt, first + 1 - stronger)
            found.setdefault(members[stronger].active.effect.key, of_both)
    alone = progress.reduced([pair for _, pair in found.values()], may_win=partial(may_be_accepted, current))
    return [((member,), after) for (member, _), after in zip(found.values(), alone, strict=True) if after]


def at_instants(progress: Progress, fits: Sequence[Fit]) -> list[Candidate]:
    """Return the effects of an instant that fits show, such as those to windows and to short pieces of them.

    Lost counts are whole ones: less is the rounding of a joint at rest.
    """
    found: dict[tuple[str, int | None, float], Candidate] = {}
    for fit in fits:
        large = [c for c in instants(fit) if c.gain > thresholds.INSTANT_GAIN * expected_variance(fit, c.gain)]
        for candidate in large[:2]:
            size, time = candidate.values
            effect = candidate.active.effect
            if not effect.moves and progress.is_rounding(effect.joint, size):
                continue
            found.setdefault((candidate.active.effect.key, candidate.active.trial, round(time, 1)), candidate)
    return list(found.values())


def _with_seconds(progress: Progress, refitted: Sequence[_Refitted]) -> list[_Refitted]:
    """Return refits of the effects that explain most of the fit, each with a second one.

    Where two effects are missing, one alone is biased by the other and predicts badly.
    """
    current = progress.current
    if current.fit.rmse() < thresholds.ABOVE_NOISE * progress.noise:
        return []
    strong = [
        (attempt.fit.rmse(), first, attempt)
        for (first,), attempt in refitted
        if not (first.active.effect.at_an_instant or attempt.at_limit(len(current.model.effects)))
        and (gained := change(current, attempt)).fit > thresholds.least_gain(gained.freedom)
    ]
    strong.sort(key=lambda found: found[0])
    firsts = {id(attempt): first for _, first, attempt in strong[:_STRONGEST]}
    seconds = [
        (attempt, (second,))
        for _, _, attempt in strong[:_STRONGEST]
        for second in promising(attempt, ScoreTest(attempt.fit, addable(attempt.model, with_states=False)), _SECONDS)
    ]
    joined = progress.tried_on(seconds, may_win=partial(may_be_accepted, current))
    return [((firsts[id(before)], *second), attempt) for before, second, attempt in joined]


def _tried(progress: Progress, additions: Iterable[tuple[Candidate, ...]]) -> list[_Refitted]:
    """Return refits of the present model with each of some additions; those not accepted anyway are not predicted."""
    current = progress.current
    return progress.tried(current, additions, may_win=partial(may_be_accepted, current))


def _best(progress: Progress, refitted: Sequence[_Refitted]) -> Attempt | None:
    current, limit = progress.current, thresholds.ABOVE_NOISE * progress.noise
    accepted = [a for _, a in refitted if is_accepted(current, a)]
    if not accepted:
        return None
    levels = [min(fit.squared_error for fit in of_all) for of_all in zip(*map(fits_of, accepted), strict=True)]

    def error(attempt: Attempt) -> float:
        return sum(fit.squared_error / level for fit, level in zip(fits_of(attempt), levels, strict=True))

    def simplest(attempts: Sequence[Attempt]) -> list[Attempt]:
        return sorted(attempts, key=lambda a: (len(a.fit.values), error(a)))

    if complete := [a for a in accepted if all(fit.rmse() < limit for fit in fits_of(a))]:
        # Where one leaves only noise, no other is missing, and what it gains over a simpler one is its own.
        best, *others = simplest(complete)
        for other in others:
            best = other if is_better(other, best) else best
        return best
    # The simplest of those that come near the best: while other effects are still missing, what an effect with
    # more parameters gains over a simpler one is mostly theirs. The exchange at the end sets it right if not.
    most = max(error(current) - error(a) for a in accepted)
    return simplest([a for a in accepted if error(current) - error(a) >= thresholds.NEAR_THE_BEST * most])[0]


def _note(progress: Progress, best: Attempt | None, refitted: Sequence[_Refitted]) -> None:
    current = progress.current

    def tried_with(candidates: Sequence[Candidate], after: Attempt) -> Tried:
        keys, gained = tuple(candidate.active.effect.key for candidate in candidates), change(current, after)
        error = after.validation.rmse() if after.is_predicted else math.nan
        return Tried(keys, after.fit.rmse(), error, gained.fit, gained.freedom, gained.bic)

    tried = [tried_with(*each) for each in refitted]
    tried.sort(key=lambda of: (math.isnan(of.rmse_validation), of.rmse_validation, of.rmse_fit))
    added = [e.effect.key for e in best.model.effects[len(current.model.effects) :]] if best else []
    chosen = best or current
    action = f"added {' and '.join(added)}" if best else "nothing more helps"
    before_and_after = f"{1e3 * current.validation.rmse():.3g} -> {1e3 * chosen.validation.rmse():.3g} mrad"
    progress.note(action, chosen, f"{action}: {before_and_after} in cross-validation", tried)

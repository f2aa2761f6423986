"""Exchange steps: every effect has to stand against its rivals, under the model that has all the others."""

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.effects.effect import Effect, TorqueEffect
from cdp_ident.tracing.acceptance import brings_enough, earns_its_place
from cdp_ident.tracing.candidates import ScoreTest, addable
from cdp_ident.tracing.evidence import Attempt, change
from cdp_ident.tracing.progress import Progress, without_effects
from cdp_ident.tracing.screening import promising

_RIVALS = 3
"""Effects that each one has to stand against."""
_SHAPES = (0.3, 1.0, 4.0)
"""A richer form is begun with its parameters of shape at so many times what is typical."""
_SOME = 0.3
"""And with a strength that it has besides at that share of the strength of the simpler one."""
_INDISTINGUISHABLE = 9.0
"""Models whose squared errors differ by less, in variances, are both possible."""


def exchange_effects(progress: Progress) -> bool:
    """Let every effect, and every two torques of a joint, stand against their rivals; return whether one lost.

    Raises:
        InterruptedSelectionError: the selection is asked to stop.
    """
    before = progress.current
    for old in before.model.labels:
        current = progress.current
        if old not in current.model.labels:
            continue  # another of its kind was exchanged
        removed = without_effects(current, [current.place_of(old)])
        rivals = _rivals(progress, removed, old)
        progress.rivals[old] = tuple(rivals)
        _exchange(progress, removed, rivals, old)
    model = progress.current.model
    torques = [
        (label, active.effect.joint)
        for label, active in zip(model.labels, model.effects, strict=True)
        if isinstance(active.effect, TorqueEffect)
    ]
    for (one, joint), (two, other_joint) in combinations(torques, 2):
        current = progress.current
        if joint == other_joint and {one, two} <= set(current.model.labels):
            removed = without_effects(current, [current.place_of(one), current.place_of(two)])
            _exchange(progress, removed, _rivals(progress, removed, one, two), f"{one} and {two}")
    return progress.current is not before


def alternatives(
    active: ActiveEffect, current: Attempt, removed: Attempt, rivals: Sequence[Attempt]
) -> tuple[str, ...]:
    """Return the rivals that the data cannot tell from the effect whose place they took.

    Args:
        active: the effect.
        current: the model with it.
        removed: the model without it.
        rivals: models with another effect in its place.
    """
    named = {(active.effect.name, active.effect.joint) for active in current.model.effects}
    found = []
    for rival in rivals:
        effect = rival.model.effects[-1].effect
        if _is_richer_form(effect, active.effect):
            continue
        worse = change(rival, current)
        close = worse.validation < _INDISTINGUISHABLE
        if close and (effect.name, effect.joint) not in named and earns_its_place(removed, rival):
            found.append(f"{effect.name} {effect.joint}")
    return tuple(dict.fromkeys(found))


def _rivals(progress: Progress, removed: Attempt, *keys: str) -> list[Attempt]:
    """Return the models that have another effect in the place of some.

    They are those whose score test comes near theirs, and the richer forms of each.
    """
    test = ScoreTest(removed.fit, addable(removed.model))
    candidates = promising(removed, test, _RIVALS + len(keys), keys)
    others = progress.tried(removed, ((c,) for c in candidates if c.active.effect.key not in keys))
    richer = [rival for key in keys for rival in _richer(progress, key)] if len(keys) == 1 else []
    return [*(rival for _, rival in others), *richer]


def _richer(progress: Progress, key: str) -> list[Attempt]:
    """Return models that have a richer form of an effect in its place, begun where the effect is.

    From the model without the effect, as a score test looks, a richer form may be out of reach, or not be defined.
    """
    current = progress.current
    index = current.place_of(key)
    active, values = current.model.effects[index], current.fit.values[current.model.places(index)]
    known = {p.name: float(value) for p, value in zip(active.fitted, values, strict=True)}
    found = []
    for form in CATALOGUE:
        if form.at_an_instant or not _is_richer_form(form, active.effect):
            continue
        new = ActiveEffect(form)
        for factor in _SHAPES:
            begin = [
                known.get(p.name, factor * p.typical if p.shape else _SOME * max(known.values())) for p in new.fitted
            ]
            found += progress.replaced(current, index, new, np.clip(begin, *_limits(new)))
    return found


def _limits(active: ActiveEffect) -> tuple[list[float], list[float]]:
    return [p.lower for p in active.fitted], [p.upper for p in active.fitted]


def _exchange(progress: Progress, removed: Attempt, rivals: Sequence[Attempt], old: str) -> None:
    """Take the best of the rivals that are better than what they replace, if there is one."""
    current = progress.current
    better = [rival for rival in rivals if _is_better(rival, current) and earns_its_place(removed, rival)]
    if better:
        best = progress.finished(min(better, key=lambda rival: change(removed, rival).bic))
        new = best.model.effects[-1].effect.key
        progress.current = best
        progress.note(f"exchanged {old} for {new}", best, f"{new} explains the motion better than {old}")


def _is_better(rival: Attempt, current: Attempt) -> bool:
    gained = change(current, rival)
    fewer = len(rival.model.effects) < len(current.model.effects)
    if len(rival.fit.values) > len(current.fit.values) and not fewer:
        return gained.bic < 0 and brings_enough(current, rival)  # what is richer must earn its parameters
    return gained.bic < 0 and gained.validation > _INDISTINGUISHABLE


def _is_richer_form(effect: Effect, other: Effect) -> bool:
    """Return whether an effect is another one of the same joint with more to it, and so can always stand for that."""
    return isinstance(effect, TorqueEffect) and (effect.joint, effect.contains) == (other.joint, other.name)

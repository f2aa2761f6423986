"""Whether what stands in the place of an effect, or of two, is better than it."""

import math

from cdp_ident.model.effects.effect import Effect
from cdp_ident.tracing import thresholds
from cdp_ident.tracing.acceptance import (
    fit_gains_by_more_than_chance,
    gains_by_more_than_chance,
    improves_enough,
)
from cdp_ident.tracing.candidates import ScoreTest, addable
from cdp_ident.tracing.evidence import Attempt, change
from cdp_ident.tracing.noise_memory import is_structured


def is_better(rival: Attempt, current: Attempt) -> bool:
    """Return whether a model that has something else in the place of effects is better by more than chance.

    By Bayes's information criterion; beside that, another choice of effects must predict better, and one with more
    values gain enough for them. What an effect contains is better where it explains as much.
    """
    if not may_be_better(rival, current):
        return False
    if _is_richer_model(rival, current):
        # A richer form must gain enough for its parameters.
        return improves_enough(current, rival) or (
            gains_by_more_than_chance(change(current, rival)) and _gains_by_itself(rival, current)
        )
    return is_simpler(rival, current) or change(current, rival).validation > thresholds.INDISTINGUISHABLE


def may_be_better(rival: Attempt, current: Attempt) -> bool:
    """Return the same before anything is predicted: false where the fit alone rules it out."""
    gained = change(current, rival)
    if _is_richer_model(rival, current):
        return gained.bic < 0 and fit_gains_by_more_than_chance(gained)
    choices = 0.0 if is_simpler(rival, current) else _choices(rival) - _choices(current)
    return gained.bic + choices < 0


def _is_richer_model(rival: Attempt, current: Attempt) -> bool:
    """Return whether a rival has more values, and not in the place of more effects."""
    fewer = len(rival.model.effects) < len(current.model.effects)
    return len(rival.fit.values) > len(current.fit.values) and not fewer


def is_simpler(rival: Attempt, current: Attempt) -> bool:
    """Return whether a rival has what an effect contains in its place, or fewer values than one at its limit.

    At the limit of a shape parameter an effect has become something simpler. A model with more effects never is.
    """
    if len(rival.model.effects) > len(current.model.effects):
        return False
    new, replaced = rival.model.effects[-1].effect, _replaced(rival, current)
    if len(rival.fit.values) < len(current.fit.values) and any(map(current.at_limit, replaced)):
        return True
    return any(is_richer_form(current.model.effects[index].effect, new) for index in replaced)


def _gains_by_itself(rival: Attempt, current: Attempt) -> bool:
    """Return whether what a rival gains can only be due to the richer form that it has in the place of an effect.

    Then it may be a small share of the error. Only noise remains, and no effect that is missing, though too weak to be
    added, would gain nearly as much. What brings states of its own gains by their initial values, too.
    """
    new = rival.model.effects[-1].effect
    replaced = [current.model.effects[index].effect for index in _replaced(rival, current)]
    if new.brings_states or is_structured(rival.fit) or not any(is_richer_form(new, effect) for effect in replaced):
        return False
    fall = current.fit.squared_error - rival.fit.squared_error
    missing = ScoreTest(current.fit, addable(current.model, with_states=False)).ranked()
    return all(candidate.gain < thresholds.NEAR_A_RIVAL * fall for candidate in missing)


def _replaced(rival: Attempt, current: Attempt) -> list[int]:
    """Return the indices of the effects that a rival does not have."""
    return [index for index, active in enumerate(current.model.effects) if active not in rival.model.effects]


def _choices(attempt: Attempt) -> float:
    """Return what the choice of so many effects counts in the extended Bayes information criterion.

    All models with as many share one prior probability (Chen and Chen, Biometrika 95, 2008).
    """
    return 2.0 * math.log(math.comb(thresholds.forms(), len(attempt.model.effects)))


def is_richer_form(effect: Effect, other: Effect) -> bool:
    """Return whether an effect contains another one of the same joint as a special case."""
    return effect.moves and (effect.joint, effect.contains) == (other.joint, other.name)

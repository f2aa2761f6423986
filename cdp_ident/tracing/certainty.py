# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How sure the names of effects are: their share of the probability of all models that were fitted.

A rig may have an effect that is not in the catalogue, and one that is may imitate a part of it. So a name is sure only
where little torque is left that no law gives, too.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.special import softmax

from cdp_ident.arrays import Array
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.likelihood.whole_swing import WholeSwings
from cdp_ident.model.effects.effect import Effect
from cdp_ident.tracing.model_search import SEVERAL, ModelSearch
from cdp_ident.tracing.neighbours import strength
from cdp_ident.tracing.odds import NOT_DISTINGUISHED, unlikelihood
from cdp_ident.tracing.selection import Certainty, Selection

_Name = tuple[str, str, int | None]
"""Name and joint of an effect, and of a difference the trial."""

NAMED, PROBABLE = 0.95, 0.7
"""Probability from which on a name is said, and from which on it is said to be probable."""
_REST = 0.2
"""Share of the mean square beyond noise that an effect may leave where more remains: one that imitates what the
catalogue lacks leaves a quarter of it or more."""


def probabilities(search: ModelSearch) -> tuple[float, ...]:
    """Return for each effect of the best model the probability that it is there, in whatever form.

    Models that were refused, as they leave what is missing as it was, have no part in it.
    """
    others = [found for found in search.fitted.values() if found is not search.best and search.cost(found) >= 0.0]
    models = [search.best, *others]
    weights = softmax([-0.5 * search.cost(found) for found in models])
    counts = [Counter(_name(active) for active in found.model.effects) for found in models]
    return tuple(
        float(sum(weight for weight, there in zip(weights, counts, strict=True) if there[name] >= place))
        for name, place in _places(search.best)
    )


def _places(found: WholeSwings) -> list[tuple[_Name, int]]:
    """Return each effect's name, and which one it is of those with that name: 1 is the one that is shown best.

    Of several knocks or harmonics the second is there only where there are two.
    """
    names = [_name(active) for active in found.model.effects]
    shown = [strength(found.model, found.values, found.covariance, index) for index in range(len(names))]
    return [
        (name, sum(other == name and by > own for other, by in zip(names, shown, strict=True)) + 1)
        for name, own in zip(names, shown, strict=True)
    ]


def not_distinguished(search: ModelSearch) -> tuple[tuple[str, ...], ...]:
    """Return for each effect of the best model the keys of those that may be in its place as well."""
    best = search.best.model.effects
    found = []
    for active in best:
        others = [(one.effect.key, one.trial) for one in best if one != active]
        alternatives = dict[_Name, tuple[float, str]]()
        for model in search.fitted.values():
            instead = [one for one in model.model.effects if (one.effect.key, one.trial) not in others]
            if len(instead) != 1 or len(model.model.effects) != len(best) or _name(instead[0]) == _name(active):
                continue
            behind = search.cost(model)
            if behind < NOT_DISTINGUISHED and not instead[0].effect.curve:
                name = _name(instead[0])
                alternatives[name] = min(alternatives.get(name, (np.inf, "")), (behind, instead[0].effect.key))
        found.append(tuple(key for _, key in sorted(alternatives.values())))
    return tuple(found)


def certainties(
    search: ModelSearch,
    probability: Sequence[float],
    also_possible: Sequence[Sequence[str]],
) -> tuple[Certainty, ...]:
    """Return how sure the name of each effect of the best model is.

    Args:
        search: where it ended.
        probability: of each.
        also_possible: keys of the effects that may be in its place.
    """
    found = list[Certainty]()
    for index, active in enumerate(search.best.model.effects):
        if active.effect.curve or _stands_for_more(active.effect, search.best.model):
            found.append("acts_like")
        elif also_possible[index]:
            found.append("probable")
        else:
            p = probability[index]
            found.append("named" if p >= NAMED else "probable" if p >= PROBABLE else "acts_like")
    return tuple(found)


def _stands_for_more(effect: Effect, model: MotionModel) -> bool:
    """Return whether an effect is one of so many of its kind in a joint that they stand for something else.

    More torques over the joint's angle than a few harmonics are a curve, and more knocks than a few another motion.
    """
    kind = effect.joint, effect.of_angle, effect.at_an_instant
    same = [a for a in model.effects if (a.effect.joint, a.effect.of_angle, a.effect.at_an_instant) == kind]
    return any(kind[1:]) and sum(len(active.fitted) for active in same) > 2 * SEVERAL


def shown_by(selection: Selection, values: Array, covariance: Array) -> Selection:
    """Return a selection in which no name is sure whose effect the final values do not show, by the odds against it.

    Args:
        selection: with effects.
        values: (unknowns,) of all that was measured.
        covariance: (unknowns, unknowns) of these.
    """
    found = selection.after
    shown = [
        strength(found.model, values, covariance, index) > unlikelihood(active, found.recorded)
        for index, active in enumerate(found.model.effects)
    ]
    return _sure_only(selection, shown)


def where_more_remains(selection: Selection, error: float, without: Sequence[float], noise: float) -> Selection:
    """Return a selection whose names are less sure: each may be a part of what the catalogue lacks.

    None is more than probable, and none beside which more than a share remains of what is left of the held-out motion
    without it.

    Args:
        selection: with effects, beside which more than noise remains.
        error: of its model over what was held out [rad].
        without: the same without each effect; not a number where it cannot be computed.
        noise: the encoders' [rad].
    """
    remains = error**2 - noise**2
    less_sure: dict[Certainty, Certainty] = {"named": "probable", "probable": "acts_like", "acts_like": "acts_like"}
    weaker = replace(selection, certainty=tuple(less_sure[one] for one in selection.certainty))
    return _sure_only(weaker, [not remains > _REST * (other**2 - noise**2) for other in without])


def _sure_only(selection: Selection, where: Sequence[bool]) -> Selection:
    kept = zip(selection.certainty, where, strict=True)
    return replace(selection, certainty=tuple(one if sure else "acts_like" for one, sure in kept))


def _name(active: ActiveEffect) -> _Name:
    return active.effect.name, str(active.effect.joint), active.trial if active.is_difference else None

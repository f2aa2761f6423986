# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects that the motion neither shows nor excludes, and how uncertain they make a model's values.

An interval states what the chosen model leaves open, as if the choice were sure. An effect that is too weak to be
shown still has a part in the motion, which the other values imitate: dry friction makes viscous friction larger than
it is. So an effect that is significant by itself, though not among all that could be there, counts with the weight
that Akaike's information criterion gives it beside the chosen model: by how far it would move each value, and by how
much less certain it would make it (Buckland, Burnham and Augustin, Biometrics 53, 1997; Burnham and Anderson, Model
Selection and Multimodel Inference, 2002, section 4.3).
"""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import chdtrc, softmax

from cdp_ident.arrays import Array
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.likelihood.scores import Score

_LEVEL = 0.05
"""Probability that chance alone gains so much, of one effect that is in doubt."""


@dataclass(frozen=True)
class InDoubt:
    """An effect that the motion neither shows nor excludes."""

    active: ActiveEffect
    weight: float
    """Its share of the weights of all models, the chosen one's among them."""
    change: Array
    """(unknowns,) by how much it would change the chosen model's values."""
    spread: Array
    """(unknowns, unknowns) what its own uncertainty would add to the covariance of these."""


def effects_in_doubt(scored: Sequence[Score]) -> tuple[InDoubt, ...]:
    """Return the effects that a model may lack, the most likely first.

    Args:
        scored: what each effect that it does not have would do for it.
    """
    # What is the best of many instants, or of many periods, gains that much by chance.
    effects = [(score, score.active.effect) for score in scored]
    single = [score for score, effect in effects if not (effect.at_an_instant or effect.repeats or effect.curve)]
    doubtful = [score for score in single if chdtrc(score.freedom, score.gain) < _LEVEL]
    forms = Counter(_place(score) for score in doubtful)
    # The forms of one effect, such as harmonics, have the weight of one together.
    evidence = [0.5 * score.gain - score.freedom - math.log(forms[_place(score)]) for score in doubtful]
    weights = softmax([0.0, *evidence])[1:].tolist()
    found = [InDoubt(of.active, weight, of.change, of.spread) for of, weight in zip(doubtful, weights, strict=True)]
    return tuple(sorted(found, key=lambda effect: -effect.weight))


def _place(score: Score) -> tuple[str, str]:
    return score.active.effect.name, score.active.effect.joint


def added_covariance(in_doubt: Sequence[InDoubt]) -> Array | float:
    """Return what effects in doubt add to the covariance (unknowns, unknowns) of a model's values; 0 without any."""
    return sum(effect.weight * (effect.spread + np.outer(effect.change, effect.change)) for effect in in_doubt)

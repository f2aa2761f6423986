"""Backward steps: what no longer earns its place is dropped."""

import numpy as np

from cdp_ident.fit.motion_model import ActiveEffect
from cdp_ident.model.effects.effect import TorqueEffect
from cdp_ident.model.effects.friction import UNEVENNESS
from cdp_ident.tracing.acceptance import (
    KNOCK_ALONE,
    WORTH_NAMING,
    WORTH_NAMING_WITH_OTHERS,
    is_uneven,
    share_explained,
    still_helps,
)
from cdp_ident.tracing.candidates import Candidate
from cdp_ident.tracing.evidence import Attempt
from cdp_ident.tracing.instants import instants
from cdp_ident.tracing.selection import Progress, Rubbing, without_effects

_SAFE = 10.0
"""Strength above which an effect is not asked again whether it helps."""
_DRY_FRICTION = ("coulomb_friction", "stribeck_friction")


def drop_superfluous(progress: Progress, attempt: Attempt) -> Attempt:
    """Return a model without the effects that no longer help now that its last one is there."""
    for index in reversed(range(len(attempt.model.effects) - 1)):
        if attempt.strength(index) > _SAFE:
            continue
        removed = without_effects(attempt, [index])
        if not still_helps(attempt, removed):
            key = attempt.model.effects[index].effect.key
            attempt = removed
            _note(progress, key, attempt, "it no longer helps")
    return attempt


def drop_repeated_impulses(progress: Progress) -> None:
    """Drop an impulse beside which others would explain something too: what happens again and again is none."""
    for index in reversed(range(len(progress.current.model.effects))):
        current = progress.current
        effect = current.model.effects[index].effect
        if not (isinstance(effect, TorqueEffect) and effect.at_an_instant):
            continue
        removed = without_effects(current, [index])
        gain = removed.fit.squared_error - current.fit.squared_error
        if any(gain < KNOCK_ALONE * another.gain for another in instants(current.fit)):
            progress.current = removed
            _note(progress, effect.key, removed, "knocks at other instants would explain something, too")


def drop_uneven_friction(progress: Progress) -> None:
    """Drop dry friction that is there over a part of the turn only: something rubs, which is no such effect.

    Raises:
        InterruptedSelectionError: the selection is asked to stop.
    """
    for active in progress.current.model.effects:
        current, effect = progress.current, active.effect
        if effect.name not in _DRY_FRICTION:
            continue
        index = current.place_of(effect.key)
        variation = next(varied for varied in UNEVENNESS if varied.joint == effect.joint)
        uneven = progress.with_effects(current, [Candidate(ActiveEffect(variation), 0.0, np.zeros(2))])
        if is_uneven(current, uneven, index):
            sine, cosine = uneven.fit.values[uneven.model.places(len(uneven.model.effects) - 1)]
            progress.rubbing.append(Rubbing(effect.joint, float(np.arctan2(sine, cosine))))
            progress.current = without_effects(current, [index])
            _note(progress, effect.key, progress.current, "it is there over a part of the turn only")


def keep_what_explains(progress: Progress) -> list[Attempt]:
    """Drop effects that explain too little beside what remains: they may be a part of that, imitated.

    One that happened once has its window, which is looked at instead.

    Returns:
        The model without each of the effects that stay.
    """
    while True:
        current = progress.current
        indices = range(len(current.model.effects))
        without = [without_effects(current, [index]) for index in indices]
        explained = {
            index: share_explained(current, without[index], progress.noise)
            for index in indices
            if not current.model.effects[index].effect.at_an_instant
        }
        weak = [index for index, share in explained.items() if share < WORTH_NAMING]
        if not weak:
            return without
        least = min(weak, key=explained.__getitem__)
        if len(weak) > 1 and explained[least] > WORTH_NAMING_WITH_OTHERS:
            together = share_explained(current, without_effects(current, weak), progress.noise)
            if together > WORTH_NAMING:
                return without
        key = current.model.effects[least].effect.key
        progress.current = without[least]
        _note(progress, key, progress.current, "it explains too little beside what remains")


def _note(progress: Progress, key: str, after: Attempt, reason: str) -> None:
    progress.note(f"dropped {key}", after, f"dropped {key}: {reason}")

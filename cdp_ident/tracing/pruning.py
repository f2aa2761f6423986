"""Backward steps: what no longer earns its place is dropped."""

import numpy as np

from cdp_ident.fit.motion_model import ActiveEffect
from cdp_ident.model.effects.effect import TorqueEffect
from cdp_ident.model.effects.friction import UNEVENNESS
from cdp_ident.tracing.acceptance import (
    KNOCK_ALONE,
    is_uneven,
    still_helps,
)
from cdp_ident.tracing.candidates import Candidate
from cdp_ident.tracing.evidence import Attempt
from cdp_ident.tracing.instants import instants
from cdp_ident.tracing.selection import Progress, Rubbing, without_effects

_SAFE = 10.0
"""Strength above which an effect is not asked again whether it helps."""
DRY_FRICTION = ("coulomb_friction", "stribeck_friction")


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


def find_uneven_friction(progress: Progress) -> None:
    """Note dry friction that is there over a part of the turn only: something rubs, which only acts like it.

    Raises:
        InterruptedSelectionError: the selection is asked to stop.
    """
    current = progress.current
    for index, active in enumerate(current.model.effects):
        effect = active.effect
        if effect.name not in DRY_FRICTION:
            continue
        variation = next(varied for varied in UNEVENNESS if varied.joint == effect.joint)
        candidate = Candidate(ActiveEffect(variation), 0.0, np.zeros(2))
        for _, uneven in progress.tried(current, [(candidate,)]):
            if is_uneven(current, uneven, index):
                sine, cosine = uneven.fit.values[uneven.model.places(len(uneven.model.effects) - 1)]
                progress.rubbing.append(Rubbing(effect.joint, float(np.arctan2(sine, cosine))))


def _note(progress: Progress, key: str, after: Attempt, reason: str) -> None:
    progress.note(f"dropped {key}", after, f"dropped {key}: {reason}")

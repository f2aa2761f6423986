"""What no longer earns its place goes; what does stays."""

import numpy as np

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.tracing.candidates import Candidate
from cdp_ident.tracing.progress import Progress
from cdp_ident.tracing.pruning import drop_superfluous


def with_effects(plain, *keys):
    """Return the model with effects added one after the other."""
    attempt, told = plain, []
    progress = Progress(plain, 5e-4, told.append)
    for key in keys:
        effect = next(effect for effect in CATALOGUE if effect.key == key)
        typical = np.array([parameter.typical for parameter in effect.parameters if not parameter.shape])
        ((_, attempt),) = progress.tried(attempt, [(Candidate(ActiveEffect(effect), 0.0, typical),)])
    return progress, progress.finished(attempt), told


def keys_of(attempt):
    return [active.effect.key for active in attempt.model.effects]


def test_an_effect_that_another_makes_superfluous_is_dropped_and_it_is_told(plain):
    progress, both, told = with_effects(plain, "air_drag.outer.rotation", "joint_spring.outer")
    kept = drop_superfluous(progress, both)
    assert keys_of(kept) == ["joint_spring.outer"]
    assert told == ["dropped air_drag.outer.rotation: it no longer helps"]
    assert kept.validation.rmse() < 1.01 * both.validation.rmse()


def test_an_effect_that_helps_stays_whatever_comes_after_it(plain):
    progress, both, told = with_effects(plain, "joint_spring.outer", "air_drag.outer.rotation")
    assert keys_of(drop_superfluous(progress, both)) == ["joint_spring.outer", "air_drag.outer.rotation"]
    assert told == []

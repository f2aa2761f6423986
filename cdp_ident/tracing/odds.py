# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How unlikely an effect is before any trial: the odds against it that the evidence has to outweigh."""

import math

import numpy as np

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.likelihood.whole_swing import Recorded, WholeSwings
from cdp_ident.model.effects.catalogue import known_effects

_AGAINST = 150.0
"""Odds against an effect that is looked for: of some fifty, a rig has one or none in most joints."""
NOT_DISTINGUISHED = 6.0
"""Models whose costs differ by less are not distinguished: odds of 20."""
_IMITATED = 0.1
"""Share of a missing torque's mean square that an effect imitates by chance: a torque that goes with the state has some
ten degrees of freedom, however long it is looked at."""


def log10_odds(misfit: float) -> float:
    """Return the decimal logarithm of the odds of a model whose misfit is by so much larger than another one's."""
    return -misfit / (2.0 * math.log(10.0))


def unlikelihood(active: ActiveEffect, recorded: Recorded) -> float:
    """Return twice the logarithm of the odds against an effect."""
    return 2.0 * math.log(_AGAINST) + ambiguity(active, recorded)


def ambiguity(active: ActiveEffect, recorded: Recorded) -> float:
    """Return twice the logarithm of how many effects share the odds of one.

    What happens at an instant may happen at any, and any trial may differ from the others; harmonics of a turn are one
    effect. A nonparametric torque is as unlikely as two effects that have one.
    """
    effect, forms = active.effect, _AGAINST ** (_size(active) - 1)
    if effect.at_an_instant:
        forms = recorded.nodes
    elif active.trial is not None:
        forms = len(recorded.trials)
    elif effect.harmonic:
        forms = sum(one.harmonic and (one.name, one.joint) == (effect.name, effect.joint) for one in known_effects())
    return 2.0 * math.log(forms)


def unlikelihood_of(model: MotionModel, recorded: Recorded) -> float:
    """Return the same of all effects of a model, and of encoders whose zeros differ from trial to trial."""
    zeros = 2.0 * math.log(_AGAINST) if model.zeros else 0.0
    return zeros + sum(unlikelihood(active, recorded) for active in model.effects)


def cost(found: WholeSwings, than: WholeSwings) -> float:
    """Return twice the logarithm of how much less probable a model is than another one.

    Where torques are missing that no law gives, an effect may imitate a share of them. So what the larger of both
    models has more is to explain that share of the impulses that are still unknown: each is that much evidence.
    """
    more = size_of(found.model) - size_of(than.model)
    return cost_unless_imitated(found, than) + more * imitated(found if more > 0 else than)


def cost_unless_imitated(found: WholeSwings, than: WholeSwings) -> float:
    """Return the same as if effects imitated nothing of what is missing."""
    unlikely = unlikelihood_of(found.model, found.recorded) - unlikelihood_of(than.model, than.recorded)
    return found.misfit - than.misfit + unlikely


def imitated(found: WholeSwings) -> float:
    """Return by how much an effect makes a model's misfit smaller by chance, where torques are missing."""
    return _IMITATED * float(np.sum(found.freedom[found.is_missing]))


def _size(active: ActiveEffect) -> int:
    """Return as how many effects one counts: a nonparametric torque as two."""
    return 2 if active.effect.curve else 1


def size_of(model: MotionModel) -> int:
    """Return how many effects a model has; zeros of each trial count as one."""
    return bool(model.zeros) + sum(map(_size, model.effects))

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects that are suggested where more than noise is left, as scores say too little of them."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import combinations, islice

import numpy as np
from numpy.typing import ArrayLike

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.likelihood.prior import typical
from cdp_ident.likelihood.scores import SHAPES
from cdp_ident.likelihood.whole_swing import WholeSwings
from cdp_ident.model.effects.catalogue import known_effects
from cdp_ident.model.effects.effect import JOINTS, Effect, Joint
from cdp_ident.tracing.missing_torque import MissingTorque
from cdp_ident.tracing.neighbours import Neighbour, beginnings_of, hides_more, with_one_more

_FREQUENCIES = 2.0 ** np.arange(-1, 5)
"""A mode of the base is looked for at so many times its typical frequency."""


def suggestions(found: WholeSwings) -> Iterator[Neighbour]:
    """Yield models with an effect that unknown torques, or autocorrelated noise, follow as well as it would."""
    if hides_more(found):
        torque = np.sqrt(np.mean(MissingTorque.of(found).torque ** 2, axis=0))
        missing: dict[Joint, float] = {
            joint: size for joint, size in zip(JOINTS, torque.tolist(), strict=True) if size > 0.0
        }
        yield from _that_hold(found, missing)
        yield from _with_states(found, missing)
        yield from _in_both_encoders(found)


def _that_hold(found: WholeSwings, missing: Mapping[Joint, float]) -> Iterator[Neighbour]:
    """Yield models with dry friction in a joint, or in both: near no strength it does not hold them most of the time.

    Args:
        found: a model.
        missing: torque of each joint in which one is missing, over A22.
    """
    dry = [e for e in known_effects() if e.dry and not e.contains and len(e.parameters) == 1 and e.joint in missing]
    for holding in (each for count in range(1, len(dry) + 1) for each in combinations(dry, count)):
        yield _with(found, holding, [missing[effect.joint] for effect in holding])


def _with_states(found: WholeSwings, missing: Mapping[Joint, float]) -> Iterator[Neighbour]:
    """Yield models with an effect that has states: their scores near no strength say too little.

    Play shows by jumps; a mode of the base, or of an encoder's elastic coupling, only where its frequency is right; and
    friction may give way so far that it is no dry friction.
    """
    unit = found.recorded.time_unit
    for effect in known_effects():
        begins, of_each = list[dict[str, float]](), len(SHAPES)
        if effect.law.cart and effect.states:
            (frequency,) = (p for p in ActiveEffect(effect).fitted if p.shape and p.begins)
            begins, of_each = [{frequency.name: f * typical(frequency, unit)} for f in _FREQUENCIES], 1
        elif effect.remembers and effect.joint in missing:
            begins = [{effect.parameters[0].name: missing[effect.joint]}]
        elif effect.states and not effect.moves and not any(p.begins for p in effect.parameters):
            begins = [{}]
        for known in begins:
            for values in islice(beginnings_of(found, known, effect), of_each):
                yield replace(with_one_more(found, ActiveEffect(effect), np.array(values)), again=True, unscored=True)


def _in_both_encoders(found: WholeSwings) -> Iterator[Neighbour]:
    """Yield models with filters, play or elastic couplings in both encoders: alike, they hardly show in one of them."""
    for pair in combinations([e for e in known_effects() if e.states and not e.moves], 2):
        if pair[0].law == pair[1].law:
            usual = [typical(p, found.recorded.time_unit) for effect in pair for p in ActiveEffect(effect).fitted]
            for factor in SHAPES:
                yield replace(_with(found, pair, factor * np.array(usual)), again=True, unscored=True)


def _with(found: WholeSwings, effects: Sequence[Effect], values: ArrayLike) -> Neighbour:
    """Return a model with several effects more."""
    model = found.model
    for effect in effects:
        model = model.with_effect(ActiveEffect(effect))
    return Neighbour(model, np.concatenate([found.values, values]), tuple(effect.key for effect in effects), found)

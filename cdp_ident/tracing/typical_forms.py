"""Richer forms of effects as large as they typically are: whether the motion would show them if they were there.

A richer form whose values are all fitted explains as much as what it contains even where it is nothing. So that it is
no better does not say that it is absent: a joint that is never slow shows nothing of a friction that is larger near
rest. Held at a typical size, it fits as well only where the motion does not show it.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.model.effects.effect import Effect, EffectParameter
from cdp_ident.tracing.exchange import richer_forms
from cdp_ident.tracing.progress import Progress


def try_typical_forms(progress: Progress) -> None:
    """Add to the rivals of each effect its richer forms, as large as they typically are, in its place.

    What they have in addition is held: it is as strong as the effect itself, with typical shape parameters. Those with
    states of their own are left out, for their initial values in each window imitate a part of anything.

    Raises:
        InterruptedSelectionError: the selection is asked to stop.
    """
    current = progress.current
    aside = progress.aside(lambda: False)  # what cannot be computed does not follow the motion
    for index, label in enumerate(current.model.labels):
        active, values = current.model.effects[index], current.fit.values[current.model.places(index)]
        known = {p.name: float(value) for p, value in zip(active.fitted, values, strict=True)}
        held = [ActiveEffect(_held(form, known)) for form in richer_forms(progress, label) if not form.brings_states]
        begun = [(form, np.array([known[parameter.name] for parameter in form.fitted])) for form in held]
        if begun:
            typical = aside.replaced(current, [index], begun, to_beat=current)
            progress.rivals[label] = (*progress.rivals.get(label, ()), *typical)


def _held(form: Effect, known: Mapping[str, float]) -> Effect:
    """Return a richer form of which only the values that its simpler form has are fitted."""

    def fitted_or_held(parameter: EffectParameter) -> EffectParameter:
        size = parameter.typical if parameter.shape else max(known.values())
        held = replace(parameter, lower=size, upper=size, typical=size)
        return parameter if parameter.name in known else held

    return replace(form, parameters=tuple(map(fitted_or_held, form.parameters)))

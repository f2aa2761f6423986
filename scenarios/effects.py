# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects of the catalogue, acting on the paper's pendulum."""

from collections.abc import Sequence

from cdp_ident.model.acting import ActingEffects
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.effects.effect import Effect

EFFECTS = {effect.key: effect for effect in CATALOGUE}


def typical(effect: Effect, instant: float = 0.0) -> list[float]:
    """Return typical values of an effect's parameters; one of an instant happens then [s]."""
    values = [parameter.typical for parameter in effect.parameters]
    return [values[0], instant, *values[2:]] if effect.at_an_instant else values


def acting(*chosen: tuple[str | Effect, Sequence[float]] | str, fitted: bool = False) -> ActingEffects:
    """Return effects, given as they are or by their keys, with values or with typical ones."""
    pairs = [each if isinstance(each, tuple) else (each, typical(EFFECTS[each])) for each in chosen]
    effects = [(EFFECTS[effect] if isinstance(effect, str) else effect, values) for effect, values in pairs]
    return ActingEffects.of(effects, 0.4, fitted=fitted)

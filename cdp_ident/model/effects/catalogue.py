# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The effects that are searched for. One added here is in the fit, the report, the simulation and ROS."""

from collections.abc import Sequence

from cdp_ident.model.effects.cart import CART
from cdp_ident.model.effects.curves import CURVES
from cdp_ident.model.effects.effect import Effect
from cdp_ident.model.effects.encoders import ENCODERS
from cdp_ident.model.effects.forces import FORCES
from cdp_ident.model.effects.friction import FRICTION

NAMED: tuple[Effect, ...] = (*FRICTION, *FORCES, *CART, *ENCODERS)
CATALOGUE: tuple[Effect, ...] = (*NAMED, *CURVES)
_own: dict[str, Effect] = {}


def known_effects() -> tuple[Effect, ...]:
    """Return the catalogue's effects, and the user's own that this process has read (`effects.own`)."""
    return (*CATALOGUE, *_own.values())


def add_own(effects: Sequence[Effect]) -> None:
    """Make a user's own effects known, in the place of those of the same names."""
    names = {effect.name for effect in effects}
    for key in [key for key, effect in _own.items() if effect.name in names]:
        del _own[key]
    _own.update({effect.key: effect for effect in effects})


def forget_own() -> None:
    """Know the catalogue's effects alone."""
    _own.clear()

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The equations of motion and laws as compiled code."""

from functools import cache

from cdp_ident.machine.calls import OF_LAW
from cdp_ident.machine.compilation import compiled_at, inlined
from cdp_ident.model.effects.catalogue import NAMED
from cdp_ident.model.effects.effect import Effect
from cdp_ident.model.formulas.generated import Generated, module_of
from cdp_ident.model.formulas.machine_code import Addresses, laws_in

_CATALOGUE = module_of(NAMED, paper=True)
pushes, slopes_of_paper = inlined(_CATALOGUE.pushes), inlined(_CATALOGUE.slopes_of_paper)
"""The paper's equations, and their derivatives; see `code`."""


def motion_law(effect: Effect, is_zero: bool = False) -> int:
    """Return the address of what an effect's law does to the motion, compiled; 0 where it does nothing.

    Of no strength it does nothing either, and there are only derivatives by its strengths.
    """
    if effect.curve is not None:
        return _of_curve(effect)
    return _address(effect, "MOTION_AT_ZERO" if is_zero and effect.known_at_zero else "MOTION")


def reading_law(effect: Effect, is_zero: bool = False) -> int:
    """Return the address of what it does to readings, likewise."""
    if effect.curve is not None:
        return 0
    return _address(effect, "READING_AT_ZERO" if is_zero and effect.known_at_zero else "READING")


@cache
def _of_curve(effect: Effect) -> int:
    assert effect.curve is not None
    assert effect.curve.law is not None
    return compiled_at(effect.curve.law, OF_LAW)


@cache
def _address(effect: Effect, table: str) -> int:
    module = _CATALOGUE if effect.key in _CATALOGUE.KEYS else module_of((effect,), paper=False)
    function = getattr(module, table).get(effect.key)
    return 0 if function is None else _addresses(module).of(function.__name__)


@cache
def _addresses(module: Generated) -> Addresses:
    return laws_in(module.text)

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The effects of an earlier report: which may be expected again, and what became of them."""

from collections.abc import Sequence

import numpy as np

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.model.effects.catalogue import known_effects
from cdp_ident.report.filling import Also
from cdp_ident.report.schema import Section
from cdp_ident.tracing.expected import ExpectedEffect
from cdp_ident.tracing.found_effects import FoundEffect

_NO_ESTIMATE = {"as_fitted": {"value": np.inf, "std": np.inf}}
"""Of a parameter that a report does not have."""


def expected_effects(report: Section) -> tuple[ExpectedEffect, ...]:
    """Return the effects of a report that may be expected again.

    Effects of one trial are left out, and so are nonparametric torques, whose shapes belong to their trials.
    """
    sections = {
        (section["name"], section["joint"], section["variant"]): section
        for section in report["effects"]
        if section["trial"] is None
    }
    found = []
    for effect in known_effects():
        section = sections.get((effect.name, effect.joint, effect.variant))
        if section is None or effect.curve is not None:
            continue
        fitted = [section["parameters"].get(p.name, _NO_ESTIMATE)["as_fitted"] for p in ActiveEffect(effect).fitted]
        values, std = (np.array([estimate[of] for estimate in fitted]) for of in ("value", "std"))
        if np.all(np.isfinite(values)):
            found.append(ExpectedEffect(effect, values, std))
    return tuple(found)


def compared(expected: Sequence[ExpectedEffect], found: Sequence[FoundEffect]) -> list[Also]:
    """Return what became of each effect that was expected, and which effects are new."""
    new = {effect.active.effect.key: effect for effect in found if not effect.active.is_difference}
    sections = []
    for before in expected:
        now = new.pop(before.effect.key, None)
        became = {"state": "confirmed" if now else "withdrawn", "parameters": _changes(before, now) if now else {}}
        sections.append(Also(before.effect, became))
    return [*sections, *(Also(now.active.effect, {"state": "new", "parameters": {}}) for now in new.values())]


def _changes(before: ExpectedEffect, now: FoundEffect) -> Section:
    shown, changes = {parameter.description.name: parameter for parameter in now.parameters}, {}
    for parameter, value, std in zip(ActiveEffect(before.effect).fitted, before.values, before.std, strict=True):
        new = shown[parameter.name]
        change, spread = abs(new.shown - value), np.hypot(std, new.shown_std)
        changes[parameter.name] = value, new.shown, change / spread if spread > 0.0 else 0.0
    return changes

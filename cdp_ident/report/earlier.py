"""Effects that are expected from an earlier report of the same rig, and what has changed since."""

from collections.abc import Sequence

import numpy as np

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.model.effects.catalogue import known_effects
from cdp_ident.model.effects.effect import Effect
from cdp_ident.report.formatting import number
from cdp_ident.report.schema import Section
from cdp_ident.tracing.expected import ExpectedEffect
from cdp_ident.tracing.found_effects import FoundEffect

_NO_ESTIMATE = {"as_fitted": {"value": None, "std": None}}
"""Of a parameter that a report does not have."""


def expected_effects(report: Section) -> tuple[ExpectedEffect, ...]:
    """Return the effects of a report that may be expected again.

    Effects of an instant are left out, and so are nonparametric torques, whose shapes belong to their trials.
    """
    sections = {(section["name"], section["joint"], section["variant"]): section for section in report["effects"]}
    found = []
    for effect in known_effects():
        section = sections.get((effect.name, effect.joint, effect.variant))
        if section is None or effect.at_an_instant or effect.curve is not None:
            continue
        fitted = [section["parameters"].get(p.name, _NO_ESTIMATE)["as_fitted"] for p in ActiveEffect(effect).fitted]
        values, std = (np.array([number(estimate[of]) for estimate in fitted]) for of in ("value", "std"))
        if np.all(np.isfinite(values)):
            found.append(ExpectedEffect(effect, values, std))
    return tuple(found)


def compared(expected: Sequence[ExpectedEffect], found: Sequence[FoundEffect]) -> list[Section]:
    """Return what became of each effect that was expected, and which effects are new."""
    by_key = {effect.active.effect.key: effect for effect in found}
    known = {expectation.effect.key for expectation in expected}
    return [
        *(
            _confirmed(e, by_key[e.effect.key]) if e.effect.key in by_key else _of(e.effect, "withdrawn")
            for e in expected
        ),
        *(_of(effect.active.effect, "new") for key, effect in by_key.items() if key not in known),
    ]


def _of(effect: Effect, state: str) -> Section:
    return {"name": effect.name, "joint": effect.joint, "variant": effect.variant, "state": state, "parameters": {}}


def _confirmed(before: ExpectedEffect, now: FoundEffect) -> Section:
    shown = {parameter.description.name: parameter for parameter in now.parameters}
    parameters = {}
    for parameter, value, std in zip(ActiveEffect(before.effect).fitted, before.values, before.std, strict=True):
        new = shown[parameter.name]
        spread = float(np.hypot(std, new.shown_std))
        parameters[parameter.name] = {
            "before": float(value),
            "now": new.shown,
            "deviations": abs(new.shown - float(value)) / spread if spread > 0.0 else 0.0,
        }
    return _of(before.effect, "confirmed") | {"parameters": parameters}

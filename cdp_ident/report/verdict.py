"""The result for people: one sentence, and each effect in words."""

import numpy as np

from cdp_ident.report.formatting import CERTAINTY, with_std
from cdp_ident.tracing.found_effects import FoundEffect, FoundParameter
from cdp_ident.tracing.trace import Trace

_NUMERALS = ("No", "One", "Two", "Three", "Four", "Five", "Six", "Seven", "Eight", "Nine")
_PREFIXES = ((1.0, ""), (1e-3, "m"), (1e-6, "µ"))


def verdict(trace: Trace) -> str:
    """Say what the motion shows beside the paper's model, how much of it that explains, and what remains."""
    if trace.failure:
        return f"{trace.failure[0].upper()}{trace.failure[1:]}."
    before, after = trace.before.holdout.rmse(), trace.after.holdout.rmse()
    milliradians = f"{1e3 * before:.3g} -> {1e3 * after:.3g} mrad"
    remains = trace.unexplained
    rest = "more than the encoders' noise remains" if remains.significant else "the rest is encoder noise"
    if not trace.effects:
        if not remains.significant:
            return f"The paper's model explains the motion: what it leaves, {1e3 * after:.3g} mrad, is encoder noise."
        return f"The paper's model leaves more than noise, {1e3 * after:.3g} mrad, and no known effect explains it."
    floor = float(np.mean(trace.completed.data.noise**2))
    share = 1.0 - max(after**2 - floor, 0.0) / max(before**2 - floor, np.finfo(float).tiny)
    count = len(trace.effects)
    subject = f"{effect_in_words(trace.effects[0])}, explains" if count == 1 else f"{_numeral(count)} effects explain"
    return (
        f"{subject} {100 * share:.0f} % of what the paper's model could not: {milliradians} on held-out motion; {rest}."
    )


def effect_in_words(found: FoundEffect) -> str:
    """Return an effect with its place and strength, and what else it may be."""
    words = _in_words(found)
    return f"{words[0].upper()}{words[1:]}"


def _numeral(count: int) -> str:
    return _NUMERALS[count] if count < len(_NUMERALS) else str(count)


def _in_words(found: FoundEffect) -> str:
    effect = found.active.effect
    if effect.joint == "base":
        place = ""
    elif not effect.moves and not effect.of_both_encoders:
        place = f" (the {effect.joint} encoder)"
    elif not effect.moves or (any(effect.law.torques) and not effect.uses_accelerations):
        place = f" ({effect.joint})"
    else:
        place = f" in the {effect.joint} joint"
    if found.curve:
        largest, at = found.parameters
        likeness = f", as {found.curve.likeness} would have" if found.curve.likeness else ""
        return f"{effect.description}{place}, up to {_with_unit(largest)} at {_with_unit(at)}{likeness}"
    strength = next((p for p in found.parameters if not p.description.shape and p.value != 0), found.parameters[0])
    alternatives = f" (or {' or '.join(found.also_possible)}, which the data do not distinguish from it)"
    named = f"{CERTAINTY[found.certainty]}{effect.description}{place}, {_with_unit(strength)}"
    return f"{named}{alternatives if found.also_possible else ''}"


def _with_unit(parameter: FoundParameter) -> str:
    unit = "" if parameter.description.unit == "1" else parameter.description.unit
    size = max(abs(parameter.value), parameter.std)
    takes_prefix = unit and not unit.startswith("k")
    factor, prefix = next(((f, p) for f, p in _PREFIXES if size >= f), _PREFIXES[-1]) if takes_prefix else (1.0, "")
    value, std = parameter.value / factor, parameter.std / factor
    return f"{with_std(value, std) if std else f'{value:.3g}'} {prefix}{unit}".rstrip()

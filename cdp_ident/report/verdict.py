# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The result for people: one sentence, and each effect in words."""

import re

from cdp_ident.fit.physical import CONFIDENCE
from cdp_ident.model.effects.effect import Effect
from cdp_ident.report.schema import Section
from cdp_ident.report.wording import CERTAINTY, capitalised, key_words, over_inertia, unit, with_std
from cdp_ident.tracing.final_model import is_worse
from cdp_ident.tracing.found_effects import FoundEffect, FoundParameter
from cdp_ident.tracing.trace import Trace
from cdp_ident.tracing.unexplained import errors_of_time

_NUMERALS = ("No", "One", "Two", "Three", "Four", "Five", "Six", "Seven", "Eight", "Nine")
_AS_NOISE = 1.5
"""An error of at most so many times the noise may be noise."""
_LEAST_SHARE, _NEARLY_ALL = 0.005, 0.9
"""Shares of what was to be explained from which on it is said, and from which on the rest may be noise."""
_MORE = 1.05
"""From so many times the noise on, that is said as a number."""
_PREFIXES = ((1.0, ""), (1e-3, "m"), (1e-6, "µ"))
_PREFIXED = re.compile(r"(?!k)[A-Za-z]+(?:\^(\d+))?(?= |/|$)")
"""How a unit begins before which a prefix may stand, and the power that is the prefix's, too."""


def verdict(trace: Trace) -> str:
    """Say what the motion shows beside the paper's model, how much of it that explains, and what remains."""
    if trace.failure:
        return f"{capitalised(trace.failure)}."
    effects, withdrawn = trace.effects, None if trace.effects else trace.withdrawn
    count = len(withdrawn.effects if withdrawn else effects)
    if withdrawn:
        subject = " and ".join(map(key_words, withdrawn.effects))
    else:
        numeral = _NUMERALS[count] if count < len(_NUMERALS) else str(count)
        subject = effect_in_words(effects[0]) if count == 1 else f"{numeral} effects"
        if count > 1 and all(effect.certainty == "acts_like" for effect in effects):
            subject += ", or what acts like them,"
    after = withdrawn.holdout if withdrawn else trace.after.holdout.rmse()
    noise, significant = trace.noise_level, trace.unexplained.significant
    why, late, before = "no known effect explains it", "", trace.before.holdout.rmse()
    if trace.selection is None:
        why = "effects could not be looked for"
    elif trace.whole and trace.whole.base_moves:
        why = "it is as if the base moved"
    if trace.whole:
        late = errors_of_time(trace.whole.noise.time)
    differs = [e for e in effects if e.active.is_difference]
    said = judgement(subject, count, before, after, noise, significant, why, late)
    if differs:
        which = " and ".join(sorted({_with_place(e.active.effect) for e in differs}))
        said += f" Trials differ from one another in {which}: the next one may differ, too."
    if effects and trace.withdrawn:
        left_out = " and ".join(map(key_words, trace.withdrawn.effects))
        said += f" Left out, as held-out motion is predicted worse with it: {left_out}."
    if any(over_inertia(quantity(parameter)) for effect in effects for parameter in effect.parameters):
        width = CONFIDENCE * trace.physical.inertia_std_once_weighed
        said += f" Torques in N m are known to ± {100.0 * width:.2g} % once the outer rod is weighed."
    return said


def judgement(
    subject: str,
    count: int,
    before: float,
    after: float,
    noise: float,
    significant: bool,
    why: str = "no known effect explains it",
    late: str = "",
) -> str:
    """Return a verdict in one sentence.

    Args:
        subject: the effect that was found, or how many were.
        count: of the effects that were found.
        before: error of the paper's model on held-out motion [rad].
        after: the same of the model with the effects [rad].
        noise: of the encoders [rad].
        significant: whether more than noise remains.
        why: what is said of it where the paper's model leaves more.
        late: what errors of time the noise has, in words.
    """
    times = after / noise
    is_noise = not significant and times <= _AS_NOISE
    as_noise = f"encoder noise and {late}" if late else "encoder noise"
    if not count:
        milliradians = f"{1e3 * after:.3g} mrad"
        if is_noise:
            return f"The paper's model explains the motion: what it leaves, {milliradians}, is {as_noise}."
        if significant:
            return f"The paper's model leaves more than noise, {milliradians}, and {why}."
        return f"The paper's model leaves {milliradians}, {times:.2g} times the encoders' noise, and {why}."
    changes = f"{1e3 * before:.3g} -> {1e3 * after:.3g} mrad on held-out motion"
    subject, was, does, s = (f"{subject},", "was", "does", "s") if count == 1 else (subject, "were", "do", "")
    if is_worse(after, before):
        return (
            f"{subject} {was} found, but {does} not carry over: {changes}. So the paper's model is kept; "
            f"{_rest(before / noise, significant)}."
        )
    explainable, left = before**2 - noise**2, max(after**2 - noise**2, 0.0)
    share = 1.0 - left / explainable if explainable > 0.0 else 0.0
    rest = f"the rest is {as_noise}" if is_noise else _rest(times, significant)
    if share < _LEAST_SHARE:
        return f"{subject} {was} found, but hardly matter{s} here: {changes}; {rest}."
    if share < _NEARLY_ALL:
        is_noise, rest = False, _rest(times, significant)
    per_cent = round(100.0 * share)
    # It is all only where nothing but noise is left.
    explained = "more than 99 %" if per_cent == 100 and not is_noise else f"{per_cent} %"
    return f"{subject} explain{s} {explained} of what the paper's model could not: {changes}; {rest}."


def _rest(times: float, significant: bool) -> str:
    if significant and times < _MORE:
        return "more than the encoders' noise remains"
    if times < _MORE:
        return "hardly more than the encoders' noise is left"
    more = ", more than chance" if significant else ""
    return f"{times:.2g} times the encoders' noise is left{more}"


def effect_in_words(found: FoundEffect) -> str:
    """Return an effect with its place and strength, and what else it may be."""
    effect, more = found.active.effect, found.active.is_difference
    what = f"{'more ' * more}{_with_place(effect)}{' in one trial' * more}"
    if found.curve:
        largest, at = found.parameters
        size = f", up to {_strength(largest)} at {_scaled(at)}" if _is_shown(largest) else ""
        likeness = f", as {found.curve.likeness} would have" if found.curve.likeness else ""
        return capitalised(f"{what}{size}{likeness}")
    strength = next((p for p in found.parameters if not p.description.shape and _is_shown(p)), None)
    named = f"{CERTAINTY[found.certainty]}{what}{f', {_strength(strength)}' if strength else ''}"
    others = " or ".join(map(key_words, found.also_possible))
    return capitalised(f"{named} (or {others}, which the data do not distinguish from it)" if others else named)


def _with_place(effect: Effect) -> str:
    if effect.joint == "base":
        place = ""
    elif not effect.moves and not effect.of_both_encoders:
        place = f" (the {effect.joint} encoder)"
    elif not effect.moves or (any(effect.law.torques) and not effect.uses_accelerations):
        place = f" ({effect.joint})"
    else:
        place = f" in the {effect.joint} joint"
    return f"{effect.description}{place}"


def _is_shown(parameter: FoundParameter) -> bool:
    """Return whether a value is more than zero as it is written."""
    return float(_scaled(parameter).split()[0]) != 0.0


def _strength(found: FoundParameter) -> str:
    """Return a value with its unit: over A22 first where no mass is known, and in the unit what that may be."""
    first = over_inertia(quantity(found))
    return f"{first} ({_scaled(found, guessed=True)}, give or take a factor of three)" if first else _scaled(found)


def quantity(found: FoundParameter) -> Section:
    """Return a parameter as `report.json` holds it."""
    as_fitted = {"value": found.shown, "std": found.shown_std}
    return {"value": found.value, "std": found.std, "unit": found.description.unit, "as_fitted": as_fitted}


def _scaled(found: FoundParameter, guessed: bool = False) -> str:
    """Write a value with its unit and a prefix that suits it, without its standard deviation where it is `guessed`."""
    symbol, std = unit(found.description.unit), 0.0 if guessed else found.std
    begins = _PREFIXED.match(symbol)
    power = int(begins[1] or 1) if begins else 0
    prefixes = [(factor**power, prefix) for factor, prefix in _PREFIXES[: 3 if power else 1]]
    factor, prefix = next(((f, p) for f, p in prefixes if max(abs(found.value), std) >= f), prefixes[-1])
    value = with_std(found.value / factor, std / factor) if std else f"{found.value / factor:.3g}"
    return f"{value} {prefix}{symbol}".rstrip()

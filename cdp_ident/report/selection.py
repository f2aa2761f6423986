# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The effects that the paper's model lacks: which were found, how they were chosen, and what else was looked for."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from cdp_ident.model.formulas.typesetting import Formula
from cdp_ident.report.document import Charts, Parts, Row, Sentences, Table
from cdp_ident.report.figures.description import Axis, Bars, Colour, Figure, Mark, Panel, beside, level, named, wrapped
from cdp_ident.report.schema import Section
from cdp_ident.report.wording import chance, effect_name, effect_title, key_words, milliradians, odds, quantity_words

_CERTAINTY = {"named": "named", "probable": "probable", "acts_like": "acts like it"}
_ALL = 0.95
"""From this share of the fitted motion on, effects were looked for in all of it."""
_MOST_CANDIDATES = 10
_ROOM = 27.0
"""Height of a bar with a name of two lines [pixels]."""
_ODDS = Axis("log10 of the odds")


def effects(report: Section, of_effects: Sequence[Figure]) -> Parts:
    """Return the chapter, given the figures of what the effects are drawn through."""
    found, selected = report["effects"], report["selection"]
    steps = list(enumerate(selected["steps"], start=1))
    tried = [(index, one) for index, step in steps for one in step["tried"]]
    looked_for = [
        (key_words(other["effect"]), odds(other["log10_odds"]), chance(other["probability"]))
        for other in selected["candidates"][:_MOST_CANDIDATES]
    ]
    others = [
        f"Instead of {effect_title(effect)} it could be {_others(effect)}: the trials do not distinguish them"
        for effect in found
        if effect["also_possible"]
    ]
    about = ("held out without → with [mrad]", "formula", "also possible")
    no_other = "No other effect could take the place of what was added, as far as the trials show"
    interrupted = ["The tracing was interrupted: there may be more to find"] if selected["interrupted"] else []
    return (
        Table(
            "Found and added",
            ("effect", "parameter", "value ± std", "how sure", *about),
            [row for effect in found for row in _parameters_of(effect)],
            wide=("formula",),
        ),
        Sentences.of([] if found else ["None was added"]),
        Sentences.of([f"What remains: {report['unexplained']['description']}"]),
        Sentences.of(expected_in_words(report), "Beside the earlier report"),
        Sentences.of(others or [no_other] if found else [], "What the trials do not distinguish"),
        Sentences.of(interrupted, noted=True),
        Sentences.of(share_words(report), noted=True),
        Sentences.of([] if steps else ["Effects were not looked for"]),
        Table(
            "Step by step",
            ("step", "what was done", "odds over the paper's model"),
            [(str(index), key_words(step["action"]), odds(step["log10_odds"])) for index, step in steps],
            at_terminal=False,
        ),
        Charts([*selection(report), *candidates(report)]),
        Table("What else was looked for", ("effect", "odds, were it added", "probability"), looked_for, folded=True),
        Table(
            "All that was tried",
            ("step", "effect", "odds over the model before"),
            [(str(index), effects_words(one["effects"]), odds(one["log10_odds"])) for index, one in tried],
            folded=True,
            at_terminal=False,
        ),
        Charts(of_effects, side_by_side=True),
    )


def _others(effect: Section) -> str:
    """Write what could stand in an effect's place; nothing where nothing could."""
    return " or ".join(map(key_words, effect["also_possible"]))


def _parameters_of(effect: Section) -> Iterator[Row]:
    """Yield an effect's parameters, the first with what is said of the effect."""
    evidence = effect["evidence"]
    held_out = (evidence["rmse_holdout_before_rad"], evidence["rmse_holdout_after_rad"])
    title, others = effect_title(effect), _others(effect) or "–"
    sure = f"{_CERTAINTY[effect['certainty']]}, {chance(evidence['probability'])}"
    about = [sure, " → ".join(map(milliradians, held_out)), Formula(effect["formula"]), others]
    for name, quantity in effect["parameters"].items():
        yield title, name, quantity_words(quantity), *about
        title, about = "", [""] * 4


def expected_in_words(report: Section) -> Iterator[str]:
    """Say what became of the effects of an earlier report, and which are new; nothing without `--like`."""
    for effect in report["expected"]:
        changes = (
            f"{name} {p['before']:.4g} -> {p['now']:.4g} ({p['deviations']:.1f} std)"
            for name, p in effect["parameters"].items()
        )
        became = {
            "withdrawn": "withdrawn: these trials do not show it",
            "new": "new",
            "confirmed": f"confirmed: {', '.join(changes)}, torques over A22",
        }
        yield f"{effect_name(effect)} is {became[effect['state']]}"


def share_words(report: Section) -> list[str]:
    """Say in what share of long recordings effects were looked for; nothing where it was all."""
    looked_in = report["selection"]["looked_in_s"]
    fitted = report["refinement"]["windows"]["fit"] * report["before"]["error"]["fit"]["window_s"]
    if not 0.0 < looked_in < _ALL * fitted:
        return []
    return [
        f"effects were looked for in {looked_in:.3g} s of {fitted:.3g} s of motion, spread evenly over the trials; "
        "what was found there is fitted to all"
    ]


def effects_words(keys: Sequence[str]) -> str:
    """Write the keys of effects that a model was tried with; of none it is the same model, fitted from elsewhere."""
    return " and ".join(map(key_words, keys)) or "the same, from elsewhere"


def selection(report: Section) -> Iterator[Figure]:
    """Yield how probable each model that was tried is beside the one before, step by step."""
    panels = [
        _step(f"Step {index}: {key_words(step['action'])}", tried)
        for index, step in enumerate(report["selection"]["steps"], start=1)
        if (tried := [one for one in step["tried"] if math.isfinite(one["log10_odds"])])
    ]
    if panels:
        yield Figure(
            "selection",
            "What was tried",
            "Each model that was fitted at a step, named by the effects that it has more or has no longer, and how "
            "probable it is beside the one before: the decimal logarithm of its odds. What lies left of zero is less "
            "probable.",
            panels,
        )


def _step(title: str, tried: list[Section]) -> Panel:
    names = [wrapped(effects_words(one["effects"])) for one in tried]
    odds = [one["log10_odds"] for one in tried]
    # A bar has the room that its name needs: one line or two, or more.
    rooms = np.array([max(1.0, (name.count("\n") + 1) / 2) for name in names])
    places = (np.cumsum(rooms) - rooms / 2).tolist()
    best = int(np.argmax(odds))
    marks: list[Mark] = []
    kinds: tuple[tuple[str, Colour, bool], ...] = (("taken", "after", True), ("tried, not taken", "noise", False))
    for label, colour, is_taken in kinds:
        if of := [k for k, one in enumerate(odds) if (k == best and one > 0.0) is is_taken]:
            words = [f"{odds[k]:.3g}" for k in of]
            marks.append(Bars(label, colour, [odds[k] for k in of], [places[k] for k in of], words))
    axis = Axis(ticks=list(zip(places, names, strict=True)))
    marks.append(level("as probable as before", "before", 0.0, axis))
    return Panel(_ODDS, axis, marks, title, 45.0 + _ROOM * float(rooms.sum()))


def candidates(report: Section) -> Iterator[Figure]:
    """Yield how probable the model would be with each effect that it does not have."""
    best: dict[str, Section] = {}
    for one in report["selection"]["candidates"]:
        if math.isfinite(one["log10_odds"]):
            best.setdefault(key_words(".".join(one["effect"].split(".")[:2])), one)
    if not best:
        return
    lengths = [one["log10_odds"] for one in best.values()]
    words = [f"{odds(one['log10_odds'])}, {chance(one['probability'])}" for one in best.values()]
    bars = Bars("with it", "noise", lengths, beside(0, 1, 0.0, len(best)), words)
    names = named(best)
    marks: list[Mark] = [bars, level("as probable as without it", "before", 0.0, names)]
    yield Figure(
        "candidates",
        "What else was looked for",
        "The model with one effect more beside the model without it, before any fit: odds, and the probability that "
        "the effect is there; of an effect with several forms those of the best one. Left of zero the trials speak "
        "against it.",
        [Panel(_ODDS, names, marks, height=40.0 + 20.0 * len(best))],
    )

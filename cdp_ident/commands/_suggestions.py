# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which swing to record next, for `suggest`."""

import argparse
import math
from collections.abc import Iterator

from rich.console import Console

from cdp_ident.design.knowledge import Knowledge
from cdp_ident.design.questions import ALL, Advice, Question, answers, strength_of, usual_questions
from cdp_ident.design.starts import Grid
from cdp_ident.errors import IdentificationError, OptionError, ReportError
from cdp_ident.model.effects.catalogue import known_effects
from cdp_ident.model.parameters import GROUPS, INERTIA, INVERSE_INERTIA, SYMBOLS
from cdp_ident.model.weights import RODS, Weight, refuse_misplaced, weight_of
from cdp_ident.report.curves import read_curves
from cdp_ident.report.document import Row, Table, print_table
from cdp_ident.report.folder import CURVES, REPORT
from cdp_ident.report.knowledge import knowledge_of, recorded_motion
from cdp_ident.report.next_trial import advice_section, one_advice
from cdp_ident.report.report_file import read_report
from cdp_ident.report.schema import Section
from cdp_ident.user_input import refuse_unknown

_MASSES = ("m1", "m2", "m0")


def print_suggestions(options: argparse.Namespace) -> None:
    """Print the starts to take. Raises CdpIdentError where there is no answer."""
    if max(options.most_inner, options.most_outer) < options.spacing:
        raise OptionError(f"no rod may be led as far as one step of {options.spacing:g}°: give a smaller --spacing")
    grid = Grid.of(options.spacing, options.most_inner, options.most_outer)
    report = read_report(options.folder / REPORT)
    knowledge = knowledge_of(report)
    if knowledge is None:
        raise ReportError(f"{options.folder / REPORT} says nothing of a next trial: the fit failed")
    questions = _questions(report, knowledge, options.wanted, options.between)
    if options.weight_std and not options.weights:
        raise OptionError("--weight-std is given, but --weight is not: give both")
    used = [tuple(Weight(**weight) for weight in trial["weights"]) for trial in report["trials"]]
    weights = [*used, *((_weight(given, options.weight_std, report),) for given in options.weights)]
    curves = read_curves(options.folder / CURVES, len(report["trials"]), len(report["effects"]))
    console = Console()
    found = answers(knowledge, lambda known: recorded_motion(report, curves, known), questions, grid, weights)
    for question, advice in zip(questions, found, strict=True):
        if advice is None:
            raise IdentificationError(
                f"no trial tells {question.about} from {question.against}: the second can be the first, or does not fit"
            )
        console.print(one_advice(advice_section(advice)), highlight=False, markup=False, soft_wrap=True)
        if advice.names:
            print_table(console, Table("", ("", "standard deviation now", "then"), list(_deviations(advice))))
        console.print()


def _deviations(advice: Advice) -> Iterator[Row]:
    for name, *both in zip(advice.names, advice.std_now, advice.std_then, strict=True):
        now, then = (f"{std:.3g}" if math.isfinite(std) else "not determined" for std in both)
        yield f"  {name}", now, then


def _weight(given: str, given_std: str | None, report: Section) -> Weight:
    """Return the weight that --weight describes."""
    where, where_std = f"--weight {given}", f"--weight-std {given_std}"
    name, _, added = given.partition("=")
    refuse_unknown([name], RODS, "rod of --weight")
    rod = next(each for each in RODS if each == name)
    weight = weight_of(rod, _numbers(added), _numbers(given_std) if given_std else None, where, where_std)
    if weight is None:
        raise OptionError(f"{where}: a mass of 0 is no weight; starts without one are tried in any case")
    physical = report["after"]["physical"]
    length = physical["L"]["value"] if rod == "inner" else report["after"]["outer_rod_length_m"]
    refuse_misplaced(weight, length, sum(physical[mass]["value"] for mass in _MASSES), where)
    return weight


def _numbers(text: str) -> list[float] | str:
    """Return numbers that are parted by commas; the text itself where they are none."""
    try:
        return [float(part) for part in text.split(",")]
    except ValueError:
        return text


def _questions(report: Section, knowledge: Knowledge, wanted: list[str], between: list[str] | None) -> list[Question]:
    model = knowledge.model
    if not wanted and not between:
        return usual_questions(model, [effect["also_possible"] for effect in report["effects"]])
    if unseen := sorted(set(wanted) & set(SYMBOLS) - {"c1", "c2"}):
        raise OptionError(
            f"--for {unseen[0]}: no swing determines {unseen[0]} by itself; ask for a base parameter or, with a "
            "weight, for A22"
        )
    names = {ALL: ALL, INERTIA.symbol: INERTIA.symbol}
    names |= {name: name for name in knowledge.asked if name != INVERSE_INERTIA.symbol}
    names |= {group.symbol.removesuffix("_over_A22"): group.symbol for group in GROUPS}
    names |= {label: strength_of(model, label) for label in model.labels if strength_of(model, label)}
    refuse_unknown(wanted, names, "--for")
    questions = [Question(names[name]) for name in wanted]
    return [*questions, _between(knowledge, *between)] if between else questions


def _between(knowledge: Knowledge, first: str, second: str) -> Question:
    """Return the question which of two effects it is; one of them is the fitted model's."""
    places = {f"{effect.name}.{effect.joint}" for effect in known_effects() if not effect.at_an_instant}
    refuse_unknown([first, second], places, "effect of --between")
    own = {
        f"{a.effect.name}.{a.effect.joint}": label
        for a, label in zip(knowledge.model.effects, knowledge.model.labels, strict=True)
    }
    if second in own:
        first, second = second, first
    if first not in own:
        found = ", ".join(own) or "no effect"
        raise OptionError(f"--between {first} {second}: one of them must be in the fitted model, which has {found}")
    if second in own:
        raise OptionError(
            f"--between {first} {second}: the fitted model has both; ask for the strength of one, --for {first}"
        )
    return Question(own[first], second)

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The report as a document: its chapters, and the rows of their tables, each said once for all forms of it."""

import math
import re
import shlex
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from cdp_ident.model.parameters import CONSTANTS, GROUPS, INERTIA, PARAMETERS
from cdp_ident.report.advice import advice_map, advice_words
from cdp_ident.report.curves import Curves
from cdp_ident.report.document import Chapter, Charts, Code, Document, Parts, Row, Sentences, Table
from cdp_ident.report.figures import errors, motion, parameters, torques
from cdp_ident.report.figures.description import Figure
from cdp_ident.report.schema import Section
from cdp_ident.report.typesetting import Formula
from cdp_ident.report.wording import (
    CERTAINTY_WORDS,
    action_words,
    capitalised,
    chance,
    determined_words,
    effect_title,
    effects_words,
    expected_in_words,
    group_words,
    how_determined,
    in_unit,
    interval,
    key_words,
    milliradians,
    models,
    noise_floor,
    nominal_groups,
    nominal_value,
    odds,
    per_cent,
    predicted_for,
    quantity_words,
    role_words,
    share_words,
    short_name,
    unit,
    validation_words,
    weights_words,
    with_std,
)
from cdp_ident.tracing.unexplained import errors_of_time

_STAMP = re.compile(r"(\d{4})(\d\d)(\d\d)_\d{6}")
"""In the names that the recorder gives: year, month and day."""
_MOST_CANDIDATES = 10
_FITTED = ("fitted ± std", "95 % interval", "unit")
"""Columns of fitted values."""
_STAGES = {"nominal": "nominal values", "search": "after the search", "refined": "refined"}


def document_of(report: Section, curves: Curves | None = None) -> Document:
    """Return the document that a report is; its first chapter is the result.

    Without `curves`, what is drawn from these is left out.
    """
    fitted = [trial["name"] for trial in report["trials"] if trial["role"] == "fit"]
    # The most important effect first; a single one is in the verdict.
    effects = report["effects"] if len(report["effects"]) > 1 else []
    by_importance = sorted(effects, key=lambda effect: -effect["evidence"]["rmse_holdout_before_rad"])
    found = Sentences([effect["summary"] for effect in by_importance])
    numbers = Table("", ("", "", ""), list(_numbers(report)))
    of_curves = (motion.angles, motion.continuous_runs, torques.missing_torques, torques.effects_through_residuals)
    angles, runs, missing, through = (list(figures(report, curves)) if curves else [] for figures in of_curves)
    of_effects = [*missing[1:], *through, *torques.nonparametric_torques(report)]
    chapters = (
        Chapter("result", "", (found, numbers, Charts([errors.before_and_after(report), *missing[:1]]))),
        Chapter("motion", "Angles over time", (Charts(angles),)),
        Chapter("validation", "Validation", _validation(report)),
        Chapter("paper", "The paper's figures for this rig", (Charts([*errors.best_error(report), *runs], True),)),
        Chapter("effects", "Effects that the paper's model lacks", _effects(report, of_effects)),
        Chapter("parameters", "Parameters", _parameters(report)),
        Chapter("next", "Which swing next", _next(report)),
        Chapter("warnings", "Warnings", (_warnings(report),)),
        Chapter("repeat", "To repeat this run", _to_repeat(report)),
    )
    return Document("Cart double pendulum, identified", _heading(fitted), report["verdict"], chapters)


def _heading(trials: list[str]) -> str:
    """Return what a report is of: its trials by name or, where names are time stamps, how many of which days."""
    stamps = [stamp for trial in trials if (stamp := _STAMP.search(trial))]
    if len(stamps) < len(trials):
        return ", ".join(trials)
    days = sorted({"-".join(stamp.groups()) for stamp in stamps})
    return f"{len(trials)} trial{'' if len(trials) == 1 else 's'} of {', '.join(days)}"


def _sentences(phrases: Iterable[str], title: str = "", noted: bool = False) -> Sentences:
    return Sentences([_sentence(phrase) for phrase in phrases], title, noted)


def _sentence(text: str) -> str:
    """Write a phrase as a sentence; a symbol at its beginning, such as m1 or g, is not capitalised."""
    first = text.partition(" ")[0]
    begun = capitalised(text) if first.isalpha() and len(first) > 1 else text
    return begun if begun.endswith(".") else f"{begun}."


def _numbers(report: Section) -> Iterator[Row]:
    """Yield the result in numbers: name, value, and what belongs to it."""
    has_effects, window = bool(report["effects"]), report["before"]["error"]["holdout"]["window_s"]
    for where, name in (("holdout", f"error held out, over {window:.2g} s"), ("fit", "error fitted")):
        before, after = (1e3 * report[model]["error"][where]["rmse_rad"] for model in ("before", "after"))
        falls = f", {before / after:.3g} times less" if has_effects and 0.0 < after < before else ""
        yield name, f"{before:.3g} → {after:.3g}" if has_effects else f"{after:.3g}", f"mrad{falls}"
    if report["prediction"]:
        limit = report["prediction"]["before"]["within"][0]["limit_deg"]
        seconds = predicted_for(report, 0).replace("->", "→").replace("≥ ", "≥\u202f")
        yield f"predicts within {limit:.3g}° for", seconds, "s"
    late = errors_of_time((report["whole_swings"] or {}).get("time_noise_s", 0.0))
    yield "the encoders' noise", f"{1e3 * noise_floor(report):.3g}", f"mrad, with {late}" if late else "mrad"
    yield "effects found", str(len(report["effects"])), ", ".join(key_words(e["name"]) for e in report["effects"])
    squared = (report[model.key]["error"]["holdout"]["sse_free_run"] for model in models(report))
    said = (f"{error:.3g}" if math.isfinite(error) else "diverges" for error in squared)
    yield "Eq. (10), held out", " → ".join(said), "rad²"


def _validation(report: Section) -> Parts:
    stages = [(label, report["stages"][stage]) for stage, label in _STAGES.items()]
    if report["effects"]:
        stages.append(("with the effects found", report["after"]["error"]))
    window = report["before"]["error"]["fit"]["window_s"]
    fits = ("NRMSE fit of θ1 and θ2 [%]", "held out [%]")
    noise = " and ".join(map(milliradians, report["noise_rad"].values()))
    return (
        _sentences(validation_words(report)),
        Table(
            f"Error, measured against simulated, over windows of {window:.3g} s",
            ("model", "fit [mrad]", "held out [mrad]", "Eq. (10), held out [rad²]", *fits),
            [
                *((label, *_error(of_model)) for label, of_model in stages),
                ("the encoders' noise", noise, "", "", "", ""),
            ],
            wide=fits,
        ),
        Charts([*errors.prediction(report), errors.residual_correlation(report)], side_by_side=True),
    )


def _error(of_model: Section) -> Iterator[str]:
    """Yield the errors of a model as the columns of the table have them."""
    for role in ("fit", "holdout"):
        yield milliradians(of_model[role]["rmse_rad"])
    yield f"{of_model['holdout']['sse_free_run']:.4g}"
    for role in ("fit", "holdout"):
        yield " and ".join(per_cent(of_model[role][f"fit_{angle}_percent"]) for angle in ("theta1", "theta2"))


def _effects(report: Section, of_effects: Sequence[Figure]) -> Parts:
    steps = list(enumerate(report["selection"]["steps"], start=1))
    others = [
        f"Instead of {effect_title(effect)} it could be {_others(effect)}: the trials do not distinguish them"
        for effect in report["effects"]
        if effect["also_possible"]
    ]
    about = ("held out without → with [mrad]", "formula", "also possible")
    no_other = "No other effect could take the place of what was added, as far as the trials show"
    interrupted = report["selection"]["interrupted"]
    return (
        Table(
            "Found and added",
            ("effect", "parameter", "value ± std", "how sure", *about),
            [row for effect in report["effects"] for row in _parameters_of(effect)],
            wide=("formula",),
        ),
        _sentences([] if report["effects"] else ["None was added"]),
        _sentences([f"What remains: {report['unexplained']['description']}"]),
        _sentences(expected_in_words(report), "Beside the earlier report"),
        _sentences(others or [no_other] if report["effects"] else [], "What the trials do not distinguish"),
        _sentences(["The tracing was interrupted: there may be more to find"] if interrupted else [], noted=True),
        _sentences(share_words(report), noted=True),
        _sentences([] if steps else ["Effects were not looked for"]),
        Table(
            "Step by step",
            ("step", "what was done", "odds over the paper's model"),
            [(str(index), action_words(step), odds(step["log10_odds"])) for index, step in steps],
            at_terminal=False,
        ),
        Charts([*errors.selection(report), *errors.candidates(report)]),
        Table(
            "What else was looked for",
            ("effect", "odds, were it added", "probability"),
            [
                (key_words(other["effect"]), odds(other["log10_odds"]), chance(other["probability"]))
                for other in report["selection"]["candidates"][:_MOST_CANDIDATES]
            ],
            folded=True,
        ),
        Table(
            "All that was tried",
            ("step", "effect", "odds over the model before"),
            [
                (str(index), effects_words(tried["effects"]), odds(tried["log10_odds"]))
                for index, step in steps
                for tried in step["tried"]
            ],
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
    said = (" → ".join(map(milliradians, held_out)), Formula(effect["formula"]), _others(effect) or "–")
    title, about = (
        effect_title(effect),
        [f"{CERTAINTY_WORDS[effect['certainty']]}, {chance(evidence['probability'])}", *said],
    )
    for name, quantity in effect["parameters"].items():
        yield title, name, quantity_words(quantity), *about
        title, about = "", [""] * 4


def _parameters(report: Section) -> Parts:
    after, compared = report["after"], report["repeatability"]
    trials = compared["trials"] if compared else ()
    agree = "agree" if compared and compared["agree"] else "do not agree"
    return (
        base_parameters(report),
        Table(
            "Physical values",
            ("parameter", "what it is", "nominal", *_FITTED, "determined by the trials"),
            [
                (
                    parameter.symbol,
                    parameter.description,
                    f"{nominal_value(report, parameter.symbol):.4g}",
                    *_fitted(value, 0.0),
                    how_determined(report, parameter.symbol),
                )
                for parameter in (*PARAMETERS, *CONSTANTS, INERTIA)
                for value in [after["physical"][parameter.symbol]]
            ],
            wide=("what it is",),
        ),
        _sentences(determined_words(report), "What the trials determine"),
        Table(
            f"Each trial alone: they {agree} (p = {compared['p_value']:.2g})" if compared else "",
            ("base parameter", "jointly", *(trial["trial"] for trial in trials)),
            [
                (short_name(group), *(with_std(of[group]["value"], of[group]["std"]) for of in estimates))
                for estimates in [(after["groups"], *(trial["groups"] for trial in trials))]
                for group in (after["groups"] if trials else ())
            ],
        ),
        Charts(
            [parameters.against_nominal(report), *parameters.correlation(report), *parameters.repeatability(report)],
            side_by_side=True,
        ),
    )


def base_parameters(report: Section, short: bool = False) -> Table:
    """Return the base parameters of the final model; in `short`, with their units beside the values."""
    nominal, rows = nominal_groups(report), []
    for group in GROUPS:
        found = report["after"]["groups"][group.symbol]
        name, sure = group_words(group), "yes" if found["determined"] else "not by these trials"
        beside = in_unit(found["value"], found["std"], found["unit"])
        rows.append((name, *((beside,) if short else (f"{nominal[group.symbol]:.4g}", *_fitted(found))), sure))
    columns = ("base parameter", *(_FITTED[:1] if short else ("nominal", *_FITTED)), "determined")
    return Table("Base parameters, all that a free swing depends on", columns, rows)


def _fitted(quantity: Section, lowest: float = -math.inf) -> Row:
    """Return what stands in the columns of a fitted value, which is not below the `lowest`."""
    value = (quantity["value"], quantity["std"])
    return with_std(*value), interval(*value, lowest) if value[1] else "", unit(quantity["unit"])


def _next(report: Section) -> Parts:
    where = "Where to hold both rods before they are let go, in angles from hanging, positive towards +x"
    return _sentences(advice_words(report), where), Charts(list(advice_map(report)))


def _warnings(report: Section) -> Sentences:
    said = [f"{key_words(warning['name'])}: {warning['message']}" for warning in report["warnings"]]
    return _sentences(said or ["None"], noted=bool(said))


def _to_repeat(report: Section) -> Parts:
    """Return the command, the trials, and all that the result depends on."""
    run = report["run"]
    checksums = [(bag, file, digest) for bag, sums in run["bag_sha256"].items() for file, digest in sums.items()]
    options = [(name, _value(value)) for name, value in run["options"].items()]
    return (
        Sentences((Code(_command(report)),)),
        Table(
            "Trials",
            ("bag", "role", "samples", "free swing [s]", "weights", "what was cut or noticed"),
            [
                (
                    trial["bag"],
                    role_words(trial),
                    f"{trial['samples']:.0f}",
                    f"{trial['start_s']:.2f} to {trial['start_s'] + trial['duration_s']:.2f}",
                    weights_words(trial) or "–",
                    "; ".join(trial["warnings"]),
                )
                for trial in report["trials"]
            ],
        ),
        Table("Checksums (SHA-256)", ("bag", "file", "sum"), checksums, at_terminal=False),
        Table("Search", ("", ""), list(_search(report)), at_terminal=False),
        Table("Versions", ("package", "version"), list(run["versions"].items()), at_terminal=False),
        Table("Options", ("option", "value"), options, folded=True, at_terminal=False),
    )


def _command(report: Section) -> str:
    """Return the command that makes this run anew, if its options are in a file."""
    bags = {kind: [trial["bag"] for trial in report["trials"] if trial["role"] == kind] for kind in ("fit", "holdout")}
    options = ["ros2", "run", "cdp_ident", "identify", "--bag", *bags["fit"]]
    if bags["holdout"]:
        options += ["--holdout", *bags["holdout"]]
    if not report["search"]["cut_short"]:
        options += ["--method", report["search"]["method"]]
    return shlex.join([*options, "--seed", f"{report['search']['seed']:.0f}"])


def _search(report: Section) -> Iterator[Row]:
    search = report["search"]
    yield "method", search["method"].upper() + (", cut short" if search["cut_short"] else "")
    yield "seed", f"{search['seed']:.0f}"
    yield "population", f"{search['population']:.0f}"
    yield "generations", f"{search['generations']:.0f} ({search['stopped']})"
    yield "evaluations", f"{search['evaluations']:.0f}"
    yield "best chromosome", ", ".join(f"{symbol} {value:.4g}" for symbol, value in search["best"].items())
    yield "its error", f"{search['sse']:.4g} rad²"
    yield "time", f"{search['seconds']:.1f} s for the search, {report['run']['seconds']:.1f} s in all"


def _value(value: Any) -> str:
    return "–" if value is None or value == "" else f"{value:.6g}" if isinstance(value, float) else str(value)

"""What page and text say beside the pictures: the rows of their tables and a few sentences, as plain text."""

import math
import re
import shlex
from collections.abc import Iterator
from typing import Any

from cdp_ident.model.parameters import CONSTANTS, GROUPS, INERTIA, PARAMETERS
from cdp_ident.report.figures.models import models
from cdp_ident.report.formatting import interval, milliradians, number, odds, per_cent, quantity_words, unit, with_std
from cdp_ident.report.schema import Section
from cdp_ident.report.typesetting import Formula
from cdp_ident.report.wording import (
    action_words,
    advice_words,
    candidate_rows,
    determined_words,
    effect_title,
    effects_in_words,
    effects_words,
    expected_in_words,
    how_determined,
    noise_floor,
    nominal_groups,
    nominal_value,
    others_words,
    predicted_for,
    share_words,
    short_name,
    sure_words,
    validation_words,
    weights_words,
)

Row = tuple[str, ...]

_STAMP = re.compile(r"(\d{4})(\d\d)(\d\d)_\d{6}")
"""In the names that the recorder gives: year, month and day."""


def words(report: Section) -> dict[str, Any]:
    """Return everything that the templates of page and text have in common, by name."""
    return {
        "heading": _heading([trial["name"] for trial in report["trials"] if trial["role"] == "fit"]),
        "numbers": list(_numbers(report)),
        "found": effects_in_words(report),
        "expected": expected_in_words(report),
        "command": _command(report),
        "role": role,
        "sentence": sentence,
        "validation": validation_words(report),
        "determined": determined_words(report),
        "share": share_words(report),
        "advice": advice_words(report),
        "rows": {
            "effects": _effects(report),
            "also_possible": _also_possible(report),
            "selection": _selection(report),
            "tried": _tried(report),
            "candidates": candidate_rows(report),
            "base": [(of, f"{value} {of_unit}", sure) for of, _, value, _, of_unit, sure in _groups(report)],
            "groups": _groups(report),
            "physical": _physical(report),
            "repeatability": _repeatability(report),
            "fit": _fit(report),
            "trials": _trials(report),
            "checksums": [
                (bag, file, digest)
                for bag, sums in report["run"]["bag_sha256"].items()
                for file, digest in sums.items()
            ],
            "search": _search(report),
            "options": [(name, _value(value)) for name, value in report["run"]["options"].items()],
        },
    }


def _heading(trials: list[str]) -> str:
    """Return what a report is of: its trials by name or, where names are time stamps, how many of which days."""
    stamps = [stamp for trial in trials if (stamp := _STAMP.search(trial))]
    if len(stamps) < len(trials):
        return ", ".join(trials)
    days = sorted({"-".join(stamp.groups()) for stamp in stamps})
    return f"{len(trials)} trial{'' if len(trials) == 1 else 's'} of {', '.join(days)}"


def role(trial: Section) -> str:
    """Say what a trial was for."""
    return "fitted" if trial["role"] == "fit" else "held out"


def sentence(text: str) -> str:
    """Write a phrase as a sentence; a symbol at its beginning, such as m1 or g, is not capitalised."""
    first = text.partition(" ")[0]
    begun = text[0].upper() + text[1:] if first.isalpha() and len(first) > 1 else text
    return begun if begun.endswith(".") else f"{begun}."


def _numbers(report: Section) -> list[Row]:
    def change(where: str) -> Row:
        before, after = (number(report[model]["error"][where]["rmse_rad"]) for model in ("before", "after"))
        if not report["effects"]:
            return f"{1e3 * after:.3g}", "mrad"
        falls = f", {before / after:.3g} times less" if 0.0 < after < before else ""
        return f"{1e3 * before:.3g} → {1e3 * after:.3g}", f"mrad{falls}"

    window = report["before"]["error"]["holdout"]["window_s"]
    return [
        (f"error held out, over {window:.2g} s", *change("holdout")),
        ("error fitted", *change("fit")),
        *_predicted(report),
        ("the encoders' noise", f"{1e3 * noise_floor(report):.3g}", "mrad"),
        (
            "effects found",
            str(len(report["effects"])),
            ", ".join(e["name"].replace("_", " ") for e in report["effects"]),
        ),
        ("Eq. (10), held out", _squared_errors(report), "rad²"),
    ]


def _predicted(report: Section) -> Iterator[Row]:
    if report["prediction"]:
        limit = report["prediction"]["before"]["within"][0]["limit_deg"]
        yield (
            f"predicts within {limit:.3g}° for",
            predicted_for(report, 0).replace("->", "→").replace("≥ ", "≥\u202f"),
            "s",
        )


def _fit(report: Section) -> list[Row]:
    def fits(error: Section) -> Iterator[str]:
        for role in ("holdout", "fit"):
            yield " and ".join(per_cent(error[role][f"fit_{angle}_percent"]) for angle in ("theta1", "theta2"))

    return [(model.label, *fits(report[model.key]["error"])) for model in models(report)]


def _squared_errors(report: Section) -> str:
    both = ("before", "after") if report["effects"] else ("before",)
    errors = (number(report[model]["error"]["holdout"]["sse_free_run"]) for model in both)
    return " → ".join(f"{error:.3g}" if math.isfinite(error) else "diverges" for error in errors)


def _command(report: Section) -> str:
    """Return the command that makes this run anew, if its options are in a file."""
    bags = {kind: [trial["bag"] for trial in report["trials"] if trial["role"] == kind] for kind in ("fit", "holdout")}
    options = ["ros2", "run", "cdp_ident", "identify", "--bag", *bags["fit"]]
    if bags["holdout"]:
        options += ["--holdout", *bags["holdout"]]
    if not report["search"]["cut_short"]:
        options += ["--method", report["search"]["method"]]
    return shlex.join([*options, "--seed", f"{report['search']['seed']:.0f}"])


def _effects(report: Section) -> list[Row]:
    rows: list[Row] = []
    for effect in report["effects"]:
        evidence = effect["evidence"]
        errors = (evidence["rmse_holdout_before_rad"], evidence["rmse_holdout_after_rad"])
        for index, (name, quantity) in enumerate(effect["parameters"].items()):
            about = (
                sure_words(effect),
                " → ".join(map(milliradians, errors)),
                Formula(effect["formula"]),
                others_words(effect) or "–",
            )
            rows.append(
                (
                    "" if index else effect_title(effect),
                    name,
                    quantity_words(quantity),
                    *(("",) * 4 if index else about),
                )
            )
    return rows


def _also_possible(report: Section) -> list[str]:
    return [
        f"Instead of {effect_title(effect)} it could be {others_words(effect)}: the trials do not distinguish them."
        for effect in report["effects"]
        if effect["also_possible"]
    ]


def _selection(report: Section) -> list[Row]:
    return [
        (str(index), action_words(step), odds(step["log10_odds"]))
        for index, step in enumerate(report["selection"]["steps"], start=1)
    ]


def _tried(report: Section) -> list[Row]:
    return [
        (str(index), effects_words(tried["effects"]), odds(tried["log10_odds"]))
        for index, step in enumerate(report["selection"]["steps"], start=1)
        for tried in step["tried"]
    ]


def _groups(report: Section) -> list[Row]:
    nominal = nominal_groups(report)
    return [
        (
            f"{short_name(group.symbol)} = {group.formula}",
            f"{nominal[group.symbol]:.4g}",
            with_std(found["value"], found["std"]),
            interval(found["value"], found["std"]),
            unit(found["unit"]),
            "yes" if found["determined"] else "not by these trials",
        )
        for group in GROUPS
        for found in [report["after"]["groups"][group.symbol]]
    ]


def _physical(report: Section) -> list[Row]:
    return [
        (
            parameter.symbol,
            parameter.description,
            f"{nominal_value(report, parameter.symbol):.4g}",
            with_std(found["value"], found["std"]),
            "" if found["std"] == 0.0 else interval(found["value"], found["std"], 0.0),
            found["unit"],
            how_determined(report, parameter.symbol),
        )
        for parameter in (*PARAMETERS, *CONSTANTS, INERTIA)
        for found in [report["after"]["physical"][parameter.symbol]]
    ]


def _repeatability(report: Section) -> list[Row]:
    compared = report["repeatability"]
    if compared is None:
        return []
    rows: list[Row] = [("base parameter", "jointly", *(trial["trial"] for trial in compared["trials"]))]
    for group, joint in report["after"]["groups"].items():
        alone = [trial["groups"][group] for trial in compared["trials"]]
        rows.append((short_name(group), *(with_std(found["value"], found["std"]) for found in (joint, *alone))))
    return rows


def _trials(report: Section) -> list[Row]:
    return [
        (
            trial["bag"],
            role(trial),
            f"{trial['samples']:.0f}",
            f"{trial['start_s']:.2f} to {trial['start_s'] + trial['duration_s']:.2f}",
            weights_words(trial) or "–",
            "; ".join(trial["warnings"]),
        )
        for trial in report["trials"]
    ]


def _search(report: Section) -> list[Row]:
    search = report["search"]
    return [
        ("method", search["method"].upper() + (", cut short" if search["cut_short"] else "")),
        ("seed", f"{search['seed']:.0f}"),
        ("population", f"{search['population']:.0f}"),
        ("generations", f"{search['generations']:.0f} ({search['stopped']})"),
        ("evaluations", f"{search['evaluations']:.0f} in {search['searches']:.0f} searches"),
        ("best chromosome", ", ".join(f"{symbol} {value:.4g}" for symbol, value in search["best"].items())),
        ("its error", f"{number(search['sse']):.4g} rad²"),
        ("time", f"{search['seconds']:.1f} s for the search, {report['run']['seconds']:.1f} s in all"),
    ]


def _value(value: Any) -> str:
    return "–" if value is None or value == "" else f"{value:.6g}" if isinstance(value, float) else str(value)

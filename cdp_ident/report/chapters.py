# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The report as a document: its chapters, and the rows of their tables, each said once for all forms of it."""

import math
import re
import shlex
from collections.abc import Callable, Iterator

import numpy as np

from cdp_ident.report.curves import Curves
from cdp_ident.report.document import Chapter, Charts, Code, Document, Parts, Row, Sentences, Table
from cdp_ident.report.figures.curves import (
    angles,
    continuous_runs,
    effects_through_residuals,
    missing_torques,
    nonparametric_torques,
)
from cdp_ident.report.figures.description import Axis, Figure, Line, Panel
from cdp_ident.report.next_trial import advice_map, advice_words
from cdp_ident.report.parameters import parameters
from cdp_ident.report.schema import Section
from cdp_ident.report.selection import effects
from cdp_ident.report.validation import before_and_after, predicted_for, validation
from cdp_ident.report.wording import key_words, models, noise_floor, role_words, weights_words
from cdp_ident.tracing.unexplained import errors_of_time

_STAMP = re.compile(r"(\d{4})(\d\d)(\d\d)_\d{6}")
"""In the names that the recorder gives: year, month and day."""


def document_of(report: Section, curves: Curves | None = None) -> Document:
    """Return the document that a report is; its first chapter is the result.

    Without `curves`, what is drawn from these is left out.
    """
    fitted = [trial["name"] for trial in report["trials"] if trial["role"] == "fit"]
    # The most important effect first; a single one is in the verdict.
    several = report["effects"] if len(report["effects"]) > 1 else []
    by_importance = sorted(several, key=lambda effect: -effect["evidence"]["rmse_holdout_before_rad"])
    found = Sentences([effect["summary"] for effect in by_importance])
    numbers = Table("", ("", "", ""), list(_numbers(report)))
    of_curves = (angles, continuous_runs, missing_torques, effects_through_residuals)
    over_time, runs, missing, through = (list(figures(report, curves)) if curves else [] for figures in of_curves)
    of_effects = [*missing[1:], *through, *nonparametric_torques(report)]
    hold = "Where to hold both rods before they are let go, in angles from hanging, positive towards +x"
    next_trial = (Sentences.of(advice_words(report), hold), Charts(list(advice_map(report))))
    warnings = [f"{key_words(warning['name'])}: {warning['message']}" for warning in report["warnings"]]
    chapters = (
        Chapter("result", "", (found, numbers, Charts([before_and_after(report), *missing[:1]]))),
        Chapter("motion", "Angles over time", (Charts(over_time),)),
        Chapter("validation", "Validation", validation(report)),
        Chapter("paper", "The paper's figures for this rig", (Charts([*best_error(report), *runs], True),)),
        Chapter("effects", "Effects that the paper's model lacks", effects(report, of_effects)),
        Chapter("parameters", "Parameters", parameters(report)),
        Chapter("next", "Which swing next", next_trial),
        Chapter("warnings", "Warnings", (Sentences.of(warnings or ["None"], noted=bool(warnings)),)),
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


def best_error(report: Section) -> Iterator[Figure]:
    """Yield the best error over the generations of a report's search, where it was not cut short to a few."""
    search = report["search"]
    if search["cut_short"]:
        return
    history, name = np.array(search["history"]), search["method"].upper()
    line = Line(name, "after", np.arange(len(history), dtype=float), history, 2.0)
    yield Figure(
        "best_error",
        "Evolution of the best error",
        f"Squared error (Eq. 10) of the best chromosome after each generation of the search ({name}), from which the "
        "refinement starts. As the paper's Figs. 7, 9 and 13.",
        [Panel(Axis("generation"), Axis("best error E(Z) [rad²]", logarithmic=True), [line], height=260)],
    )


def _to_repeat(report: Section) -> Parts:
    """Return the command, the trials, and all that the result depends on."""
    run = report["run"]
    checksums = [(bag, file, digest) for bag, sums in run["bag_sha256"].items() for file, digest in sums.items()]
    options = [
        (name, "–" if value in (None, "") else f"{value:.6g}" if isinstance(value, float) else str(value))
        for name, value in run["options"].items()
    ]
    of_trial: dict[str, Callable[[Section], str]] = {
        "bag": lambda trial: trial["bag"],
        "role": role_words,
        "samples": lambda trial: f"{trial['samples']:.0f}",
        "free swing [s]": lambda trial: f"{trial['start_s']:.2f} to {trial['start_s'] + trial['duration_s']:.2f}",
        "weights": lambda trial: weights_words(trial) or "–",
        "what was cut or noticed": lambda trial: "; ".join(trial["warnings"]),
    }
    return (
        Sentences((Code(_command(report)),)),
        Table.of("Trials", report["trials"], of_trial),
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

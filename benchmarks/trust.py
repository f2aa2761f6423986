# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How far results can be trusted: pictures and tables of hidden truths and of measured rigs.

`python -m benchmarks.trust identification/tracing.jsonl --reports DIR …` reads what `benchmarks.tracing` wrote,
and reports of measured rigs. With `--write` the pictures and numbers of docs/explanation/trust.md are made anew.
"""

import argparse
import io
import json
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from benchmarks._gallery_picture import _SETTINGS, COLOUR, GREY
from benchmarks._tables import Table
from reference.kinds import GROUPS

PAGE = Path(__file__).parents[1] / "docs" / "explanation" / "trust.md"
PICTURES = PAGE.with_name("trust")
BEGIN, END = "<!-- made by python -m benchmarks.trust --write -->", "<!-- end of it -->"
BLUE = "#3a8fc4"
CONFIDENCE = 1.96
EDGES = (0.0, 0.5, 0.7, 0.9, 0.99, 0.999, 1.0)
"""Of bins of probabilities: most names are nearly certain."""
NOTHING, NO_NAME = "nothing", "a nonparametric torque"

Result = dict[str, Any]


def names(results: Iterable[Result]) -> list[tuple[float, bool]]:
    """Return the probability of every name that was given, and whether it is right."""
    given = []
    for of in results:
        false: Counter[str] = Counter(of["false"])
        for name, probability in zip(of["named"], of["probability"], strict=True):
            given.append((probability, not false[name]))
            false[name] -= false[name] > 0
    return given


def reliability(results: Sequence[Result]) -> Table:
    """Return for each bin of probabilities how many names were right."""
    given, rows = np.array(names(results)).reshape(-1, 2), []
    for low, high in pairwise(EDGES):
        those = given[(given[:, 0] > low) & (given[:, 0] <= high)]
        if len(those):
            said, right = 100.0 * those[:, 0].mean(), int(those[:, 1].sum())
            rows.append((f"{low:g} to {high:g}", f"{said:.1f} %", f"{right} of {len(those)}"))
    return Table("Names", ("probability", "mean", "right"), rows)


def outcomes(results: Sequence[Result]) -> Table:
    """Return a row for each group of truths."""
    rows = []
    for group in GROUPS:
        those = [of for of in results if of["group"] == group]
        if those:
            counts = [sum(len(of[part]) for of in those) for part in ("right", "missed", "weak", "beyond", "false")]
            after = [of["after"] for of in those]
            rows.append((group, str(len(those)), *map(str, counts), f"{np.median(after):.2f}", f"{max(after):.2f}"))
    columns = (
        "hidden",
        "truths",
        "right",
        "missed",
        "too weak",
        "nonparametric",
        "false",
        "error / noise, median",
        "worst",
    )
    return Table("Truths", columns, rows)


def coverage(results: Sequence[Result]) -> Table:
    """Return for each group how often the interval of a base parameter holds the true one."""
    rows = []
    for group in GROUPS:
        those = np.array([of["deviations"] for of in results if of["group"] == group and of["deviations"]])
        if those.size:
            shares = np.mean(np.abs(those) <= CONFIDENCE, axis=1)
            error = 100.0 * shares.std() / np.sqrt(len(shares))
            rows.append((group, str(those.size), f"{100.0 * shares.mean():.0f} ± {error:.0f} %"))
    return Table("Intervals of base parameters", ("hidden", "intervals", "hold the true value"), rows)


def measured(reports: Iterable[Path]) -> list[tuple[str, float, float, float]]:
    """Return of each report its name, and the held-out errors without and with effects, and the noise [mrad]."""
    found = []
    for folder in reports:
        report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
        before, after = (1e3 * report[key]["error"]["holdout"]["rmse_rad"] for key in ("before", "after"))
        noise = 1e3 * float(np.sqrt(np.mean([report["noise_rad"][angle] ** 2 for angle in ("theta1", "theta2")])))
        found.append((folder.name.replace("_", " "), before, after, noise))
    return found


def _draw_reliability(axes: Axes, results: Sequence[Result]) -> None:
    given = np.array(names(results)).reshape(-1, 2)
    axes.plot([0.0, 1.0], [0.0, 1.0], color=GREY, linewidth=0.6)
    for low, high in pairwise(EDGES):
        those = given[(given[:, 0] > low) & (given[:, 0] <= high)]
        if count := len(those):
            right = those[:, 1].sum()
            share = (right + 0.5) / (count + 1.0)  # Jeffreys' interval, roughly
            half = CONFIDENCE * np.sqrt(share * (1.0 - share) / (count + 2.0))
            axes.errorbar(those[:, 0].mean(), right / count, half, color=COLOUR, marker="o", markersize=4, capsize=2)
            axes.annotate(f"{count}", (those[:, 0].mean(), right / count), (4, -9), textcoords="offset points")
    axes.set(xlabel="probability that was said", ylabel="share that was right", xlim=(0, 1.03), ylim=(0, 1.05))


def _draw_confusion(axes: Axes, results: Sequence[Result]) -> None:
    pairs = Counter(pair for of in results for pair in _pairs(of))
    rows = sorted({row for row, _ in pairs}, key=lambda row: (row == NOTHING, row))
    columns = sorted({column for _, column in pairs}, key=lambda name: (name == NOTHING, name == NO_NAME, name))
    for (row, column), count in pairs.items():
        colour = BLUE if row == column else GREY if column in (NOTHING, NO_NAME) else COLOUR
        place = columns.index(column), rows.index(row)
        axes.scatter(*place, s=12.0 * min(count, 25) + 20.0, color=colour, alpha=0.35, linewidth=0)
        axes.text(*place, str(count), ha="center", va="center", fontsize=6.5, color=GREY)
    axes.set_xticks(range(len(columns)), [name.replace("_", " ") for name in columns], rotation=90)
    axes.set_yticks(range(len(rows)), [name.replace("_", " ") for name in rows])
    axes.set(xlabel="found", ylabel="hidden", xlim=(-0.7, len(columns) - 0.3), ylim=(len(rows) - 0.3, -0.7))


def _pairs(of: Result) -> list[tuple[str, str]]:
    """Return what was hidden and what was found for it, of one truth."""

    def bare(key: str) -> str:
        return key.split(".")[0]

    pairs = [(bare(key), bare(key)) for key in of["right"]]
    lost = [bare(key) for key in (*of["missed"], *of["weak"], *of["beyond"])]
    others = [*map(bare, of["false"]), *([NO_NAME] * len(of["unknown"]))]
    pairs += [(key, other) for key, other in zip(lost, [*others, *[NOTHING] * len(lost)], strict=False)]
    pairs += [(NOTHING, other) for other in others[len(lost) :]]
    return pairs or [(NOTHING, NOTHING)]


def _draw_errors(axes: Axes, results: Sequence[Result]) -> None:
    rng = np.random.default_rng(0)
    groups = [group for group in GROUPS if any(of["group"] == group for of in results)]
    for place, group in enumerate(groups):
        those = [of for of in results if of["group"] == group]
        for key, colour, offset in (("before", COLOUR, -0.17), ("after", BLUE, 0.17)):
            across = place + offset + rng.uniform(-0.1, 0.1, len(those))
            label = {"before": "the paper's model", "after": "with the effects found"}[key]
            axes.plot(
                across, [of[key] for of in those], ".", color=colour, markersize=3, label=None if place else label
            )
    axes.axhline(1.0, color=GREY, linewidth=0.6)
    axes.set_xticks(range(len(groups)), groups)
    axes.set(yscale="log", ylabel="held-out error / noise", xlabel="hidden")
    axes.legend(frameon=False)


def _draw_coverage(axes: Axes, results: Sequence[Result]) -> None:
    from scipy.stats import norm  # noqa: PLC0415 - the other pictures do without

    axes.plot([0.0, 4.0], [0.0, 4.0], color=GREY, linewidth=0.6)
    for of_known, colour, label in ((True, BLUE, "nothing or known effects"), (False, COLOUR, "beyond the catalogue")):
        chosen = [of["deviations"] for of in results if (of["group"] != "beyond") == of_known]
        sizes = np.sort(np.abs(np.concatenate([np.empty(0), *map(np.asarray, chosen)])))
        if len(sizes):
            expected = norm.isf(0.5 * (1.0 - (np.arange(len(sizes)) + 0.5) / len(sizes)))
            axes.plot(expected, np.minimum(sizes, 6.0), ".", color=colour, markersize=2, label=label)
    axes.axvline(CONFIDENCE, color=GREY, linewidth=0.4, linestyle=":")
    axes.set(xlabel="expected of a normal distribution", ylabel="error of base parameters\n[standard deviations]")
    axes.legend(frameon=False)


def _draw_measured(axes: Axes, rigs: Sequence[tuple[str, float, float, float]]) -> None:
    for place, (_, before, after, noise) in enumerate(rigs):
        axes.plot([noise, before], [place, place], color=GREY, linewidth=0.6)
        for value, colour, marker, label in (
            (before, COLOUR, "o", "the paper's model"),
            (after, BLUE, "o", "with the effects found"),
            (noise, GREY, "|", "noise"),
        ):
            axes.plot(value, place, marker, color=colour, label=None if place else label)
    axes.set_yticks(range(len(rigs)), [name for name, *_ in rigs])
    axes.set(xscale="log", xlabel="held-out error [mrad]", ylim=(len(rigs) - 0.4, -0.6))
    axes.legend(frameon=False)


def picture(draw: Callable[[Axes], None], size: tuple[float, float]) -> bytes:
    """Return a picture as an SVG file without a background."""
    with matplotlib.rc_context(_SETTINGS):
        figure = Figure(figsize=size, layout="constrained")
        axes = figure.subplots()
        draw(axes)
        axes.spines[["top", "right"]].set_visible(False)
        stream = io.BytesIO()
        FigureCanvasSVG(figure).print_figure(
            stream, format="svg", facecolor="none", metadata={"Date": None, "Creator": None}
        )
    return stream.getvalue()


def written(page: str, results: Sequence[Result], rigs: Sequence[tuple[str, float, float, float]]) -> str:
    """Return a page with the tables in their place."""
    rows = [(name, *(f"{value:.3g}" for value in values)) for name, *values in rigs]
    of_rigs = Table("Measured rigs", ("rig", "the paper's model [mrad]", "with effects [mrad]", "noise [mrad]"), rows)
    engines = Counter(of["engine"] for of in results)
    said = f"{len(results)} truths ({', '.join(f'{count} by {engine}' for engine, count in engines.items())})."
    tables = [outcomes(results), reliability(results), coverage(results), *([of_rigs] if rigs else [])]
    before, _, rest = page.partition(BEGIN)
    body = "\n\n".join([said, *(table.as_markdown() for table in tables)])
    return f"{before}{BEGIN}\n\n{body}\n\n{END}{rest.partition(END)[2]}"


def main(arguments: Sequence[str] = ()) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.trust")
    parser.add_argument("results", type=Path, nargs="+", help="files that benchmarks.tracing wrote")
    parser.add_argument("--reports", type=Path, nargs="*", default=[], help="folders of identify, of measured rigs")
    parser.add_argument("--write", action="store_true", help="make the pictures and tables of the page")
    options = parser.parse_args(arguments)
    lines = [line for path in options.results for line in path.read_text(encoding="utf-8").splitlines()]
    results = [result for result in map(json.loads, lines) if not result["error"]]
    rigs = measured(options.reports)
    if not options.write:
        print(written("", results, rigs))
        return
    PICTURES.mkdir(exist_ok=True)
    height = 1.2 + 0.3 * len(rigs)
    for name, draw, size in (
        ("names", lambda axes: _draw_reliability(axes, results), (4.0, 3.0)),
        ("confusion", lambda axes: _draw_confusion(axes, results), (8.0, 5.6)),
        ("errors", lambda axes: _draw_errors(axes, results), (6.0, 3.0)),
        ("coverage", lambda axes: _draw_coverage(axes, results), (4.0, 3.0)),
        ("measured", lambda axes: _draw_measured(axes, rigs), (6.0, height)),
    ):
        (PICTURES / f"{name}.svg").write_bytes(picture(draw, size))
    PAGE.write_text(written(PAGE.read_text(encoding="utf-8"), results, rigs), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1:])

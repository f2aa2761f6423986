"""What is needed to repeat a run, as parts of a document."""

import shlex
from collections.abc import Iterator
from typing import Any

from cdp_ident.report.parts import Code, Parts, Row, Sentences, Table
from cdp_ident.report.schema import Section
from cdp_ident.report.wording import role_words, weights_words


def to_repeat(report: Section) -> Parts:
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

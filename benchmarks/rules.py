# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What each rule is worth: hidden truths examined with it and without it.

`python -m benchmarks.rules --count 200 --first 530000` examines the same fresh truths with all rules and with each one
switched off; `--off "zeros by trial,replacements"` switches these alone off, `--together` all of them at once. A rule
that saves fewer than two of 200 truths has to go. The truths of a group that costs nothing together need no run of
each one alone.
"""

import argparse
import contextlib
import importlib
import json
import os
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks._scores import Score
from benchmarks._workers import each
from benchmarks.tracing import examine
from reference.kinds import combined, spread
from reference.readings import ENGINES


@dataclass(frozen=True)
class Rule:
    """A rule, and what stands in its place where it is switched off."""

    name: str
    place: str
    """Module and attribute, with dots."""
    instead: Any

    @contextlib.contextmanager
    def off(self) -> Iterator[None]:
        """Switch it off for a while."""
        module, _, path = self.place.partition(":")
        *owners, name = path.split(".")
        owner: Any = importlib.import_module(module)
        for part in owners:
            owner = getattr(owner, part)
        before = getattr(owner, name)
        setattr(owner, name, self.instead)
        try:
            yield
        finally:
            setattr(owner, name, before)


def _nothing(*_arguments: Any, **_named: Any) -> None:
    return None


def _no(*_arguments: Any, **_named: Any) -> bool:
    return False


def _yes(*_arguments: Any, **_named: Any) -> bool:
    return True


def _empty(*_arguments: Any, **_named: Any) -> Iterator[Any]:
    return iter(())


def _first(one: Any, *_others: Any, **_named: Any) -> Any:
    return one


def _as_many(readings: Any, _steps: Any) -> Any:
    return np.ones_like(readings)


RULES = (
    Rule("several at once", "cdp_ident.tracing.model_search:ModelSearch._look_ahead", _no),
    Rule("zeros by trial", "cdp_ident.tracing.model_search:ModelSearch._zeros", _no),
    Rule("extended models", "cdp_ident.tracing.neighbours:hides_more", _no),
    Rule("replacements", "cdp_ident.tracing.model_search:ModelSearch._replace", _no),
    Rule("names for a curve", "cdp_ident.tracing.model_search:ModelSearch._spell_out", _nothing),
    Rule("play is tried", "cdp_ident.tracing.select_effects:suggestions", _empty),
    Rule("names beside more than noise", "cdp_ident.tracing.trace:where_more_remains", _first),
    Rule("withdrawal", "cdp_ident.tracing.carry_over:is_worse", _no),
    Rule("windows of half a swing", "cdp_ident.pipeline.identify:_is_followed", _yes),
    Rule("values with less torque", "cdp_ident.tracing.final_model:with_less_torque", _first),
    Rule("tails of torques", "cdp_ident.likelihood.noise:Noise.with_tails", _first),
    Rule(
        "memory of noise and errors of time",
        "cdp_ident.likelihood.gauss_newton:GaussNewton._look_at_residuals",
        _nothing,
    ),
    Rule("runs of readings", "cdp_ident.likelihood.swing:weights_of_readings", _as_many),
    Rule("outliers of whole swings", "cdp_ident.likelihood.noise:_OUTLIER", np.inf),
    Rule("halved steps", "cdp_ident.likelihood.gauss_newton:_PATIENCE", 10**6),
)

Job = tuple[tuple[str, ...], str, int, str]
"""Rules that are switched off, kind, seed and engine."""


def examined_without(job: Job) -> tuple[tuple[str, ...], Score]:
    """Examine a hidden truth with some rules switched off."""
    off, kind, seed, engine = job
    with contextlib.ExitStack() as switched:
        for rule in RULES:
            if rule.name in off:
                switched.enter_context(rule.off())
        return off, examine((kind, seed, engine, None))


def _failed(job: Job, why: str) -> tuple[tuple[str, ...], Score]:
    off, kind, seed, engine = job
    return off, Score(kind, seed, engine, error=why)


def table_of(found: Sequence[tuple[tuple[str, ...], Score]]) -> Table:
    """Return for each set of rules what became worse and what better without it, beside all rules."""
    table = Table("switched off", "truths", "worse", "better", "processor time", "which became worse")
    by_off: dict[tuple[str, ...], dict[tuple[str, int, str], Score]] = {}
    for off, one in found:
        by_off.setdefault(off, {})[one.kind, one.seed, one.engine] = one
    all_rules = by_off.get((), {})
    for off, scores in by_off.items():
        both = [(all_rules[key], one) for key, one in scores.items() if key in all_rules]
        worse = [one for before, one in both if _is_right(before) and not _is_right(one)]
        better = [one for before, one in both if _is_right(one) and not _is_right(before)]
        seconds = [np.sum([one.seconds for one in of]) for of in zip(*both, strict=True)]
        table.add_row(
            ", ".join(off) or "nothing",
            str(len(scores)),
            str(len(worse)),
            str(len(better)),
            f"{seconds[1] / seconds[0]:.2f}" if both else "",
            "; ".join(f"{one.kind} {one.seed} {one.engine}: {one.verdict}" for one in worse),
        )
    return table


def _is_right(score: Score) -> bool:
    return score.verdict in ("ok", "weak")


def main(arguments: Sequence[str] = ()) -> None:
    names = [rule.name for rule in RULES]
    parser = argparse.ArgumentParser(prog="python -m benchmarks.rules")
    parser.add_argument("--count", type=int, default=200, help="size of a spread sample of all kinds")
    parser.add_argument("--combined", action="store_true", help="of two or three single effects each instead")
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--off", default=",".join(names), help="rules to switch off, with commas")
    parser.add_argument("--together", action="store_true", help="all of these at once")
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)), help="processes, of one core each")
    parser.add_argument("--limit", type=float, default=3600.0, help="a truth that takes longer is given up [s]")
    parser.add_argument("--out", type=Path, default=Path("identification/rules.jsonl"), help="file of JSON lines")
    options = parser.parse_args(arguments)
    chosen = [name.strip() for name in options.off.split(",")]
    if unknown := set(chosen) - set(names):
        parser.error(f"there is no rule {', '.join(sorted(unknown))}; there are: {', '.join(names)}")
    sets = [(), tuple(chosen)] if options.together else [(), *((name,) for name in chosen)]
    truths = (combined if options.combined else spread)(options.count, tuple(ENGINES), options.first)
    found = []
    options.out.parent.mkdir(parents=True, exist_ok=True)
    with options.out.open("w", encoding="utf-8") as file:
        jobs = [(off, *of) for of in truths for off in sets]
        for off, one in each(examined_without, jobs, options.jobs, options.limit, _failed):
            found.append((off, one))
            print(f"{', '.join(off) or 'all rules'}: {one.line}", flush=True)
            file.write(json.dumps({"off": off, **one.as_json}) + "\n")
            file.flush()
    Console(width=None if sys.stdout.isatty() else 160).print(table_of(found))


if __name__ == "__main__":
    main(sys.argv[1:])

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Hidden truths: what the package names of the effects that nobody told it of.

`python -m benchmarks.tracing --count 40` takes a spread sample of all kinds and sizes, moved by equations and by a
rigid-body engine; `--kinds sticking,magnet.inner --seeds 5` takes those; `--combined 40` takes two or three effects
each, of all that there are; `--strange` takes the laws of what is hidden out of the catalogue, so that any name is a
false one; `--weakest` looks for the weakest strength of some effects that is still found. One line is written for each
truth as it comes, everything goes into a file of JSON lines, and a table ends it.
"""

import argparse
import json
import os
import sys
import time
import traceback
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table

from benchmarks._product import catalogue_without, found
from benchmarks._scores import Score, conclusion, score, strange, summary
from benchmarks._workers import each
from reference.kinds import GROUPS, KINDS, combined, in_mujoco, spread
from reference.readings import ENGINES
from reference.truths import truth

Job = tuple[str, int, str, float | None]
"""Kind, seed, engine, and how visible its effects are to be."""

WEAKEST_KINDS = (
    "coulomb_friction.inner",
    "coulomb_friction.outer",
    "air_drag.outer",
    "joint_spring.inner",
    "cogging_torque.inner",
    "encoder_offset.outer",
    "encoder_scale.outer",
    "time_offset.outer",
)
_ALIKE = (
    {"air_drag", "quadratic_friction"},
    {"encoder_eccentricity", "encoder_harmonic", "encoder_interpolation", "oblique_view"},
    {"encoder_compliance", "encoder_filter", "rod_flex", "time_offset"},
    {"joint_spring", "constant_torque"},
    {"stribeck_friction", "presliding_friction", "load_friction", "coulomb_friction", "drifting_friction"},
    {"end_stop", "magnet"},
    {"pivot_compliance", "heavy_cart", "cart_on_spring"},
    {"gravity_tilt", "side_force", "encoder_offset"},
    {"rotor_inertia", "geared_rotor"},
)
"""Effects that are forms of one another, or the same motion to first order."""
STRONG = 1.6
"""How visible an effect is at first when its weakest strength is looked for, over the noise."""


def examine(job: Job) -> Score:
    """Make a hidden truth, have the package look at it, and only then compare with the answer."""
    kind, seed, engine, visible = job
    try:
        made = truth(kind, seed, engine, visible)
        begin = time.process_time()
        answer = found(made)
        return score(made, answer, time.process_time() - begin)
    except Exception:  # noqa: BLE001 - whatever the package does to one truth, the others go on
        return Score(kind, seed, engine, error=traceback.format_exc())


def examine_strange(job: Job) -> Score:
    """Examine a truth with all that is like what is hidden in it taken out of the catalogue."""
    hidden = {part.split(".")[0] for part in job[0].split("+")}
    alike = set[str]().union(*(group for group in _ALIKE if group & hidden))
    with catalogue_without(hidden | alike):
        return strange(examine(job))


def weakest(seeds: Sequence[int], engine: str) -> Table:
    """Return for some effects the weakest strength that is still named, halving it until it is not."""
    table = Table("hidden", "seed", "weakest strength named", "over the noise", r"noise \[mrad]", "not named")
    for kind in WEAKEST_KINDS:
        for seed in seeds:
            last: Score | None = None
            visible = STRONG
            while (now := examine((kind, seed, engine, visible))).right:
                last, visible = now, visible / 2.0
                print(now.line, flush=True)
            print(now.line, flush=True)
            named, lost = ("; ".join(s.hidden) if s else "none" for s in (last, now))
            noise = f"{1e3 * now.noise:.2f}"
            table.add_row(kind, str(seed), named, f"{last.strengths[0]['visible']:.2f}" if last else "", noise, lost)
    return table


def chosen_jobs(options: argparse.Namespace) -> list[Job]:
    """Return the truths that the command line asks for."""
    engines = tuple(ENGINES) if options.engine == "both" else (options.engine,)
    if options.combined:
        return [(*of, None) for of in combined(options.combined, engines, options.first)]
    if not options.kinds:
        return [(*of, None) for of in spread(options.count, engines, options.first)]
    kinds = [kind for name in options.kinds.split(",") for kind in GROUPS.get(name, (name,))]
    return [
        (kind, seed, engine, None)
        for kind in kinds
        for seed in range(options.first, options.first + options.seeds)
        for engine in engines
        if engine == "equations" or in_mujoco(kind)
    ]


def main(arguments: Sequence[str] = ()) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.tracing")
    parser.add_argument("--count", type=int, default=200, help="size of a spread sample of all kinds")
    parser.add_argument(
        "--kinds", default="", help=f"kinds instead, with commas: groups ({', '.join(GROUPS)}) or {KINDS[1]} and so on"
    )
    parser.add_argument("--combined", type=int, default=0, help="so many truths of two or three single effects instead")
    parser.add_argument("--seeds", type=int, default=1, help="truths of each of these kinds")
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--engine", choices=(*ENGINES, "both"), default="both", help="what moves them")
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)), help="processes, of one core each")
    parser.add_argument("--limit", type=float, default=3600.0, help="a truth that takes longer is given up [s]")
    parser.add_argument("--out", type=Path, default=Path("identification/tracing.jsonl"), help="file of JSON lines")
    parser.add_argument("--strange", action="store_true", help="take what is hidden out of the catalogue")
    parser.add_argument("--weakest", action="store_true", help="look for the weakest strength that is found")
    options = parser.parse_args(arguments)
    console = Console(width=None if sys.stdout.isatty() else 140)
    if options.weakest:
        engine = "equations" if options.engine == "both" else options.engine
        console.print(weakest(range(options.first, options.first + options.seeds), engine))
        return
    scores, looked_at = [], examine_strange if options.strange else examine
    options.out.parent.mkdir(parents=True, exist_ok=True)
    with options.out.open("w", encoding="utf-8") as file:
        for result in each(looked_at, chosen_jobs(options), options.jobs, options.limit, _failed):
            scores.append(result)
            print(result.line, flush=True)
            file.write(json.dumps(result.as_json) + "\n")
            file.flush()
    console.print(summary(scores))
    console.print(conclusion(scores))


def _failed(job: Job, why: str) -> Score:
    kind, seed, engine, _ = job
    return Score(kind, seed, engine, error=why)


if __name__ == "__main__":
    main(sys.argv[1:])

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Results that are kept as they come, so that a run that was interrupted goes on where it ended."""

import argparse
import json
import os
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from benchmarks._workers import each

Kept = dict[str, Any]
"""A result as a line of JSON; its `job` says what it is the result of."""


def kept(work: Callable[[str], Kept], jobs: Sequence[str], path: Path, limit: float, count: int = 0) -> Iterator[Kept]:
    """Yield the results of jobs: those that a file of JSON lines has, then others, which are added to it.

    Args:
        work: a function of a module, from a job to its result.
        jobs: each stands for itself in one line.
        path: the file; it need not be there.
        limit: a job that takes longer is given up [s].
        count: processes of one core each; 0 for all cores.
    """
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    done = {result["job"]: result for result in map(json.loads, lines)}
    yield from (done[job] for job in jobs if job in done)
    missing = [job for job in jobs if job not in done]
    if not missing:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a", encoding="utf-8") as file:
        for result in each(work, missing, count or len(os.sched_getaffinity(0)), limit, _failed):
            if "error" in result:
                print(f"{result['job']}: {result['error']}", flush=True)
                continue
            file.write(json.dumps(result) + "\n")
            file.flush()
            yield result


def add_arguments(parser: argparse.ArgumentParser, limit: float) -> None:
    """Add what every benchmark that keeps its results takes; the file is named after it.

    Args:
        parser: of `python -m benchmarks.NAME`.
        limit: a job that takes longer is given up [s], unless another limit is asked for.
    """
    out = Path("identification", f"{parser.prog.rpartition('.')[2]}.jsonl")
    parser.add_argument("--jobs", type=int, default=0, help="processes, of one core each; 0 for all cores")
    parser.add_argument("--limit", type=float, default=limit, help="a run that takes longer is given up [s]")
    parser.add_argument("--out", type=Path, default=out, help="what it has is kept")


def _failed(job: str, why: str) -> Kept:
    return {"job": job, "error": why}

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A survey by one worker process and by two: how much of the second is gained.

The bags of two rigs are surveyed bag by bag. Efficiency is the time that one worker takes over twice the time that two
take, the start of the processes included. Where other programs want the cores too it says more about those; what it is
by CPU time, as it would be on idle cores, stands beside it.
"""

import argparse
import os
import statistics
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage

from rich.console import Console
from rich.table import Table

from cdp_ident.survey.run import conduct, plan
from cdp_ident.survey.workers import processes
from scenarios.fleet import write_fleet


def timed(trials: Path, out: Path, count: int) -> tuple[float, float]:
    """Survey the bags with so many workers; return the time that passed and the CPU time that the workers took [s]."""
    begin, before = time.perf_counter(), _cpu_time()
    with processes(count) as executor:
        finished = list(conduct(plan([trials], out, "bag", {}, anew=True), executor))
    assert not any(piece.problem for piece in finished)
    return time.perf_counter() - begin, _cpu_time() - before


def _cpu_time() -> float:
    """Return the CPU time of all processes that this one has started and that have ended [s]."""
    used = getrusage(RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main(arguments: Sequence[str] = ()) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.survey")
    parser.add_argument("--bags", type=int, default=12, help="of each of the two rigs")
    parser.add_argument("--repeats", type=int, default=3, help="of both, by turns; medians are told")
    options = parser.parse_args(arguments)
    taken: dict[int, list[tuple[float, float]]] = {1: [], 2: []}
    with tempfile.TemporaryDirectory() as folder:
        trials = Path(folder) / "trials"
        write_fleet(trials, {"rig1": options.bags, "rig2": options.bags}, {})
        for _ in range(options.repeats):
            for count, times in taken.items():
                times.append(timed(trials, Path(folder) / "out", count))
    table = Table("workers", r"time \[s]", r"CPU \[s]", "cores that they had", "efficiency", "by CPU time")
    median = {
        count: [statistics.median(column) for column in zip(*times, strict=True)] for count, times in taken.items()
    }
    for count, (passed, used) in median.items():
        efficiency, by_cpu_time = median[1][0] / (count * passed), median[1][1] / used
        numbers = f"{passed:.1f}", f"{used:.1f}", f"{used / passed:.2f}", f"{efficiency:.2f}", f"{by_cpu_time:.2f}"
        table.add_row(str(count), *numbers)
    console = Console()
    console.print(table)
    console.print(f"{2 * options.bags} bags; load of this computer meanwhile: {os.getloadavg()[1]:.1f}")


if __name__ == "__main__":
    main(sys.argv[1:])

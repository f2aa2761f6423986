# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How long one waits.

From the command to the first line of progress, to the result, and to the end: `identify --once --bag
bags/swing_folded`, in which dry friction is hidden, with an empty folder for compiled code, as where no build has
filled it, and with that folder filled. The time that passes is that of a machine as busy as this one was; the CPU time
is that of all threads, and of children that have ended. Beside it stands what a script of one's own takes to load
libraries.
"""

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks._tables import Table, number

ROOT = Path(__file__).parents[1]
BAG = ROOT / "bags" / "swing_folded"
WARM_RUNS = 3
SCRIPTS = (
    "import scipy.integrate, scipy.optimize, matplotlib.figure, rosbags.highlevel",
    "import mujoco, mujoco.rollout",
)
"""What scripts of one's own would begin with."""
FIRST, RESULT, END = "first line of progress", "result on the terminal", "report written"
RESULT_BEGINS = "Trials"
_TICKS = os.sysconf("SC_CLK_TCK")


@dataclass(frozen=True)
class Moment:
    """What has gone by until something showed."""

    passed: float
    """Time [s]."""
    used: float
    """CPU time [s]."""


def tables(quick: bool = False) -> list[Table]:
    """Start the command once with an empty folder for compiled code, then with a full one; a quick run, once."""
    warm_runs = 1 if quick else WARM_RUNS
    with tempfile.TemporaryDirectory() as cache:
        cold = identified(Path(cache))
        warm = [identified(Path(cache)) for _ in range(warm_runs)]
    rows = [(f"`identify`: {name}", *_words([cold[name]]), *_words([run[name] for run in warm])) for name in cold]
    for script in SCRIPTS:
        loaded = [watched([sys.executable, "-c", script], os.environ)[END] for _ in range(warm_runs + 1)]
        rows.append((f"`python -c '{script}'`", "", "", *_words(loaded[1:])))
    columns = ("until", "empty folder [s]", "CPU [s]", "filled [s]", "CPU [s]")
    return [Table("From the command on", columns, rows)]


def identified(cache: Path) -> dict[str, Moment]:
    """Identify with a folder for compiled code."""
    with tempfile.TemporaryDirectory() as out:
        command = [sys.executable, "-m", "cdp_ident", "identify", "--once", "--bag", str(BAG), "--out", f"{out}/report"]
        return watched(command, {**os.environ, "NUMBA_CACHE_DIR": str(cache)})


def watched(command: Sequence[str], environment: Mapping[str, str]) -> dict[str, Moment]:
    """Run a command, and return when it said something first, when its result came, if it has one, and when it ended.

    Raises:
        CalledProcessError: it failed.
    """
    moments: dict[str, Moment] = {}
    begin = time.perf_counter()
    with subprocess.Popen(
        command, cwd=ROOT, env={**environment, "PYTHONUNBUFFERED": "1"}, stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT, text=True,
    ) as process:  # fmt: skip

        def note(name: str) -> None:
            moments.setdefault(name, Moment(time.perf_counter() - begin, _cpu_time(process.pid)))

        assert process.stdout is not None
        for line in process.stdout:
            note(FIRST)
            if line.startswith(RESULT_BEGINS):
                note(RESULT)
        os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)  # its CPU time can be read until it is waited for
        note(END)
    if process.returncode:
        raise subprocess.CalledProcessError(process.returncode, command)
    return moments


def _cpu_time(process: int) -> float:
    """Return the CPU time of a process so far, with its children that have ended [s]."""
    after_name = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    return sum(map(int, after_name[11:15])) / _TICKS


def _words(moments: Sequence[Moment]) -> tuple[str, str]:
    return (
        number(statistics.median(moment.passed for moment in moments)),
        number(statistics.median(moment.used for moment in moments)),
    )

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Work for processes, which find a function by the name of its module."""

import math
import os
import signal
from pathlib import Path

from cdp_ident.machine.parallel import core_count


def root_or_death(job: tuple[float, Path]) -> float:
    """Return a square root; that of 0 takes its process down at first, and notes it in a file."""
    number, died = job
    if number == 0 and not died.exists():
        died.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return math.sqrt(number)


def length_of_a_name(job: str) -> dict[str, str | int]:
    """Return how long a job's name is, as what is kept of it; that of "bad" fails."""
    if job == "bad":
        raise ValueError(job)
    return {"job": job, "length": len(job)}


def cores_and_threads(_: object) -> tuple[int, str | None]:
    """Return how many cores work is divided among, and how many threads linear algebra may use."""
    return core_count(), os.environ.get("OPENBLAS_NUM_THREADS")

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Work in processes of one core each, of which one that dies or hangs costs its own piece alone."""

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from cdp_ident.survey import workers

Job = TypeVar("Job")
Result = TypeVar("Result")

LIMIT = 900.0
"""What takes longer alone is given up [s]."""


def each(
    work: Callable[[Job], Result],
    jobs: Sequence[Job],
    count: int,
    limit: float,
    failed: Callable[[Job, str], Result],
) -> Iterator[Result]:
    """Yield the result of each job as it comes, from so many processes; one that takes longer [s] is given up."""
    with workers.processes(max(1, min(count, len(jobs))), limit) as executor:
        yield from workers.each(executor, work, jobs, failed)


def alone(work: Callable[[], Result]) -> Result:
    """Return the result of one piece of work, in a process of its own.

    Raises:
        RuntimeError: the process died, or took too long.
    """
    results: Iterator[Result] = each(_called, [work], 1, LIMIT, _give_up)
    return next(results)


def _called(work: Callable[[], Result]) -> Result:
    return work()


def _give_up(work: Callable[[], Result], why: str) -> Result:
    raise RuntimeError(why)

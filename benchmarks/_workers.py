"""Truths in processes of one core each, of which one that dies or hangs costs its own truth alone."""

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from cdp_ident.survey import workers

Job = TypeVar("Job")
Result = TypeVar("Result")


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

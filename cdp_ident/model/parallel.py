"""Work divided among the cores, for compiled loops that hold no Python lock."""

import functools
import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

_uses_one_core = False


@functools.cache
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(max_workers=core_count(), thread_name_prefix="cdp_ident")


def core_count() -> int:
    """Return how many cores this process may use."""
    return 1 if _uses_one_core else len(os.sched_getaffinity(0))


def use_one_core() -> None:
    """Use one core only in this process: it is one of several that share the cores."""
    global _uses_one_core  # noqa: PLW0603 - of the process, as its cores are
    _uses_one_core = True


def parallel_for(work: Callable[[int, int], None], count: int) -> None:
    """Call `work(first, last)` on consecutive parts of `range(count)`, one part a core, and wait for all of them.

    Which part an item falls into must not matter to its result; then neither does the number of cores.
    """
    parts = min(core_count(), count)
    if parts <= 1:
        work(0, count)
        return
    bounds = [count * part // parts for part in range(parts + 1)]
    futures = [_pool().submit(work, first, last) for first, last in pairwise(bounds[1:])]
    work(bounds[0], bounds[1])
    for future in futures:
        future.result()

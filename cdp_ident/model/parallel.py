"""Work divided among the cores, for compiled loops that hold no Python lock."""

import functools
import os
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")

_uses_one_core = False
_thread = threading.local()


@functools.cache
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(max_workers=core_count(), thread_name_prefix="cdp_ident")


def core_count() -> int:
    """Return how many cores the calling thread may use."""
    alone = _uses_one_core or getattr(_thread, "has_one_core", False)
    return 1 if alone else len(os.sched_getaffinity(0))


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


def parallel_map(function: Callable[[Item], Result], items: Sequence[Item]) -> Iterator[Result]:
    """Yield what a function returns for each item, in their order; as many are worked on at a time as there are cores.

    Each call has one core to itself. What a call raises is raised in its turn; calls that have not begun are given up.
    """
    if min(core_count(), len(items)) <= 1:
        yield from map(function, items)
        return
    futures = [_pool().submit(_on_one_core, function, item) for item in items]
    try:
        for future in futures:
            yield future.result()
    finally:
        for future in futures:
            future.cancel()


def _on_one_core(function: Callable[[Item], Result], item: Item) -> Result:
    _thread.has_one_core = True
    try:
        return function(item)
    finally:
        _thread.has_one_core = False

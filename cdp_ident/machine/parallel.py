# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Work divided among the cores, for compiled loops that hold no Python lock."""

import functools
import os
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from itertools import pairwise
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")

_uses_one_core = False
_thread = threading.local()


@functools.cache
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(core_count(), "cdp_ident", initializer=lambda: setattr(_thread, "is_of_pool", True))


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
    parts = max(1, min(core_count(), count))
    bounds = [count * part // parts for part in range(parts + 1)]
    for _ in _shared_out([functools.partial(work, first, last) for first, last in pairwise(bounds)], takes_part=True):
        pass


def parallel_map(function: Callable[[Item], Result], items: Sequence[Item]) -> Iterator[Result]:
    """Yield what a function returns for each item, in their order; as many are worked on at a time as there are cores.

    What a call raises is raised in its turn; calls that have not begun are given up. So that a result is there as soon
    as it can be, and the others may be given up for it, this thread only waits for them, unless it is one of the pool.
    """
    calls = [functools.partial(function, item) for item in items]
    yield from _shared_out(calls, takes_part=getattr(_thread, "is_of_pool", False))


def _shared_out(calls: Sequence[Callable[[], Result]], takes_part: bool) -> Iterator[Result]:
    """Yield what calls return, in their order, made by threads that have nothing else to do, and by this one.

    Calls may share out work themselves: cores that have no call left take part in that of the others. No thread of the
    pool waits for a call that has not begun, so none can wait for another for ever.
    """
    if min(core_count(), len(calls)) <= 1:
        yield from (call() for call in calls)
        return
    futures: list[Future[Result]] = [Future() for _ in calls]
    # Each is in a list of its own, which whoever makes it empties: the pool's queue keeps nothing else of it.
    waiting = [[each] for each in zip(calls, futures, strict=True)]
    for one in waiting:
        _pool().submit(_make, one)
    try:
        for place, future in enumerate(futures):
            for one in waiting[place:] if takes_part else []:
                if future.done():
                    break
                _make(one)  # this one, or a later one while another thread is at it
            yield future.result()
    finally:
        for one in waiting:
            one.clear()


def _make(waiting: "list[tuple[Callable[[], Result], Future[Result]]]") -> None:
    """Make a call, unless another thread has begun to, or it was given up."""
    try:
        call, future = waiting.pop()
    except IndexError:
        return
    try:
        future.set_result(call())
    except BaseException as error:
        future.set_exception(error)  # which is raised in its turn
        if not isinstance(error, Exception):
            raise

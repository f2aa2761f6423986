# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How long something takes."""

import statistics
import time
from collections.abc import Callable, Mapping


def taking_turns(works: Mapping[str, Callable[[], object]], rounds: int = 9) -> dict[str, float]:
    """Return the CPU time that each takes in the median of so many rounds [s].

    They take turns, so that what else the machine does meets all of them. A first call is not counted.
    """
    taken: dict[str, list[float]] = {name: [] for name in works}
    for work in works.values():
        work()
    for _ in range(rounds):
        for name, work in works.items():
            begin = time.process_time()
            work()
            taken[name].append(time.process_time() - begin)
    return {name: statistics.median(times) for name, times in taken.items()}

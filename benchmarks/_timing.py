"""How long something takes."""

import math
import time
from collections.abc import Callable


def seconds(work: Callable[[], object], at_least: float = 0.3) -> float:
    """Return the shortest of several runs [s], which go on for `at_least` seconds; a first run is not counted.

    The shortest is the one that other work on the machine disturbed least.
    """
    work()
    shortest, since = math.inf, time.perf_counter()
    while time.perf_counter() - since < at_least:
        begin = time.perf_counter()
        work()
        shortest = min(shortest, time.perf_counter() - begin)
    return shortest

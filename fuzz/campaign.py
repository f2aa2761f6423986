# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A campaign: cases drawn from a seed, each of which keeps a promise or is a finding."""

import random
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field

Case = Callable[[random.Random], str]
"""Tries one input; returns in a word or two what became of it, and raises whatever breaks the promise."""


class FindingError(Exception):
    """A promise was broken without an error: something wrong was believed."""


@dataclass
class Tally:
    """What became of the cases of one campaign."""

    name: str
    outcomes: Counter[str] = field(default_factory=Counter)
    findings: list[str] = field(default_factory=list)
    """Each with the seed that brings it back."""


def run(name: str, case: Case, seed: int, cases: int, seconds: float) -> Tally:
    """Try so many cases of a campaign, or as many as fit into so many seconds."""
    tally, end = Tally(name), time.monotonic() + seconds
    for number in range(cases):
        if time.monotonic() > end:
            break
        key = f"{name} {seed} {number}"
        try:
            tally.outcomes[case(random.Random(key))] += 1
        except Exception as error:  # noqa: BLE001 - any error that is not the promised one is what is looked for
            tally.outcomes["FINDING"] += 1
            tally.findings.append(f"{key!r}: {type(error).__name__}: {error}"[:500])
    return tally

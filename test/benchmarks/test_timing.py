# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Works take turns."""

from benchmarks._timing import taking_turns


def test_works_take_turns_and_all_are_timed():
    called = []
    works = {name: lambda name=name: called.append(name) for name in "ab"}
    taken = taking_turns(works, rounds=3)
    assert "".join(called) == "ab" * 4
    assert list(taken) == ["a", "b"]
    assert all(time >= 0.0 for time in taken.values())

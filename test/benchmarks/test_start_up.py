# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How long a command lets one wait."""

import os
import subprocess
import sys

import pytest

from benchmarks.start_up import END, FIRST, RESULT, watched

BUSY = "sum(i * i for i in range(2_000_000))"  # many ticks of the clock of CPU time
COMMAND = f"print('searching'); {BUSY}; print('Trials'); {BUSY}; print('more')"


def test_moments_follow_one_another():
    moments = watched([sys.executable, "-c", COMMAND], os.environ)
    assert list(moments) == [FIRST, RESULT, END]
    passed, used = ([getattr(moment, part) for moment in moments.values()] for part in ("passed", "used"))
    assert sorted(passed) == passed
    assert 0.0 <= used[0] < used[1] < used[2]


def test_what_says_nothing_only_ends():
    assert list(watched([sys.executable, "-c", "pass"], os.environ)) == [END]


def test_a_command_that_fails_is_no_result():
    with pytest.raises(subprocess.CalledProcessError):
        watched([sys.executable, "-c", "raise SystemExit(3)"], os.environ)

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Truths are looked at in processes."""

import functools
import math
import os
import time

import pytest

from benchmarks._workers import alone, each


def failed(job, why):
    return f"{job}: {why}"


def test_each_truth_is_looked_at_once():
    assert sorted(each(math.sqrt, [1.0, 4.0, 9.0], 2, 60.0, failed)) == [1.0, 2.0, 3.0]


def test_one_that_takes_too_long_is_given_up():
    assert list(each(time.sleep, [600.0], 8, 2.0, failed)) == ["600.0: there was no result after 2 s"]


def test_a_piece_alone_has_a_process_of_its_own_and_what_it_raises_is_raised():
    assert alone(os.getpid) != os.getpid()
    with pytest.raises(RuntimeError, match="math domain error"):
        alone(functools.partial(math.sqrt, -1.0))

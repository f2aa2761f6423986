# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Freed memory is kept for what is computed next."""

import platform
import subprocess
import sys

import pytest

COUNTED = """
import resource
import sys
import threading
import numpy as np
from cdp_ident.memory import keep_freed_memory

def touch(rounds):
    for _ in range(rounds):
        arrays = [np.empty(30_000) for _ in range(20)]
        for array in arrays:
            array.fill(1.0)
        del array, arrays

def pages(rounds):
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    touch(rounds)
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before

def count():
    print(pages(1), pages(100))

if sys.argv[1] == "keep":
    keep_freed_memory()
thread = threading.Thread(target=count)
thread.start()
thread.join()
"""


def _pages(whether):
    command = [sys.executable, "-c", COUNTED, whether]
    done = subprocess.run(command, check=True, capture_output=True, text=True, timeout=300)
    return [int(count) for count in done.stdout.split()]


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="other C libraries cannot be told so")
def test_arrays_get_the_pages_of_those_before_them():
    first, later = _pages("keep")
    # Twenty arrays of 240 kB have some thousand pages of 4 kB.
    assert first > 500
    assert later < 2 * first

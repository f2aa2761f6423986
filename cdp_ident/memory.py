# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What becomes of freed memory.

Arrays of some hundred kilobytes come and go all the time. Where the C library gives each back to the system, getting
empty pages again takes as long as half of what is computed in them.
"""

import contextlib
import ctypes

_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3
"""What `mallopt` sets, by glibc's numbers; other C libraries have no such function."""
_KEPT = 1 << 28
"""So much free memory is kept at most by each thread [B]."""
_LARGEST_KEPT = 1 << 25
"""Pieces larger than this are given back at once [B]; glibc allows no more."""


def keep_freed_memory() -> None:
    """Keep freed memory for what is computed next in this process, where the C library can be told so."""
    with contextlib.suppress(AttributeError, OSError):
        library = ctypes.CDLL(None)
        library.mallopt(_TRIM_THRESHOLD, _KEPT)
        library.mallopt(_MMAP_THRESHOLD, _LARGEST_KEPT)

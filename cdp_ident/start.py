# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Starts an executable of the table by its name: the console scripts, and `python3 -m cdp_ident`.

Its modules take a second to be loaded. Ctrl-C in that time ends the program in one line like at any other.

The package divides its work among the cores itself (`cdp_ident.machine.parallel`); the threads of numpy's linear
algebra would compete with ours for them, and small matrices take twenty times as long then. They are counted when numpy
is loaded, so it is set here.

What loading makes stays until the end: to search it for garbage, meanwhile and ever after, would take a sixth of the
time that it takes to load, and find nothing.
"""

import contextlib
import ctypes
import functools
import gc
import importlib
import os
import signal
from collections.abc import Iterator

from cdp_ident.command_line import EXIT_INTERRUPTED, make_tolerant
from cdp_ident.executables import EXECUTABLES

_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3
"""What `mallopt` sets, by glibc's numbers; other C libraries have no such function."""
_KEPT, _LARGEST_KEPT = 1 << 28, 1 << 25
"""Free memory that each thread keeps at most, and the largest piece of it; glibc allows none larger [B]."""


def keep_freed_memory() -> None:
    """Keep freed memory for what is computed next in this process, where the C library can be told so.

    Arrays of some hundred kilobytes come and go all the time. Where each is given back to the system, getting empty
    pages again takes as long as half of what is computed in them.
    """
    with contextlib.suppress(AttributeError, OSError):
        library = ctypes.CDLL(None)
        library.mallopt(_TRIM_THRESHOLD, _KEPT)
        library.mallopt(_MMAP_THRESHOLD, _LARGEST_KEPT)


os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
keep_freed_memory()


def start(name: str) -> int:
    """Run an executable with the arguments of this process; return its exit code."""
    make_tolerant()
    with loading(name):
        module = importlib.import_module(EXECUTABLES[name])
    try:
        return int(module.main())
    finally:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # as Python ends, there is nothing left to interrupt


@contextlib.contextmanager
def loading(name: str) -> Iterator[None]:
    """Load modules of an executable: what takes long, after its arguments are read."""

    def end(_number: int, _frame: object) -> None:
        # Raised as an exception it could come out of a half loaded library as any other.
        os.write(2, f"{name}: interrupted\n".encode())
        os._exit(EXIT_INTERRUPTED)

    before = signal.getsignal(signal.SIGINT)
    if before is not signal.SIG_IGN:
        signal.signal(signal.SIGINT, end)
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()
        signal.signal(signal.SIGINT, before)


globals().update({name: functools.partial(start, name) for name in EXECUTABLES})

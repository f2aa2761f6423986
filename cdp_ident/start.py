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
import functools
import gc
import importlib
import os
import signal
from collections.abc import Iterator

from cdp_ident.executables import EXECUTABLES
from cdp_ident.memory import keep_freed_memory
from cdp_ident.standard_streams import make_tolerant

_INTERRUPTED = 130

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
        os._exit(_INTERRUPTED)

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

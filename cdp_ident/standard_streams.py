# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Standard output and error that never stop a program: what cannot be written there is left out, and why is kept."""

import io
import os
import sys
from typing import Any, TextIO


class _Tolerant(io.FileIO):
    """A file that seems to take everything."""

    problem: OSError | None = None
    """Why the rest of what was written is left out."""

    def write(self, data: Any) -> int:
        if self.problem is None:
            try:
                return super().write(data)
            except OSError as error:
                self.problem = error
        return len(data)


def make_tolerant() -> None:
    """Let the program go on where its output goes to a full disk, a reader that went away, or nowhere.

    Descriptors 0 to 2 that are closed are opened onto nothing, else the next file that is opened would be one of
    them, and be written into. Characters that the output's encoding does not have are written as escapes.
    """
    for descriptor in range(3):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest number that is free
    sys.stdout, sys.stderr = _tolerant(sys.stdout, 1), _tolerant(sys.stderr, 2)


def _tolerant(stream: TextIO | None, descriptor: int) -> TextIO:
    if stream is not None:
        stream.flush()
    raw = _Tolerant(descriptor, "w", closefd=False)
    return io.TextIOWrapper(
        io.BufferedWriter(raw),
        encoding=stream.encoding if stream is not None else "utf-8",
        errors="backslashreplace",
        line_buffering=raw.isatty() or descriptor == 2,
    )


def output_problem() -> str:
    """Return why not all of the output could be written; empty where it was, or where its reader went away."""
    sys.stdout.flush()
    raw = getattr(getattr(sys.stdout, "buffer", None), "raw", None)
    problem = raw.problem if isinstance(raw, _Tolerant) else None
    return "" if problem is None or isinstance(problem, BrokenPipeError) else problem.strerror or str(problem)

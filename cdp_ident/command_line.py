# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What every executable of the package shares: how it reads its arguments, how it writes, and how it ends."""

import argparse
import functools
import io
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import fields
from typing import Any, NoReturn, TextIO, TypeVar

from cdp_ident.errors import CdpIdentError, OptionError
from cdp_ident.outside_text import shown

EXIT_BAD_INPUT = CdpIdentError.exit_code
EXIT_INTERRUPTED = 130
_LONGEST_ERROR = 2000
_Kind = TypeVar("_Kind")
_OF_SYSTEM = ("new thread", "null byte")
"""Words by which errors that are of no kind of their own tell that the system refuses something."""


class ArgumentParser(argparse.ArgumentParser):
    """The arguments of one executable: its help is printed as written, and an error is one line like every other."""

    def __init__(self, name: str, description: str, epilog: str = "") -> None:
        super().__init__(
            prog=name,
            description=description,
            epilog=epilog,
            formatter_class=argparse.RawDescriptionHelpFormatter,
            allow_abbrev=False,
        )

    def parse_args(self, args: Sequence[str], namespace: None = None) -> argparse.Namespace:  # type: ignore[override]
        """Parse arguments without those for ROS, which launch files give to every program."""
        return super().parse_args(split_arguments(args)[0], namespace)

    def error(self, message: str) -> NoReturn:
        """Raise `OptionError`, where argparse would print its usage and exit."""
        raise OptionError(f"{message} ({self.prog} --help tells more)")


def made_of(options: argparse.Namespace, kind: type[_Kind]) -> _Kind:
    """Return a dataclass whose fields are options of their names."""
    return kind(**{field.name: getattr(options, field.name) for field in fields(kind)})  # type: ignore[arg-type]


def within(least: float, most: float, kind: Callable[[str], float] = float) -> Callable[[str], float]:
    """Return a reader of an option that is a number within limits."""

    def number(text: str) -> float:
        value = kind(text)
        if not least <= value <= most:
            raise argparse.ArgumentTypeError(f"{text} is not a number from {least:.10g} to {most:.10g}")
        return value + 0  # -0.0 is 0.0

    return number


def split_arguments(arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return a program's own arguments, and what stands between `--ros-args` and `--`, however often.

    ROS is given nothing but its own: a path among the others need not be UTF-8, as all of ROS's texts are.
    """
    own: list[str] = []
    of_ros: list[str] = []
    inside = False
    for argument in arguments:
        if argument == "--ros-args" or (inside and argument == "--"):
            inside = argument == "--ros-args"
        else:
            (of_ros if inside else own).append(argument)
    return own, of_ros


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


def entry_point(body: Callable[[list[str]], int | None]) -> Callable[[Sequence[str] | None], int]:
    """Make the entry point of an executable from its body.

    The body takes the arguments after the executable's name and may return an exit code. Bad input, which the body
    reports by raising a `CdpIdentError`, ends as one line on stderr and the error's exit code, never as a traceback. So
    does what the file system, an encoding or the system refuses, which the body need not foresee: names of files that
    are too long, memory, threads.
    """
    name = body.__module__.rpartition(".")[2]

    @functools.wraps(body)
    def main(arguments: Sequence[str] | None = None) -> int:
        try:
            code = body(list(sys.argv[1:] if arguments is None else arguments)) or 0
            if problem := output_problem():
                raise OptionError(f"not all output could be written: {problem}")
        except CdpIdentError as error:
            print(f"{name}: error: {shown(error, _LONGEST_ERROR)}", file=sys.stderr)
            return error.exit_code
        except (OSError, ValueError, MemoryError, RuntimeError) as error:
            of_system = isinstance(error, OSError | UnicodeError | MemoryError)
            if not of_system and not any(words in str(error) for words in _OF_SYSTEM):
                raise
            file = getattr(error, "filename", None)
            reason = f"{file}: {error.strerror}" if isinstance(error, OSError) and file is not None else error
            reason = str(reason) or "the memory does not suffice"
            print(f"{name}: error: {shown(reason, _LONGEST_ERROR)}", file=sys.stderr)
            return EXIT_BAD_INPUT
        except KeyboardInterrupt:
            print(f"{name}: interrupted", file=sys.stderr)
            return EXIT_INTERRUPTED
        return code

    return main

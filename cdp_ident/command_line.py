"""What every executable of the package shares: how it reads its arguments, and how it ends."""

import argparse
import functools
import os
import sys
from collections.abc import Callable, Sequence
from typing import NoReturn

from cdp_ident.errors import CdpIdentError, OptionError

EXIT_BAD_INPUT = CdpIdentError.exit_code
EXIT_INTERRUPTED = 130


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

    def error(self, message: str) -> NoReturn:
        """Raise `OptionError`, where argparse would print its usage and exit."""
        raise OptionError(f"{message} ({self.prog} --help tells more)")


def entry_point(body: Callable[[list[str]], int]) -> Callable[[Sequence[str] | None], int]:
    """Make the entry point of an executable from its body.

    The body takes the arguments after the executable's name and returns the exit code. Bad input, which the body
    reports by raising a `CdpIdentError`, ends as one line on stderr and the error's exit code, never as a traceback.
    """
    name = body.__module__.rpartition(".")[2]

    @functools.wraps(body)
    def main(arguments: Sequence[str] | None = None) -> int:
        try:
            return body(list(sys.argv[1:] if arguments is None else arguments))
        except CdpIdentError as error:
            print(f"{name}: error: {' '.join(str(error).split())}", file=sys.stderr)
            return error.exit_code
        except KeyboardInterrupt:
            print(f"{name}: interrupted", file=sys.stderr)
            return EXIT_INTERRUPTED
        except BrokenPipeError:
            # The reader of our output went away (`| head`): nothing more can be said, not even at exit.
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            return 0

    return main

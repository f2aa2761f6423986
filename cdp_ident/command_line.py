"""What every executable of the package shares: how it reads its arguments, and how it ends."""

import argparse
import functools
import sys
from collections.abc import Callable, Sequence
from typing import NoReturn

from cdp_ident.errors import CdpIdentError, OptionError
from cdp_ident.outside_text import shown
from cdp_ident.standard_streams import output_problem

EXIT_BAD_INPUT = CdpIdentError.exit_code
EXIT_INTERRUPTED = 130
_LONGEST_ERROR = 2000


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
            code = body(list(sys.argv[1:] if arguments is None else arguments))
            if problem := output_problem():
                raise OptionError(f"not all output could be written: {problem}")
        except CdpIdentError as error:
            print(f"{name}: error: {shown(error, _LONGEST_ERROR)}", file=sys.stderr)
            return error.exit_code
        except KeyboardInterrupt:
            print(f"{name}: interrupted", file=sys.stderr)
            return EXIT_INTERRUPTED
        return code

    return main

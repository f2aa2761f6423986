# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Run the benchmarks: `python -m benchmarks [NAME …] [--quick]`; without a name, make docs/benchmarks.md anew."""

import argparse
import importlib
import os
import sys

from rich.console import Console

from benchmarks._page import COMPARISONS, PAGE, Section, page, section, surroundings, topics
from cdp_ident.errors import OptionError
from cdp_ident.user_input import refuse_unknown


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"one of {', '.join(topics())}")
    parser.add_argument("--quick", action="store_true", help="take few seeds")
    options = parser.parse_args(arguments)
    try:
        refuse_unknown(options.names, topics(), "benchmark")
    except OptionError as error:
        print(f"benchmarks: error: {error}", file=sys.stderr)
        return 2
    console, load = Console(width=None if sys.stdout.isatty() else 160), os.getloadavg()[0]
    done: list[Section] = []
    for topic in options.names or COMPARISONS:
        console.rule(f"[bold]{topic}", align="left")
        if topic in COMPARISONS:
            done.append(section(topic, options.quick))
            _show(done[-1], console)
        else:
            importlib.import_module(f"benchmarks.{topic}").main()
    if not options.names:
        PAGE.write_text(page(done, surroundings(load, options.quick)), encoding="utf-8")
        console.print(f"{PAGE} is written")
    return 1 if any(one.failure for one in done) else 0


def _show(one: Section, console: Console) -> None:
    """Print a comparison."""
    console.print(f"{one.heading}\n\n{one.text}\n", highlight=False, markup=False)
    for table in one.tables:
        console.print(table.for_terminal())
    if one.failure:
        console.print(f"no result: {one.failure}", markup=False)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

"""Run the benchmarks: `python -m benchmarks [NAME …]`; without a name all of them, those that take long cut short."""

import importlib
import pkgutil
import sys

from rich.console import Console

import benchmarks
from cdp_ident.errors import OptionError
from cdp_ident.user_input import refuse_unknown


def main(chosen: list[str]) -> int:
    topics = [module.name for module in pkgutil.iter_modules(benchmarks.__path__) if not module.name.startswith("_")]
    try:
        refuse_unknown(chosen, topics, "benchmark")
    except OptionError as error:
        print(f"benchmarks: error: {error}", file=sys.stderr)
        return 2
    for topic in chosen or topics:
        module = importlib.import_module(f"benchmarks.{topic}")
        summary = (module.__doc__ or "").partition("\n")[0]
        Console().rule(f"[bold]{topic}[/bold] · {summary}", align="left")
        run = module.main if chosen else getattr(module, "short", module.main)
        run()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The page of all comparisons, docs/benchmarks.md, and what a comparison is: a module with `tables`.

The first line of a module's docstring is its heading, the rest its introduction.
"""

import ast
import importlib
import importlib.metadata
import os
import pkgutil
import platform
import subprocess
import traceback
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path

import benchmarks
from benchmarks import _compiled_c
from benchmarks._tables import Table
from cdp_ident.machine.parallel import core_count

PAGE = Path(__file__).parents[1] / "docs" / "benchmarks.md"
COMPARISONS = ("search", "bag", "simulation", "cost", "start_up")
"""In the order of the page; the other modules are studies, which are run by name."""
_VERSIONS = ("numpy", "scipy", "numba", "mujoco", "cma", "casadi")


@dataclass(frozen=True)
class Section:
    """One comparison."""

    heading: str
    text: str
    tables: Sequence[Table] = ()
    failure: str = ""
    """Why there is no result, in a line."""

    def as_markdown(self) -> str:
        """Return it as a part of the page."""
        failure = f"No result this time: {self.failure}" if self.failure else ""
        parts = (f"## {self.heading.rstrip('.')}", self.text, failure, *(table.as_markdown() for table in self.tables))
        return "\n\n".join(part for part in parts if part)


@dataclass(frozen=True)
class Surroundings:
    """Where and when numbers were taken."""

    machine: str
    versions: str
    date: str
    load: str
    quick: bool = False


def topics() -> list[str]:
    """Return the names of all benchmarks."""
    return sorted(
        module.name for module in pkgutil.iter_modules(benchmarks.__path__) if not module.name.startswith("_")
    )


def documented(topic: str) -> tuple[str, str]:
    """Return the first line of a benchmark's docstring, and the rest of it."""
    source = Path(__file__).with_name(f"{topic}.py").read_text(encoding="utf-8")
    heading, _, text = (ast.get_docstring(ast.parse(source)) or topic).partition("\n")
    return heading, text.strip()


def section(topic: str, quick: bool) -> Section:
    """Measure one comparison; whatever goes wrong in it costs it alone."""
    heading, text = documented(topic)
    try:
        return Section(heading, text, importlib.import_module(f"benchmarks.{topic}").tables(quick))
    except Exception as error:  # noqa: BLE001 - the other comparisons go on
        traceback.print_exc()
        reason = " ".join(str(error).split()) or type(error).__name__
        return Section(heading, text, failure=reason)


def surroundings(before: float, quick: bool) -> Surroundings:
    """Return where and when this is, given the load of the last minute when it began."""
    versions = [f"Python {platform.python_version()}"]
    installed = {of.name for of in importlib.metadata.distributions()}
    versions += [f"{name} {importlib.metadata.version(name)}" for name in _VERSIONS if name in installed]
    versions.append(_compiler())
    return Surroundings(
        f"{_processor()}, {core_count()} cores",
        ", ".join(versions),
        datetime.now(timezone.utc).strftime("%d %B %Y"),
        f"{before:.1f} when it began, {os.getloadavg()[0]:.1f} when it ended",
        quick,
    )


def _processor() -> str:
    """Return the processor's name."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    return next((line.partition(":")[2].strip() for line in lines if line.startswith("model name")), platform.machine())


def _compiler() -> str:
    """Return the C compiler's name and version, as far as there is one."""
    if not _compiled_c.is_there():
        return "no C compiler"
    version = subprocess.run([_compiled_c.COMPILER, "-dumpfullversion"], check=True, capture_output=True, text=True)
    return f"{_compiled_c.COMPILER} {version.stdout.strip()}"


def page(sections: Sequence[Section], where: Surroundings) -> str:
    """Return the page."""
    size = "a quick run: few seeds, so that medians say little" if where.quick else "a full run"
    studies = [topic for topic in topics() if topic not in COMPARISONS]
    listed = "\n".join(f"- `python -m benchmarks.{topic}`: {_sentence(documented(topic)[0])}" for topic in studies)
    head = f"""\
# Benchmarks

Written by `make bench`, whole; not by hand. Each number stands beside what one would use instead, from the same run on
the same data. Methods take turns, each in a process that uses one core; times are CPU times in the median, unless said
otherwise: what it would take on one core that has nothing else to do. Ratios hold elsewhere better than times do. What
makes it fast, and what does not, is in [a page of its own](explanation/performance.md).

| | |
|---|---|
| machine | {where.machine} |
| versions | {where.versions} |
| date | {where.date}, {size} |
| load of the machine, others' work included | {where.load} |

`python -m benchmarks search` repeats one part ({", ".join(f"`{name}`" for name in COMPARISONS)}) and prints it; with
`--quick` it takes few seeds."""
    end = f"""\
## What takes longer

These are run by name; their results stand in the pages that they belong to.

{listed}"""
    return "\n\n".join([head, *(one.as_markdown() for one in sections), end]) + "\n"


def _sentence(heading: str) -> str:
    """Return a heading as it stands after a colon."""
    return heading if heading[1].isupper() else heading[0].lower() + heading[1:]

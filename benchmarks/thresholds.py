"""Thresholds of tracing: what the names of hidden effects become when each of them is halved or doubled.

Truths that are hard to tell, with weak effects, several, unknown ones and none, are traced with each constant of
`cdp_ident/tracing/thresholds.py` at half, as it is, and doubled. Results are kept in `--out`, and a run that was
interrupted goes on from there. `--write` makes the table of docs/explanation/thresholds.md.
"""

import argparse
import ast
import inspect
import re
import sys
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._kept import Kept, add_arguments, kept
from benchmarks._memoisation import memoised
from benchmarks._product import chosen, identified
from benchmarks._scores import score
from cdp_ident.diagnosis.identification import Identification
from cdp_ident.tracing import thresholds
from reference.settings import draw_setting
from reference.truths import Truth, truth

TRUTHS = (
    "none/5",
    "coulomb_friction.outer/1/0.077",
    "coulomb_friction.outer/3/0.874",
    "coulomb_friction.inner+coulomb_friction.outer/7/0.2",
    "joint_spring.inner+coulomb_friction.outer/2/0.15",
    "quadratic_friction.outer/9/0.3",
    "air_drag.outer/13/0.3",
    "air_drag.outer+time_offset.outer/2/0.15",
    "cogging_torque.inner/15/0.227",
    "cogging_torque.outer+cogging_torque.outer/1/0.2",
    "encoder_offset.outer/9/0.278",
    "impulse.outer/18/0.445",
    "encoder_slip.outer/8/0.667",
    "encoder_slip.inner+coulomb_friction.inner/6/0.3",
    "encoder_slip.outer+air_drag.outer/4/0.5",
    "encoder_slip.outer+air_drag.outer/4/1",
    "magnet.inner/5/0.6",
    "magnet.outer/2/5",
    "partial_rub.outer/4/3",
    "rod_flex.inner/3/4",
)
"""Kind, seed, and how visible its effects are over the noise."""
RATE, DURATION = 200, 8.0
"""Of the trials [Hz], [s]: two are fitted, a third is held out."""
FACTORS = (0.5, 1.0, 2.0)
ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "explanation" / "thresholds.md"
_BEGIN = "<!-- made by python -m benchmarks.thresholds --write -->\n"
_DESCRIPTION = re.compile(r"(?P<decides>.*?)\n\nUnit: (?P<unit>.*?)\. Origin: (?P<origin>.*)\.\s*", re.DOTALL)
_NUMBER = re.compile(r"-?[0-9.]+(e[-+]?[0-9]+)?")
PARTS = ("right", "missed", "false", "left")
Answer = dict[str, Any]
"""How many effects of a truth are in each of these parts, and all that is `said`."""


@dataclass(frozen=True)
class Threshold:
    """A constant that decides, with what stands beneath it."""

    name: str
    value: float
    decides: str
    unit: str
    origin: str

    def times(self, factor: float) -> float:
        """Return it halved or doubled: of a ratio, its excess over 1; a share is 1 at most."""
        if self.unit == "ratio":
            return 1.0 + factor * (self.value - 1.0)
        return min(factor * self.value, 1.0) if self.unit.startswith("share") else factor * self.value


def described() -> tuple[Threshold, ...]:
    """Return the thresholds in their order."""
    body = ast.parse(inspect.getsource(thresholds)).body
    found = []
    for constant, beneath in pairwise(body):
        if isinstance(constant, ast.Assign) and isinstance(beneath, ast.Expr):
            text = inspect.cleandoc(ast.literal_eval(beneath.value))
            if words := _DESCRIPTION.fullmatch(text):
                (name,) = (target.id for target in constant.targets if isinstance(target, ast.Name))
                parts = {key: " ".join(part.split()) for key, part in words.groupdict().items()}
                found.append(Threshold(name, getattr(thresholds, name), **parts))
    return tuple(found)


def examine(job: str) -> Kept:
    """Trace one truth with each threshold halved and doubled."""
    made = _truth(job)
    found = identified(made)
    results: dict[str, Answer] = {}
    with memoised():
        as_is = _answer(made, found)
        for threshold in described():
            for factor in FACTORS:
                with _changed(threshold, factor):
                    results[f"{threshold.name} {factor:g}"] = as_is if factor == 1.0 else _answer(made, found)
    return {"job": job, "results": results}


def _truth(job: str) -> Truth:
    kind, seed, *visible = job.split("/")
    setting = draw_setting(np.random.default_rng([int(seed), zlib.crc32(kind.encode())]))
    moments = np.arange(round(DURATION * RATE)) / RATE
    setting = replace(setting, rate=RATE, times=(moments,) * len(setting.times))
    return truth(kind, int(seed), visible=float(visible[0]) if visible else None, setting=setting)


@contextmanager
def _changed(threshold: Threshold, factor: float) -> Iterator[None]:
    setattr(thresholds, threshold.name, threshold.times(factor))
    try:
        yield
    finally:
        setattr(thresholds, threshold.name, threshold.value)


def _answer(made: Truth, found: Identification) -> Answer:
    answer = chosen(found)
    scored = score(made, answer, 0.0)
    return {
        "right": len(scored.right) + len(scored.unknown),
        "missed": len(scored.missed),
        "false": len(scored.false),
        "left": int(scored.remains),
        "said": answer.said,
    }


def table(results: Sequence[Kept]) -> str:
    """Return the table of a page: each threshold, and what all truths together give."""
    lines = [
        f"| threshold | unit | value | decides | origin | {' | '.join(f'x {factor:g}' for factor in FACTORS)} |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for threshold in described():
        cells = []
        for factor in FACTORS:
            those = [result["results"][f"{threshold.name} {factor:g}"] for result in results]
            otherwise = sum(_differs(result["results"], threshold, factor) for result in results)
            counts = ", ".join(str(sum(of[part] for of in those)) for part in PARTS)
            cells.append(f"{counts} ({otherwise})" if otherwise else counts)
        shown = [cell if cell == cells[1] else f"**{cell}**" for cell in cells]
        lines.append(
            f"| `{threshold.name}` | {threshold.unit} | {threshold.value:g} | {threshold.decides} | "
            f"{threshold.origin} | {' | '.join(shown)} |"
        )
    return "\n".join(lines) + "\n"


def hidden(jobs: Sequence[str]) -> str:
    """Return in a sentence what was hidden in the truths."""
    parts = [job.split("/") for job in jobs]
    shown = [f"`{kind}` ({visible[0]})" if visible else "nothing" for kind, _, *visible in parts]
    return f"Hidden were, with what each moves the angles by beyond imitation, over the noise: {', '.join(shown)}."


def _differs(of_truth: Mapping[str, Answer], threshold: Threshold, factor: float) -> bool:
    """Return whether something else is said with a threshold so many times as large, whatever the numbers are."""
    as_is, other = (_NUMBER.sub("#", of_truth[f"{threshold.name} {by:g}"]["said"]) for by in (1.0, factor))
    return as_is != other


def main(arguments: Sequence[str] = ()) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.thresholds")
    parser.add_argument("--truths", default=",".join(TRUTHS), help="kind/seed/visible, with commas")
    add_arguments(parser, 7200.0)
    parser.add_argument("--write", action="store_true", help="put the table into its page")
    options = parser.parse_args(arguments)
    results = []
    for result in kept(examine, options.truths.split(","), options.out, options.limit, options.jobs):
        results.append(result)
        print(f"{result['job']}: {_moved(result)}", flush=True)
    found = table(results)
    if options.write:
        before = PAGE.read_text(encoding="utf-8").partition(_BEGIN)[0]
        jobs = [result["job"] for result in results]
        PAGE.write_text(f"{before}{_BEGIN}\n{hidden(jobs)}\n\n{found}", encoding="utf-8")
    else:
        print(found)


def _moved(result: Kept) -> str:
    """Return in words which changes of a threshold change what is found."""
    changed = [
        f"{threshold.name} {factor:g}"
        for threshold in described() for factor in FACTORS
        if _differs(result["results"], threshold, factor)
    ]  # fmt: skip
    return ", ".join(changed) or "the same with all"


def short() -> None:
    """Take one truth."""
    main(["--truths", TRUTHS[0], "--out", "/dev/null"])


if __name__ == "__main__":
    main(sys.argv[1:])

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Coverage: how often a 95 % interval holds the true value, of base parameters and of effects.

The paper's rig is let go from starts drawn at random, with an effect hidden in it or none, and identified and traced as
users do: effects are chosen by the data whose intervals are looked at. Each noise is taken at a usual rate and at a low
one. `python -m benchmarks.coverage` does so; results are kept in `--out`, and a run that was interrupted goes on from
there. `--write` makes the table of docs/explanation/likelihood.md.
"""

import argparse
import math
import sys
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
from rich.console import Console

from benchmarks._kept import Kept, add_arguments, kept
from benchmarks._product import identified
from benchmarks._tables import Table
from benchmarks.chance import RIG
from cdp_ident.fit.initial_states import Fit
from cdp_ident.fit.physical import CONFIDENCE
from cdp_ident.model.parameters import GROUPS, SYMBOLS, groups_of, inertia_about_cart
from cdp_ident.tracing.trace import trace
from reference.encoders import Counter
from reference.settings import Setting
from reference.truths import Hidden, truth

NOISES: Mapping[str, Counter] = {
    "white": Counter(200_000, 0.5e-3),
    "remembers 10 samples": Counter(200_000, 0.5e-3, math.exp(-0.1)),
    "encoder coarser than it": Counter(4000, 0.2 * 2.0 * math.pi / 4000),
}
RATES = (200, 60)
"""A usual one and a low one [Hz]."""
DURATION = 8.0
"""Of a trial [s]; two are fitted."""
STRENGTHS: Mapping[str, float | None] = {"nothing": None, "clear": 3.0, "faint": 0.2, "drifting": 3.0}
"""What is hidden: what it moves the angles by beyond imitation, over the noise."""
DRIFTING = "drifting_friction.outer"
"""Dry friction that falls along each trial; its parameters in the package are other ones."""
EFFECTS = ("coulomb_friction.outer", "encoder_offset.outer", "cogging_torque.outer", "air_drag.outer")
"""They take turns."""
_ABOUT = 0.3
"""Starts are drawn about the paper rig's, by so much to either side [rad]."""
_AS_VALUES = ("rad", "s", "m")
"""Units of strengths that the motion shows as they are; torques it shows over A22."""
ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "explanation" / "likelihood.md"
COLUMNS = (
    "noise",
    "rate [Hz]",
    "hidden effect",
    "it alone was found",
    "base parameters then",
    "the effect",
    "base parameters otherwise",
)
BEGIN, END = "<!-- made by python -m benchmarks.coverage --write -->\n", "<!-- end of it -->\n"


def examine(job: str) -> Kept:
    """Identify and trace one set of trials, `NOISE/RATE/STRENGTH/SEED`: deviations of values over what is stated."""
    noise, rate, strength, seed = job.split("/")
    visible = STRENGTHS[strength]
    kind = "none" if visible is None else DRIFTING if strength == "drifting" else EFFECTS[int(seed) % len(EFFECTS)]
    made = truth(kind, int(seed), visible=visible, setting=_setting(noise, int(rate), int(seed)))
    found = identified(made)
    traced = trace(found)
    fit, spread = traced.completed.fit, traced.covariance
    physical = np.array([made.setting.values[symbol] for symbol in SYMBOLS])
    length = made.setting.values["L"]
    off = fit.values[: len(GROUPS)] - groups_of(physical, length)
    base = off / np.sqrt(np.diag(spread)[: len(GROUPS)])
    inertia = float(inertia_about_cart(physical, length))
    known = [hidden for hidden in made.hidden if kind != DRIFTING]
    of_effects = [deviation for hidden in known for deviation in _deviations(fit, spread, hidden, inertia)]
    return {
        "job": job,
        "hidden": "" if kind == "none" else kind,
        "found": [f"{active.effect.name}.{active.effect.joint}" for active in fit.model.effects],
        "base": base.tolist(),
        "effects": of_effects,
        "whole": traced.whole is not None,
    }


def _setting(noise: str, rate: int, seed: int) -> Setting:
    rng = np.random.default_rng([seed, zlib.crc32(noise.encode()), rate])
    starts = tuple(start + np.array([*rng.uniform(-_ABOUT, _ABOUT, 2), 0.0, 0.0]) for start in RIG.starts)
    moments = np.arange(round(DURATION * rate)) / rate
    return replace(RIG, rate=rate, counter=NOISES[noise], starts=starts, times=(moments,) * len(starts))


def _deviations(fit: Fit, spread: npt.NDArray[np.float64], hidden: Hidden, inertia: float) -> Iterator[float]:
    """Yield how far the strength of a hidden effect is off where it was found, over its standard deviation.

    Of a harmonic it is the amplitude's.
    """
    true = hidden.strength / (1.0 if hidden.effect.unit in _AS_VALUES else inertia)
    for index, active in enumerate(fit.model.effects):
        if (active.effect.name, active.effect.joint) == (hidden.effect.name, hidden.effect.joint):
            place = fit.model.places(index)
            strong = [place.start + k for k, parameter in enumerate(active.fitted) if not parameter.shape]
            values = fit.values[strong]
            size = float(np.linalg.norm(values)) if len(strong) > 1 else float(values[0])
            by_values = values / size if len(strong) > 1 else np.ones(1)
            yield (size - true) / math.sqrt(by_values @ spread[np.ix_(strong, strong)] @ by_values)
            return


def table(results: Sequence[Kept]) -> Table:
    """Return a row for each noise, rate and strength: shares of intervals that hold the true value."""
    rows = []
    for noise in NOISES:
        for rate in RATES:
            for strength in STRENGTHS:
                those = [r for r in results if r["job"].startswith(f"{noise}/{rate}/{strength}/")]
                if those:
                    right = [r for r in those if r["found"] == ([r["hidden"]] if r["hidden"] else [])]
                    base, of_effects = _held(right, "base"), _held(right, "effects")
                    others = _held([r for r in those if r not in right], "base")
                    rows.append((noise, str(rate), strength, f"{len(right)} of {len(those)}", base, of_effects, others))
    return Table("How often intervals hold the true value", COLUMNS, rows)


def _held(results: Sequence[Kept], of: str) -> str:
    """Return the share of intervals that hold the true value, with the standard error of runs that are independent."""
    by_run = [[abs(deviation) <= CONFIDENCE for deviation in r[of]] for r in results if r[of]]
    if not by_run:
        return ""
    shares = [float(np.mean(held)) for held in by_run]
    share = 100.0 * float(np.mean([held for of_run in by_run for held in of_run]))
    return f"{share:.0f} ± {100.0 * float(np.std(shares)) / math.sqrt(len(shares)):.0f} %"


def written(page: str, results: Sequence[Kept]) -> str:
    """Return a page with the table in its place."""
    before, _, rest = page.partition(BEGIN)
    lines = table(results).as_markdown().partition("\n\n")[2]
    return f"{before}{BEGIN}\n{lines}\n\n{END}{rest.partition(END)[2]}"


def main(arguments: Sequence[str] = ()) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.coverage")
    parser.add_argument("--count", type=int, default=100, help="runs of each row")
    parser.add_argument("--hidden", default=",".join(STRENGTHS), help="how clear what is hidden is, with commas")
    add_arguments(parser, 300.0)
    parser.add_argument("--write", action="store_true", help="put the table into its page")
    options = parser.parse_args(arguments)
    jobs = [
        f"{noise}/{rate}/{strength}/{seed}"
        for seed in range(options.count) for noise in NOISES for rate in RATES for strength in options.hidden.split(",")
    ]  # fmt: skip
    results = list(kept(examine, jobs, options.out, options.limit, options.jobs))
    if options.write:
        PAGE.write_text(written(PAGE.read_text(encoding="utf-8"), results), encoding="utf-8")
    else:
        Console(width=None if sys.stdout.isatty() else 140).print(table(results).for_terminal())


def short() -> None:
    """Take few runs."""
    main(["--count", "1", "--out", "/dev/null"])


if __name__ == "__main__":
    main(sys.argv[1:])

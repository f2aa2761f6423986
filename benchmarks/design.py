# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whether advice on the next swing is worth following: three swings as it says, against three from random starts.

Each rig begins with one swing of small amplitude, as cautious people record. Then three more are recorded: one after
the other from the start that the fit to those before advises, or from starts that are drawn from all that a hand can
lead to. `python -m benchmarks.design --seeds 8` compares the standard deviations that the fits end with.
"""

import argparse
import sys
from collections.abc import Sequence

import numpy as np
from rich.console import Console
from rich.table import Table

from cdp_ident.design.next_trial import NextTrial
from cdp_ident.design.starts import Grid
from scenarios.next_swing import ALL_GROUPS, Swings, swing

ASKED = {"all groups": ALL_GROUPS, "c1": ("c1_over_A22",), "c2": ("c2_over_A22",)}
SWINGS = 3


def begun(rng: np.random.Generator) -> Swings:
    """Return a rig with its first swing, of 20 to 60 degrees."""
    theta1, theta2 = np.pi + np.radians(rng.uniform(20, 60, 2) * rng.choice([-1, 1], 2))
    return Swings.of([swing(theta1, theta2, rng)])


def size(swings: Swings, names: Sequence[str]) -> float:
    """Return how uncertain values are together; see `Uncertainty.size`."""
    return swings.knowledge.uncertainty(names).size


def advised(swings: Swings, names: Sequence[str], rng: np.random.Generator, spacing: float) -> tuple[Swings, float]:
    """Return the swings with one more as advised, the hand missing it by some degrees, and the size foretold."""
    found = NextTrial(swings.knowledge, Grid.of(spacing)).sharpest(names)
    theta1, theta2 = np.pi + np.array([found.trial.inner, found.trial.outer]) + np.radians(rng.uniform(-3, 3, 2))
    return swings.with_one_more(swing(theta1, theta2, rng)), found.expected


def at_random(swings: Swings, rng: np.random.Generator) -> Swings:
    """Return the swings with one more from any start."""
    theta1, theta2 = rng.uniform(0, 2 * np.pi, 2)
    return swings.with_one_more(swing(theta1, theta2, rng))


def main(arguments: Sequence[str] = ()) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.design")
    parser.add_argument("--seeds", type=int, default=8, help="rigs' first swings")
    parser.add_argument("--spacing", type=float, default=30.0, help="of the starts that are surveyed [degrees]")
    options = parser.parse_args(arguments)
    table = Table("asked", "seed", "foretold / reached", "advised: now over at first", "random", "random / advised")
    conclusions = []
    for label, names in ASKED.items():
        factors, foretold = [], []
        for seed in range(options.seeds):
            first = begun(np.random.default_rng(seed))
            before = size(first, names)
            following, drawn = first, first
            rng = np.random.default_rng(1000 + seed)
            said = []
            for _ in range(SWINGS):
                following, expected = advised(following, names, rng, options.spacing)
                said.append(expected / size(following, names))
            for _ in range(SWINGS):
                drawn = at_random(drawn, rng)
            ended = [size(swings, names) for swings in (following, drawn)]
            factors.append(ended[1] / ended[0])
            foretold += said
            words = ", ".join(f"{ratio:.2f}" for ratio in said)
            table.add_row(label, str(seed), words, *(f"{e / before:.3f}" for e in ended), f"{factors[-1]:.2f}")
            print(label, seed, words, f"{factors[-1]:.2f}", flush=True)
        low, middle, high = np.quantile(factors, [0.0, 0.5, 1.0])
        conclusions.append(
            f"{label}: after {SWINGS} swings as advised intervals are {middle:.2f} times narrower than after as many "
            f"from random starts, in the median of {options.seeds} rigs ({low:.2f} to {high:.2f}); foretold over "
            f"reached is {np.median(foretold):.2f} in the median, {np.quantile(foretold, 0.1):.2f} to "
            f"{np.quantile(foretold, 0.9):.2f} in four of five"
        )
    console = Console(width=None if sys.stdout.isatty() else 140)
    console.print(table)
    for conclusion in conclusions:
        console.print(conclusion, highlight=False)


if __name__ == "__main__":
    main(sys.argv[1:])

"""Hidden truths: what the ladder names of the effects that nobody told it of.

`python -m benchmarks.tracing --kinds none,coulomb_friction.outer --seeds 5` takes others; `--weakest` looks for the
weakest strength of some effects that is still found.
"""

import argparse
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from rich.console import Console
from rich.table import Table

from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.pipeline.identify import identify
from cdp_ident.tracing.trace import FoundEffect, trace
from reference.hidden_truths import FIT_TRIALS, KINDS, SINGLE, Answer, Hidden, hidden_truth

NONE_SEEDS = 20
CHANGED = 1.5
"""An effect that raises the error by less than this factor may be missed."""
GOOD = 1.2
"""The error that is left, over the noise, at the most."""

WEAKEST_KINDS = (
    "coulomb_friction.inner",
    "coulomb_friction.outer",
    "air_drag.outer",
    "joint_spring.inner",
    "cogging_torque.inner",
    "encoder_offset.outer",
    "encoder_scale.outer",
    "time_offset.outer",
)
STRONG = 1.6
"""How visible an effect is at first when its weakest strength is looked for, over the noise."""

Identity = tuple[str, str]


@dataclass(frozen=True)
class Result:
    """What came of one truth."""

    kind: str
    seed: int
    answer: Answer
    named: tuple[str, ...]
    right: tuple[Hidden, ...]
    missed: tuple[Hidden, ...]
    weak: tuple[Hidden, ...]
    """Missed too, without blame."""
    beyond: tuple[Hidden, ...]
    """What nobody could name, for the package's catalogue lacks it."""
    false: tuple[str, ...]
    remains: bool
    """Whether more than noise is said to remain."""
    before: float
    """Error on the held-out trial without effects, over the noise."""
    after: float
    """The same with the effects."""
    seconds: float

    @property
    def line(self) -> str:
        """All of it in a line."""
        hidden = ", ".join(f"{h.strength:.3g} {h.effect.unit} ({h.visible:.1f})" for h in self.answer.hidden)
        verdict = "FALSE" if self.false else "MISSED" if self.missed else "weak" if self.weak else "ok"
        if self.beyond and not self.false:
            verdict = "ok" if self.remains else "UNSEEN" if self.before > CHANGED else "weak"
        remain = ", more than noise remains" if self.remains else ""
        return (
            f"{verdict:6} {self.kind} {self.seed}: {hidden or 'nothing'} -> {', '.join(self.named) or 'nothing'}; "
            f"{self.before:.2f} -> {self.after:.2f} x {1e3 * self.answer.floor:.2f} mrad{remain}, "
            f"{self.seconds:.1f} s"
        )


def examine(kind: str, seed: int, visible: float | None = None) -> Result:
    """Identify one hidden truth, and only then compare with the answer."""
    trials, answer = hidden_truth(kind, seed, visible)
    begin = time.perf_counter()
    identified = identify(trials[:FIT_TRIALS], trials[FIT_TRIALS:], IdentifyOptions())
    found = trace(identified)
    seconds = time.perf_counter() - begin
    before, after = (attempt.holdout.rmse() / answer.floor for attempt in (found.ladder.before, found.after))
    right: list[Hidden] = []
    false: list[str] = []
    for effect in found.effects:
        possible = _possible(effect)
        meant = next((hidden for hidden in answer.hidden if hidden.right & possible and hidden not in right), None)
        if meant is None:
            false.append(effect.active.effect.key)
        else:
            right.append(meant)
    unnamed = [hidden for hidden in answer.hidden if hidden not in right]
    faint = [hidden for hidden in unnamed if hidden.known and _is_faint(hidden, answer, before)]
    return Result(
        kind=kind,
        seed=seed,
        answer=answer,
        named=tuple(effect.active.effect.key for effect in found.effects),
        right=tuple(right),
        missed=tuple(hidden for hidden in unnamed if hidden.known and hidden not in faint),
        weak=tuple(faint),
        beyond=tuple(hidden for hidden in unnamed if not hidden.known),
        false=tuple(false),
        remains=found.unexplained.significant,
        before=before,
        after=after,
        seconds=seconds,
    )


def _is_faint(hidden: Hidden, answer: Answer, before: float) -> bool:
    """Return whether an effect changes the error too little to be blamed on anybody who misses it."""
    if len(answer.hidden) == 1 and hidden.effect.trial is None:
        return before < CHANGED
    return bool(np.hypot(1.0, hidden.visible) < CHANGED)


def _possible(effect: FoundEffect) -> frozenset[Identity]:
    """Return the name and joint of an effect that was named, and of those that are said to be as possible."""
    own = effect.active.effect
    others = (other.split()[:2] for other in effect.also_possible)
    return frozenset({(own.name, str(own.joint)), *((name, joint) for name, joint in others)})


def summary(results: Sequence[Result]) -> Table:
    """Return a table with a row for each kind."""
    table = Table("hidden", "truths", "right", "missed", "weak", "beyond", "false", "before", "after", "time [s]")
    for kind in dict.fromkeys(result.kind for result in results):
        table.add_row(kind, *_row([result for result in results if result.kind == kind]))
    table.add_section()
    table.add_row("all", *_row(results))
    return table


def _row(results: Sequence[Result]) -> list[str]:
    counts = [sum(len(getattr(r, part)) for r in results) for part in ("right", "missed", "weak", "beyond", "false")]
    medians = [float(np.median([getattr(r, part) for r in results])) for part in ("before", "after", "seconds")]
    return [str(len(results)), *map(str, counts), *(f"{median:.2f}" for median in medians)]


def weakest(console: Console, seeds: Sequence[int]) -> None:
    """Print for some effects the weakest strength that is still named, halving it until it is not."""
    table = Table(
        "hidden", "seed", "weakest strength named", "moves angles, over the noise", "noise [mrad]", "not named"
    )
    for kind in WEAKEST_KINDS:
        for seed in seeds:
            found: Result | None = None
            visible = STRONG
            while (result := examine(kind, seed, visible)).right:
                found, visible = result, visible / 2.0
                print(result.line, flush=True)
            print(result.line, flush=True)
            (lost,) = result.answer.hidden
            hidden = found.answer.hidden[0] if found else None
            table.add_row(
                kind,
                str(seed),
                f"{abs(hidden.strength):.2g} {hidden.effect.unit}" if hidden else "none",
                f"{hidden.visible:.2f}" if hidden else "",
                f"{1e3 * result.answer.floor:.2f}",
                f"{abs(lost.strength):.2g} {lost.effect.unit}",
            )
    console.print(table)


def main(arguments: Sequence[str] = ()) -> None:
    options = argparse.ArgumentParser(prog="python -m benchmarks.tracing")
    options.add_argument("--kinds", default="", help="kinds of truth, with commas between them (default: all)")
    options.add_argument("--seeds", type=int, default=1, help="truths of each kind")
    options.add_argument("--first", type=int, default=0, help="first seed")
    options.add_argument("--weakest", action="store_true", help="look for the weakest strength that is found")
    chosen = options.parse_args(arguments)
    console = Console()
    if chosen.weakest:
        weakest(console, range(chosen.first, chosen.first + chosen.seeds))
        return
    kinds = chosen.kinds.split(",") if chosen.kinds else KINDS
    kinds = [k for name in kinds for k in (SINGLE if name == "single" else [name])]
    results = []
    for kind in kinds:
        seeds = NONE_SEEDS if kind == "none" and not chosen.kinds else chosen.seeds
        for seed in range(chosen.first, chosen.first + seeds):
            results.append(examine(kind, seed))
            print(results[-1].line, flush=True)
    console.print(summary(results))
    known = [r for r in results if all(h.known for h in r.answer.hidden)]
    clean = sum(not r.missed and not r.false for r in known)
    console.print(
        f"{clean} of {len(known)} truths of known effects with nothing missed or false; the error left is at most "
        f"{max((r.after for r in known), default=0.0):.2f} times the noise, below {GOOD} for "
        f"{sum(r.after < GOOD for r in known)}; longest {max(r.seconds for r in results):.1f} s"
    )
    strange = [r for r in results if r.beyond]
    if strange:
        console.print(
            f"of {len(strange)} truths beyond the catalogue, {sum(r.remains for r in strange)} are said to leave more "
            f"than noise, and in {sum(bool(r.false) for r in strange)} something is named"
        )


if __name__ == "__main__":
    import sys

    main(sys.argv[1:])

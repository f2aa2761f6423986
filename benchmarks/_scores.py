# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the package's answer to a hidden truth is worth, and the table over many."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np
from rich.table import Table

from benchmarks._product import Found, Named
from reference.kinds import GROUPS, group_of
from reference.truths import Hidden, Truth

CHANGED = 1.5
"""An effect that raises the error by less than this factor may be missed."""
LEFT = {"beyond": 1.5}
"""The error that may be left, over the noise, by group of truths; `KNOWN_LEFT` in the others."""
KNOWN_LEFT = 1.1


@dataclass(frozen=True)
class Score:
    """One truth and what came of it, in words and numbers that a file of JSON can hold."""

    kind: str
    seed: int
    engine: str
    error: str = ""
    """Why there is no result, if there is none."""
    size: float = 0.0
    rate: int = 0
    counts: int = 0
    noise: float = 0.0
    """Root mean square of the measured angles' errors [rad]."""
    hidden: tuple[str, ...] = ()
    named: tuple[str, ...] = ()
    also_possible: tuple[str, ...] = ()
    """What is said of each of these to be as possible; what is hidden counts as right there, too."""
    probability: tuple[float, ...] = ()
    """That each of these is there, as it is said."""
    unknown: tuple[str, ...] = ()
    """Torques that were found without a name."""
    right: tuple[str, ...] = ()
    missed: tuple[str, ...] = ()
    weak: tuple[str, ...] = ()
    """Missed too, without blame."""
    beyond: tuple[str, ...] = ()
    """What nobody could name, for the package has no name for it."""
    false: tuple[str, ...] = ()
    before: float = 0.0
    """Error on the trial that the package never saw, without effects, over the noise."""
    after: float = 0.0
    """The same with the effects that it named."""
    remains: bool = False
    """Whether more than noise is said to remain."""
    description: str = ""
    deviations: tuple[float, ...] = ()
    """Base parameters less the true ones, over their standard deviations, a1 for the g that was told."""
    seconds: float = 0.0
    """Processor time of the package: what it would take on one core that has nothing else to do."""
    strengths: tuple[dict[str, Any], ...] = field(default=())
    """Of all that is hidden: strength, and how visible it is over the noise."""
    is_strange: bool = False
    """Whether the laws of what is hidden were taken out of the catalogue: any name is wrong."""

    @property
    def group(self) -> str:
        """The group of its kind."""
        return "beyond" if self.is_strange else group_of(self.kind)

    @property
    def verdict(self) -> str:
        """The worst that can be said of it, in a word."""
        if self.error:
            return "CRASHED"
        if self.false:
            return "FALSE"
        if self.missed:
            return "MISSED"
        if self.beyond and self.before > CHANGED and not self.remains and self.after > CHANGED:
            return "UNSEEN"
        return "left" if self.after > LEFT.get(self.group, KNOWN_LEFT) else "weak" if self.weak else "ok"

    @property
    def line(self) -> str:
        """All of it in a line."""
        begin = f"{self.verdict:7} {self.kind} {self.seed} {self.engine}"
        if self.error:
            return f"{begin}: {self.error.splitlines()[-1]}"
        remain = ", more than noise remains" if self.remains else ""
        named = [
            f"{key} or {others}" if others else key for key, others in zip(self.named, self.also_possible, strict=True)
        ]
        answer = ", ".join((*named, *(f"unknown {key}" for key in self.unknown))) or "nothing"
        return (
            f"{begin} ({self.size:.2g} x, {self.rate} Hz): {', '.join(self.hidden) or 'nothing'} -> {answer}; "
            f"{self.before:.2f} -> {self.after:.2f} x {1e3 * self.noise:.2f} mrad{remain}, {self.seconds:.1f} s"
        )

    @property
    def as_json(self) -> dict[str, Any]:
        """All of it, with its group and verdict."""
        return {**asdict(self), "group": self.group, "verdict": self.verdict}


def score(truth: Truth, found: Found, seconds: float) -> Score:
    """Compare what was found with what was hidden."""
    before, after = float(found.before / truth.floor), float(found.after / truth.floor)
    right: list[Hidden] = []
    false: list[str] = []
    for named in found.named:
        meant = [h for h in truth.hidden if h.right & _possible(named) and h not in right]
        if meant:
            # Of several that it could be, the clearest: a joint may have two harmonics.
            right.append(max(meant, key=lambda h: h.visible))
        else:
            false.append(named.key)
    unnamed = [h for h in truth.hidden if h not in right]
    faint = [h for h in unnamed if h.known and _is_faint(h, truth, before)]
    return Score(
        kind=truth.kind,
        seed=truth.seed,
        engine=truth.engine,
        size=truth.setting.size,
        rate=truth.setting.rate,
        counts=truth.setting.counter.counts,
        noise=truth.floor,
        hidden=tuple(f"{h.strength:.3g} {h.effect.unit} ({h.visible:.1f})" for h in truth.hidden),
        named=tuple(named.key for named in found.named),
        also_possible=tuple(" or ".join(map(" ".join, named.also_possible)) for named in found.named),
        probability=tuple(named.probability for named in found.named),
        unknown=found.unknown,
        right=_keys(right),
        missed=_keys([h for h in unnamed if h.known and h not in faint]),
        weak=_keys(faint),
        beyond=_keys([h for h in unnamed if not h.known]),
        false=tuple(false),
        before=before,
        after=after,
        remains=bool(found.remains),
        description=found.description,
        deviations=tuple(
            (value - true) / std if std else 0.0 for (value, std), true in zip(found.base, _base(truth), strict=False)
        ),
        seconds=seconds,
        strengths=tuple(
            {"effect": key, "strength": h.strength, "unit": h.effect.unit, "visible": h.visible}
            for key, h in zip(_keys(truth.hidden), truth.hidden, strict=True)
        ),
    )


def strange(of: Score) -> Score:
    """Return the score of a truth whose laws the catalogue lacked: no name is right, and nothing is missed."""
    lost = (*of.right, *of.missed, *of.weak, *of.beyond)
    return replace(of, right=(), missed=(), weak=(), beyond=lost, false=of.named, is_strange=True)


def _is_faint(hidden: Hidden, truth: Truth, before: float) -> bool:
    """Return whether an effect changes the error too little to be blamed on anybody who misses it."""
    if len(truth.hidden) == 1 and hidden.effect.trial is None:
        return before < CHANGED
    return bool(np.hypot(1.0, hidden.visible) < CHANGED)


def _base(truth: Truth) -> tuple[float, ...]:
    """Return a rig's base parameters A23, A33, a1, c1 and c2 over A22; a1 as it is for the g that was told."""
    of, told = truth.setting.values, truth.setting.nominal
    outer = of["m2"] + of["m0"]
    inertia = of["m1"] * of["l1"] ** 2 + of["J1"] + outer * of["L"] ** 2
    moment = (of["m1"] * of["l1"] + outer * of["L"]) * of["g"] / told["g"]
    coupling, own = of["m2"] * of["L"] * of["l2"], of["m2"] * of["l2"] ** 2 + of["J2"]
    return tuple(value / inertia for value in (coupling, own, moment, of["c1"], of["c2"]))


def _possible(named: Named) -> frozenset[tuple[str, str]]:
    return frozenset({named.identity, *named.also_possible})


def _keys(hidden: Sequence[Hidden]) -> tuple[str, ...]:
    return tuple(f"{h.effect.name}.{h.effect.joint}" for h in hidden)


def summary(scores: Sequence[Score]) -> Table:
    """Return a table with a row for each group and engine."""
    table = Table("hidden", "engine", "truths", "right", "missed", "weak", "beyond", "false", "after, median", "worst",
                  "crashed", r"time \[s]", "longest")  # fmt: skip
    engines = list(dict.fromkeys(s.engine for s in scores))
    for group in GROUPS:
        for engine in engines:
            those = [s for s in scores if s.group == group and s.engine == engine]
            if those:
                table.add_row(group, engine, *_row(those))
    table.add_section()
    table.add_row("all", "", *_row(scores))
    return table


def _row(scores: Sequence[Score]) -> list[str]:
    done = [s for s in scores if not s.error]
    counts = [sum(len(getattr(s, part)) for s in done) for part in ("right", "missed", "weak", "beyond", "false")]
    after, seconds = [s.after for s in done] or [np.nan], [s.seconds for s in done] or [np.nan]
    return [
        str(len(scores)), *map(str, counts), f"{np.median(after):.2f}", f"{max(after):.2f}",
        str(len(scores) - len(done)), f"{np.median(seconds):.1f}", f"{max(seconds):.1f}",
    ]  # fmt: skip


def conclusion(scores: Sequence[Score]) -> str:
    """Return in a few lines how far the aims are reached."""
    done = [s for s in scores if not s.error]
    known = [s for s in done if s.group != "beyond"]
    clean = sum(not s.missed and not s.false for s in known)
    close = sum(s.after <= KNOWN_LEFT for s in known)
    strange = [s for s in done if s.group == "beyond"]
    near = sum(s.after <= LEFT["beyond"] for s in strange)
    said, wrong = sum(s.remains for s in strange), sum(bool(s.false) for s in strange)
    return (
        f"of {len(known)} truths of known effects, {clean} with nothing missed or false, {close} end within "
        f"{KNOWN_LEFT} of the noise\nof {len(strange)} beyond the catalogue, {near} end within {LEFT['beyond']} of it, "
        f"{said} are said to leave more than noise, in {wrong} something is named that is not there\n"
        f"no result: {len(scores) - len(done)}"
    )

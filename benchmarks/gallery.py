# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The gallery of effects: what each leaves when it is missing, what it is taken for, and how weak it may be.

`python -m benchmarks.gallery` hides each effect of the catalogue in one and the same rig, has the package look for it,
and does so again with weaker ones until it is not found. It writes docs/explanation/effects.md and its pictures. With
`--kinds coulomb_friction.outer,magnet.inner` only these are looked at, and printed; nothing is written, unless `--add`
puts them beside what was found before.
"""

import argparse
import json
import math
import os
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from benchmarks._gallery_page import Entry, Strengths, page, read_entries
from benchmarks._gallery_picture import Shown, picture
from benchmarks._product import answer_of, identified, traced
from benchmarks._scores import score
from benchmarks._workers import each
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.tracing.missing_torque import MissingTorque
from cdp_ident.tracing.select_effects import select_effects
from cdp_ident.tracing.trace import Trace
from reference.encoders import Counter
from reference.kinds import SINGLE
from reference.pendulum import TABLE_2, TABLE_5
from reference.settings import Setting
from reference.truths import Truth, truth

KINDS = (*SINGLE, "rotor_inertia.outer", "presliding_friction.inner", "presliding_friction.outer",
         "drifting_friction.inner", "drifting_friction.outer", "encoder_filter.inner", "encoder_filter.outer",
         "partial_rub.inner", "partial_rub.outer")  # fmt: skip
"""What is hidden: each effect that the catalogue names, and two nonparametric torques."""
NAMED = {(effect.name, effect.joint) for effect in CATALOGUE}
"""What the package has names for."""
DRAWN = 20.0
"""How visible an effect is in its picture, over the noise."""
STRONG = 6.4
"""How visible it is when it is looked for at first."""
WEAKER = (0.8, 0.4, 0.2)
"""How visible it is then, until it is not found any more."""
STRONGER = (1.6, 3.2)
"""How visible where the first of these is too weak already, until it is found."""
RIG = Setting(
    size=1.0,
    values=TABLE_5,
    nominal=TABLE_2,
    rate=200,
    counter=Counter(8000, 0.3e-3, 0.0),
    starts=tuple(np.array([*angles, 0.0, 0.0]) for angles in ((2.2, 2.0), (2.4, 4.5), (4.0, 4.4))),
    times=(np.arange(2400) / 200.0,) * 3,
)
"""The paper's rig with its last row of Table 5, let go as in the example bags; nominal values are those of Table 2."""
LIMIT = 900.0
"""An effect that takes longer is given up [s]."""
ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "explanation" / "effects.md"
PICTURES = PAGE.with_suffix("")
FOUND = PICTURES / "found.json"
"""What the page is made of."""


@dataclass(frozen=True)
class Result:
    """What came of one kind."""

    entry: Entry
    lines: tuple[str, ...] = field(default=())
    """What was found at each strength, in words."""


def examine(kind: str) -> Result:
    """Hide one effect in the rig at falling strengths, and have it looked for."""
    strong = truth(kind, 1, visible=STRONG, setting=RIG)
    trace = traced(strong)
    lines: list[str] = []
    found_at: list[str] = []
    lost_at: list[str] = []

    def is_found(made: Truth, by: Trace) -> bool:
        recognised = _recognised(made, by)
        (found_at if recognised else lost_at).append(_strength(made))
        lines.append(score(made, answer_of(by), 0.0).line)
        return recognised

    def is_found_at(visible: float) -> bool:
        weaker = truth(kind, 1, visible=visible, setting=RIG)
        return is_found(weaker, traced(weaker))

    if is_found(strong, trace):
        lost = next((visible for visible in WEAKER if not is_found_at(visible)), None)
        if lost == WEAKER[0]:
            next((visible for visible in STRONGER if is_found_at(visible)), None)
    entry = Entry(
        kind=kind,
        hidden=_strength(strong),
        found=_names(trace),
        before=_milliradians(trace.before.holdout.rmse()),
        after=_milliradians(trace.after.holdout.rmse()),
        noise=_milliradians(strong.floor),
        alternatives=_alternatives(trace),
        also_possible=tuple(trace.effects[0].also_possible) if trace.effects else (),
        found_at=tuple(found_at),
        lost_at=tuple(lost_at),
    )
    return Result(entry, tuple(lines))


def draw(kind: str) -> tuple[str, bytes]:
    """Return a kind, and the picture of what the paper's model leaves when its effect is missing."""
    made = truth(kind, 1, visible=DRAWN, setting=RIG)
    (hidden,) = made.hidden
    trial = hidden.effect.trial or 0
    column = 1 if hidden.effect.joint == "outer" else 0
    found = identified(made)
    fit = found.fit
    parts = [(w.begin + w.time, left) for w, left in zip(fit.windows, fit.errors, strict=True) if w.trial == trial]
    lasts = hidden.effect.in_plant is not None and hidden.effect.trial is None
    # The search is ended as soon as it has fitted the paper's model.
    missing = MissingTorque.of(select_effects(found, stop=lambda: True).before) if lasts else None
    shown = Shown(
        joint=("inner", "outer")[column],
        noise=_milliradians(made.floor),
        windows=tuple((time, 1e3 * left) for time, left in parts),
        torque=None
        if missing is None
        else (
            missing.over("speed", column),
            missing.over("angle", column),
            1e3 * _inertia(made) * missing.torque[:, column],
        ),
    )
    return kind, picture(shown)


def _milliradians(error: float) -> float:
    """Return an error in milliradians."""
    return 1e3 * float(error)


def _recognised(made: Truth, found: Trace) -> bool:
    """Return whether what is hidden was named, or found as the nonparametric torque that it is.

    By the name of a simpler effect it is not.
    """
    (hidden,) = made.hidden
    own = (hidden.effect.name, str(hidden.effect.joint))
    right = {own} if own in NAMED and not hidden.known else hidden.right
    answer = answer_of(found)
    names = {named.identity for named in answer.named}
    names |= {other for named in answer.named for other in named.also_possible}
    names |= {("unknown_torque", key.split(".")[1]) for key in answer.unknown}
    return bool(right & names)


def _strength(made: Truth) -> str:
    (hidden,) = made.hidden
    return f"{abs(hidden.strength):.2g} {hidden.effect.unit} ({hidden.visible:.2g})"


def _names(found: Trace) -> tuple[str, ...]:
    return tuple(f"{effect.active.effect.key} ({effect.certainty})" for effect in found.effects)


def _alternatives(found: Trace) -> tuple[tuple[str, float], ...]:
    """Return what else was fitted alone beside the paper's model, with the chosen model's log10 odds over it."""
    if found.selection is None or not found.effects:
        return ()
    chosen = {effect.active.effect.key for effect in found.effects}
    final, best = found.selection.steps[-1].misfit, dict[str, float]()
    for tried in found.selection.steps[0].tried:
        if len(tried.effects) == 1 and tried.effects[0] not in chosen:
            best.setdefault(tried.effects[0], (tried.misfit - final) / (2.0 * math.log(10.0)))
    return tuple(sorted(best.items(), key=lambda pair: pair[1])[:3])


def _inertia(made: Truth) -> float:
    v = made.setting.values
    return float(v["m1"] * v["l1"] ** 2 + v["J1"] + (v["m2"] + v["m0"]) * v["L"] ** 2)


def _failed(kind: str, why: str) -> Result:
    return Result(Entry(kind, "", (), 0.0, 0.0, 0.0, (), (), (), (why,)))


def _not_drawn(kind: str, why: str) -> tuple[str, bytes]:
    raise RuntimeError(f"{kind} could not be drawn: {why}")


def main(arguments: Sequence[str] = ()) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.gallery")
    parser.add_argument("--kinds", default="", help="look at these only, and write nothing")
    parser.add_argument("--add", action="store_true", help="put these into the page all the same")
    parser.add_argument("--draw", action="store_true", help="make pictures and page anew from what was found before")
    parser.add_argument("--jobs", type=int, default=len(os.sched_getaffinity(0)), help="processes, of one core each")
    options = parser.parse_args(arguments)
    kinds = options.kinds.split(",") if options.kinds else KINDS
    if not options.draw:
        results = _examined(kinds, options.jobs)
        if options.kinds and not options.add:
            return
        PICTURES.mkdir(exist_ok=True)
        entries = {entry.kind: entry for entry in read_entries(FOUND)} if options.add else {}
        entries |= {kind: result.entry for kind, result in results.items()}
        found = [asdict(entries[kind]) for kind in KINDS]
        FOUND.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    for kind, drawing in each(draw, kinds, options.jobs, LIMIT, _not_drawn):
        (PICTURES / f"{kind}.svg").write_bytes(drawing)
    strengths = Strengths(DRAWN, STRONG, WEAKER[0], WEAKER[-1])
    PAGE.write_text(page(read_entries(FOUND), strengths), encoding="utf-8")


def _examined(kinds: Sequence[str], jobs: int) -> dict[str, Result]:
    results = {}
    for result in each(examine, kinds, jobs, LIMIT, _failed):
        results[result.entry.kind] = result
        print("\n".join(result.lines or (f"{result.entry.kind}: {result.entry.lost_at[0]}",)), flush=True)
    return results


if __name__ == "__main__":
    main(sys.argv[1:])

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The contents of `survey.json`: the result of each piece, quantities over time, what changed, which rig differs."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from datetime import datetime, timezone
from itertools import chain, pairwise

import numpy as np

from cdp_ident.configuration.settings import Settings
from cdp_ident.model.parameters import CONSTANTS, GROUPS, INERTIA, PARAMETERS
from cdp_ident.report.comparison import Quantity, effect_quantities, fitted_quantity
from cdp_ident.report.provenance import versions
from cdp_ident.report.schema import Section
from cdp_ident.report.wording import group_words, noise_floor
from cdp_ident.survey.run import By, Finished, LeftOut, Piece
from cdp_ident.survey.statistics import FEWEST, Change, Series, appearance, changes, differing

SCHEMA = "cdp_ident/survey/1"
LEVEL = 0.05
"""Probability that a survey reports a change where there is none, and likewise a difference."""

_UNITS = {
    **{group_words(group): group.unit for group in GROUPS},
    **{parameter.symbol: parameter.unit for parameter in (INERTIA, *PARAMETERS, *CONSTANTS)},
}


@dataclass(frozen=True)
class _OverTime:
    """One quantity of one rig over its usable pieces."""

    rig: str
    name: str
    kind: str
    """`group`, `effect` or `physical`."""
    pieces: Sequence[Finished]
    quantities: Sequence[Quantity | None]
    """One for each piece."""
    changes: Sequence[Change] = ()
    """Their places count the known values alone."""

    @property
    def known(self) -> list[tuple[Piece, Quantity]]:
        """The pieces in which it has a value with an interval, and that."""
        return [(p.piece, q) for p, q in zip(self.pieces, self.quantities, strict=True) if q and q.is_known]

    @property
    def series(self) -> Series:
        """Its known values."""
        known = [quantity for _, quantity in self.known]
        return Series(np.array([q.value for q in known]), np.array([q.std for q in known]))

    @property
    def stretches(self) -> list[Series]:
        """Those between its changes."""
        return [self.series[slice(*ends)] for ends in pairwise((0, *(change.index for change in self.changes), None))]

    @property
    def is_compared(self) -> bool:
        """Whether it is tested for changes: physical values follow from the base parameters and add nothing to them."""
        return self.kind != "physical"

    @property
    def comes_and_goes(self) -> bool:
        """Whether it is asked since when it is found."""
        return self.kind == "effect" and len(self.quantities) >= FEWEST and None in self.quantities


def survey(pieces: Sequence[Finished], by: By, settings: Settings, left_out: Sequence[LeftOut] = ()) -> Section:
    """Return the contents of `survey.json` as plain values; pieces are given by rig and in the order of time.

    `left_out` are bags that are of no piece.
    """
    by_rig = {piece.piece.rig: [p for p in pieces if p.piece.rig == piece.piece.rig] for piece in pieces}
    every = [one for rig, of in by_rig.items() for one in _over_time(rig, of)]
    tests = sum((len(one.known) >= FEWEST and one.is_compared) + one.comes_and_goes for one in every)
    every = [replace(one, changes=changes(one.series, LEVEL, tests)) if one.is_compared else one for one in every]
    return {
        "schema": SCHEMA,
        "written_at": datetime.now(timezone.utc).isoformat(timespec="seconds"),
        "versions": versions(),
        "by": by,
        "options": settings.values(),
        "level": LEVEL,
        "rigs": [
            {
                "name": rig,
                "named_by": of[0].piece.bags[0].named_by,
                "pieces": [_piece(piece) for piece in of],
                "quantities": [_quantity(one) for one in every if one.rig == rig],
            }
            for rig, of in by_rig.items()
        ],
        "changes": [*_value_changes(every), *_appearances(every, tests)],
        "differences": _differences(every),
        "left_out": [asdict(bag) for bag in left_out],
    }


def _over_time(rig: str, pieces: Sequence[Finished]) -> list[_OverTime]:
    usable = [(piece, piece.report) for piece in pieces if piece.report and not piece.problem]
    reports = [report for _, report in usable]
    effects = [effect_quantities(report, of_trials=False) for report in reports]
    # Trials with a known weight determine A22 itself, which no base parameter does.
    physical = [(p.symbol, "group" if p is INERTIA else "physical") for p in (INERTIA, *PARAMETERS, *CONSTANTS)]
    found: list[tuple[str, str, Sequence[Quantity | None]]] = [
        *((group_words(g), "group", [fitted_quantity(r, "groups", g.symbol) for r in reports]) for g in GROUPS),
        *((name, "effect", [of_one.get(name) for of_one in effects]) for name in dict.fromkeys(chain(*effects))),
        *((symbol, kind, [fitted_quantity(r, "physical", symbol) for r in reports]) for symbol, kind in physical),
    ]
    every = [_OverTime(rig, name, kind, [piece for piece, _ in usable], of) for name, kind, of in found]
    return [one for one in every if one.known]


def _value_changes(every: Sequence[_OverTime]) -> Iterator[Section]:
    for one in every:
        for change, sides in zip(one.changes, pairwise(map(_mean, one.stretches)), strict=True):
            (last, _), (first, _) = one.known[change.index - 1 : change.index + 1]
            yield _change(one, "value", last, first, sides, change)


def _appearances(every: Sequence[_OverTime], tests: int) -> Iterator[Section]:
    for one in every:
        seen = [quantity is not None for quantity in one.quantities]
        change = appearance(seen, LEVEL, tests) if one.comes_and_goes else None
        if change:
            sides = [{"found": sum(side), "of": len(side)} for side in (seen[: change.index], seen[change.index :])]
            last, first = one.pieces[change.index - 1 : change.index + 1]
            yield _change(one, "found", last.piece, first.piece, sides, change)


def _change(one: _OverTime, what: str, last: Piece, first: Piece, sides: Sequence[Section], change: Change) -> Section:
    return {
        "rig": one.rig,
        "quantity": one.name,
        "what": what,
        "until": last.name,
        "since": first.name,
        "since_start": first.start,
        "before": sides[0],
        "after": sides[1],
        "p_value": change.p_value,
    }


def _differences(every: Sequence[_OverTime]) -> list[Section]:
    """Return which rigs differ in what, each quantity since its last change."""
    latest: dict[str, dict[str, Series]] = {}
    for one in every:
        if one.is_compared:
            latest.setdefault(one.name, {})[one.rig] = one.stretches[-1]
    compared = {name: of for name, of in latest.items() if len(of) > 1}
    return [
        {"quantity": name, **asdict(difference), "others": list(difference.others)}
        for name, of in compared.items()
        for difference in differing(of, LEVEL, len(compared))
    ]


def _piece(finished: Finished) -> Section:
    piece, report = finished.piece, finished.report
    return {
        "name": piece.name,
        "start": piece.start,
        "bags": [str(bag.path) for bag in piece.bags],
        "left_out": [asdict(bag) for bag in finished.left_out],
        "folder": f"{finished.folder.parent.name}/{finished.folder.name}",
        "has_report": report is not None,
        "rmse_holdout_rad": report and report["after"]["error"]["holdout"]["rmse_rad"],
        "noise_rad": report and noise_floor(report),
        "verdict": report and report["verdict"],
        "problem": finished.problem,
    }


def _quantity(one: _OverTime) -> Section:
    """Return a quantity over time; what an effect is as the motion shows it, torques over A22."""
    stretches = [{**_mean(series), "pieces": len(series)} for series in one.stretches]
    return {
        "name": one.name,
        "kind": one.kind,
        "unit": _UNITS.get(one.name, ""),
        "estimates": [
            {"piece": piece.name, "start": piece.start, "value": q.value, "std": q.std, "words": q.text}
            for piece, q in one.known
        ],
        "stretches": stretches,
        "latest": stretches[-1],
    }


def _mean(series: Series) -> Section:
    return {"value": series.mean, "std": series.std_of_mean}

"""The contents of `survey.json`: the result of each piece, quantities over time, what changed, which rig differs."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import datetime, timezone
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from cdp_ident.configuration.settings import Settings
from cdp_ident.model.parameters import CONSTANTS, GROUPS, INERTIA, PARAMETERS
from cdp_ident.report.comparison import Quantity, effect_quantities, fitted_quantity
from cdp_ident.report.provenance import versions
from cdp_ident.report.schema import Section
from cdp_ident.report.wording import group_words, noise_floor
from cdp_ident.survey.change import FEWEST, Change, appearance, changes, mean
from cdp_ident.survey.identification import Finished
from cdp_ident.survey.pieces import By, LeftOut, Piece
from cdp_ident.survey.rigs import differing

SCHEMA = "cdp_ident/survey/1"
LEVEL = 0.05
"""Probability that a survey reports a change where there is none, and likewise a difference."""

Array = npt.NDArray[np.float64]
_UNITS = {
    **{group_words(group): group.unit for group in GROUPS},
    **{parameter.symbol: parameter.unit for parameter in (INERTIA, *PARAMETERS, *CONSTANTS)},
}


@dataclass(frozen=True)
class _Series:
    """One quantity of one rig over its usable pieces."""

    kind: str
    """`group`, `effect` or `physical`."""
    quantities: tuple[Quantity | None, ...]

    @property
    def known(self) -> list[int]:
        """Pieces in which it has a value with an interval."""
        return [index for index, quantity in enumerate(self.quantities) if quantity and quantity.is_known]

    @property
    def is_compared(self) -> bool:
        """Whether it is tested for changes: physical values follow from the base parameters and add nothing to them."""
        return self.kind != "physical"

    def arrays(self, first: int = 0) -> tuple[Array, Array]:
        """Return its known values from the first-th on, and their standard deviations."""
        known = [quantity for index in self.known[first:] if (quantity := self.quantities[index])]
        return np.array([q.value for q in known]), np.array([q.std for q in known])


def survey(pieces: Sequence[Finished], by: By, settings: Settings, left_out: Sequence[LeftOut] = ()) -> Section:
    """Return the contents of `survey.json`; plain values.

    Args:
        pieces: the result of each, by rig and in the order of time.
        by: what a piece is.
        settings: how they were identified.
        left_out: bags that are of no piece.
    """
    by_rig = {piece.piece.rig: [p for p in pieces if p.piece.rig == piece.piece.rig] for piece in pieces}
    usable = {rig: [piece for piece in of if piece.report and not piece.problem] for rig, of in by_rig.items()}
    series = {rig: _series([piece.report for piece in of if piece.report]) for rig, of in usable.items()}
    changed = _changes(series)
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
                "quantities": [
                    _quantity(name, one, usable[rig], changed[rig].get(name, [])) for name, one in series[rig].items()
                ],
            }
            for rig, of in by_rig.items()
        ],
        "changes": [*_value_changes(series, usable, changed), *_appearances(series, usable)],
        "differences": _differences(series, changed),
        "left_out": [asdict(bag) for bag in left_out],
    }


def _series(reports: Sequence[Section]) -> dict[str, _Series]:
    found = {
        group_words(group): _Series("group", tuple(fitted_quantity(r, "groups", group.symbol) for r in reports))
        for group in GROUPS
    }
    effects = [effect_quantities(report, of_trials=False) for report in reports]
    for name in dict.fromkeys(name for of_one in effects for name in of_one):
        found[name] = _Series("effect", tuple(of_one.get(name) for of_one in effects))
    for parameter in (INERTIA, *PARAMETERS, *CONSTANTS):
        # Trials with a known weight determine A22 itself, which no base parameter does.
        kind = "group" if parameter is INERTIA else "physical"
        values = _Series(kind, tuple(fitted_quantity(r, "physical", parameter.symbol) for r in reports))
        if values.known:
            found[parameter.symbol] = values
    return {name: one for name, one in found.items() if one.known}


def _changes(series: Mapping[str, Mapping[str, _Series]]) -> dict[str, dict[str, list[Change]]]:
    """Return the changes of each rig's quantities; their places count the known values alone."""
    tests = _count_tests(one for of in series.values() for one in of.values())
    return {
        rig: {name: changes(*one.arrays(), LEVEL, tests) for name, one in of.items() if one.is_compared}
        for rig, of in series.items()
    }


def _count_tests(series: Iterable[_Series]) -> int:
    """Return how many tests for changes there are, of values and of whether an effect is found."""
    return sum((len(one.known) >= FEWEST and one.is_compared) + _comes_and_goes(one) for one in series)


def _comes_and_goes(one: _Series) -> bool:
    return one.kind == "effect" and len(one.quantities) >= FEWEST and None in one.quantities


def _value_changes(
    series: Mapping[str, Mapping[str, _Series]],
    usable: Mapping[str, Sequence[Finished]],
    changed: Mapping[str, Mapping[str, Sequence[Change]]],
) -> list[Section]:
    found = []
    for rig, of in changed.items():
        for name, ones in of.items():
            one = series[rig][name]
            values, std = one.arrays()
            ends = [0, *(change.index for change in ones), len(values)]
            means = [mean(values[a:b], std[a:b]) for a, b in pairwise(ends)]
            for change, (before, after) in zip(ones, pairwise(means), strict=True):
                found.append(
                    {
                        "rig": rig,
                        "quantity": name,
                        "what": "value",
                        **_where(usable[rig], one.known[change.index - 1], one.known[change.index]),
                        "before": asdict(before),
                        "after": asdict(after),
                        "p_value": change.p_value,
                    }
                )
    return found


def _appearances(
    series: Mapping[str, Mapping[str, _Series]], usable: Mapping[str, Sequence[Finished]]
) -> list[Section]:
    tests = _count_tests(one for of in series.values() for one in of.values())
    found = []
    for rig, of in series.items():
        for name, one in of.items():
            seen = [quantity is not None for quantity in one.quantities]
            change = appearance(seen, LEVEL, tests) if _comes_and_goes(one) else None
            if change:
                before, after = seen[: change.index], seen[change.index :]
                found.append(
                    {
                        "rig": rig,
                        "quantity": name,
                        "what": "found",
                        **_where(usable[rig], change.index - 1, change.index),
                        "before": {"found": sum(before), "of": len(before)},
                        "after": {"found": sum(after), "of": len(after)},
                        "p_value": change.p_value,
                    }
                )
    return found


def _where(usable: Sequence[Finished], last: int, first: int) -> Section:
    until, since = usable[last].piece, usable[first].piece
    return {"until": until.name, "since": since.name, "since_start": _start(since)}


def _differences(
    series: Mapping[str, Mapping[str, _Series]], changed: Mapping[str, Mapping[str, Sequence[Change]]]
) -> list[Section]:
    """Return which rigs differ in what, each quantity since its last change."""
    latest: dict[str, dict[str, tuple[Array, Array]]] = {}
    for rig, of in series.items():
        for name, one in of.items():
            if one.is_compared:
                latest.setdefault(name, {})[rig] = one.arrays(_last_change(changed[rig][name]))
    compared = {name: of for name, of in latest.items() if len(of) > 1}
    return [
        {"quantity": name, **{key: list(v) if isinstance(v, tuple) else v for key, v in asdict(difference).items()}}
        for name, of in compared.items()
        for difference in differing(of, LEVEL, len(compared))
    ]


def _last_change(ones: Sequence[Change]) -> int:
    return ones[-1].index if ones else 0


def _start(piece: Piece) -> str:
    return datetime.fromtimestamp(piece.start_ns * 1e-9).astimezone().isoformat(timespec="milliseconds")


def _piece(finished: Finished) -> Section:
    piece, report = finished.piece, finished.report
    return {
        "name": piece.name,
        "start": _start(piece),
        "bags": [str(bag.path) for bag in piece.bags],
        "left_out": [asdict(bag) for bag in finished.left_out],
        "folder": f"{finished.folder.parent.name}/{finished.folder.name}",
        "has_report": report is not None,
        "rmse_holdout_rad": report and report["after"]["error"]["holdout"]["rmse_rad"],
        "noise_rad": report and noise_floor(report),
        "verdict": report and report["verdict"],
        "problem": finished.problem,
    }


def _quantity(name: str, one: _Series, usable: Sequence[Finished], ones: Sequence[Change]) -> Section:
    """Return a quantity over time; what an effect is as the motion shows it, torques over A22."""
    latest = mean(*one.arrays(_last_change(ones)))
    return {
        "name": name,
        "kind": one.kind,
        "unit": _UNITS.get(name, ""),
        "estimates": [
            {"piece": piece.piece.name, "start": _start(piece.piece), "value": q.value, "std": q.std, "words": q.text}
            for piece, q in zip(usable, one.quantities, strict=True)
            if q and q.is_known
        ],
        "latest": {**asdict(latest), "pieces": len(one.known) - _last_change(ones)},
    }

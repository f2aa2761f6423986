# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A survey as tables and sentences, for terminal and page."""

from collections.abc import Iterator, Sequence

from markupsafe import Markup

from cdp_ident.report.document import Chapter, Charts, Row, Table
from cdp_ident.report.figures.description import Figure
from cdp_ident.report.schema import Section
from cdp_ident.report.wording import in_unit, milliradians, unit

_NONE = "–"


def verdict(survey: Section) -> str:
    """Return a survey in one sentence."""
    pieces = [piece for rig in survey["rigs"] for piece in rig["pieces"]]
    without = sum(bool(piece["problem"]) for piece in pieces)
    said = [f"{_counted(len(survey['rigs']), 'rig')}, {_counted(len(pieces), 'piece')}"]
    if without:
        said[0] += f", {without} of them without a result"
    said += [
        f"{change['rig']} changed in {_short(change['quantity'])} between {change['until']} and {change['since']}"
        for change in survey["changes"]
    ]
    said += [
        f"{difference['rig']} differs from {' and '.join(difference['others'])} in {_short(difference['quantity'])}"
        for difference in survey["differences"]
    ]
    if len(said) == 1:
        said.append("nothing changed, and no rig differs, by more than the estimates scatter")
    return f"{'; '.join(said)}."


def chapter(survey: Section, figures: Sequence[Figure] = ()) -> Chapter:
    """Return what changed, which rig differs, where the rigs are now, the pieces, and what has no result."""
    return Chapter(
        "result",
        "",
        (
            _changed(survey),
            _different(survey),
            _latest(survey),
            Charts(figures),
            Table(
                "Pieces",
                ("rig", survey["by"], "bags", "held out [mrad]", "result"),
                list(_pieces(survey)),
                at_terminal=False,
            ),
            Table("Without a result", ("rig", "what", "why"), list(_problems(survey))),
        ),
    )


def _pieces(survey: Section) -> Iterator[Row]:
    for rig in survey["rigs"]:
        for piece in rig["pieces"]:
            has_report, name = piece["has_report"], piece["name"]
            bags = len(piece["bags"]) - len(piece["left_out"])
            error = milliradians(piece["rmse_holdout_rad"]) if has_report else _NONE
            if has_report:
                name = Markup('<a href="{}/report.html">{}</a>').format(piece["folder"], name)
            yield rig["name"], name, str(bags), error, piece["problem"] or piece["verdict"]


def _changed(survey: Section) -> Table:
    return Table(
        "What changed",
        ("rig", "quantity", "last before", "first after", "before", "after", "change", "p"),
        tuple(
            (
                change["rig"],
                change["quantity"],
                change["until"],
                change["since"],
                *_sides(survey, change),
                f"{change['p_value']:.2g}",
            )
            for change in survey["changes"]
        ),
        "p: probability that chance shows as clear a change anywhere in the survey; reported below "
        f"{survey['level']:g}.",
    )


def _sides(survey: Section, change: Section) -> tuple[str, str, str]:
    before, after = change["before"], change["after"]
    if change["what"] == "found":
        return *(f"found in {side['found']} of {side['of']}" for side in (before, after)), _NONE  # type: ignore[return-value]
    symbol = _unit(survey, change["quantity"])
    was, now = (in_unit(side["value"], side["std"], symbol) for side in (before, after))
    return was, now, _percent(after["value"], before["value"])


def _different(survey: Section) -> Table:
    return Table(
        "Which rig differs",
        ("rig", "from", "quantity", "it has", "they have", "difference", "in std", "p"),
        tuple(
            (
                found["rig"],
                ", ".join(found["others"]),
                found["quantity"],
                f"{found['value']:.5g} {_unit(survey, found['quantity'])}".strip(),
                f"{found['others_value']:.5g} {_unit(survey, found['quantity'])}".strip(),
                _percent(found["value"], found["others_value"]),
                f"{(found['value'] - found['others_value']) / found['std']:+.1f}" if found["std"] else _NONE,
                f"{found['p_value']:.2g}",
            )
            for found in survey["differences"]
        ),
        "Each rig since its last change; the one that differs most is left out before the others are compared. "
        f"p: probability that chance shows as clear a difference; reported below {survey['level']:g}.",
    )


def _latest(survey: Section) -> Table:
    rigs = survey["rigs"]
    by_rig = [{quantity["name"]: quantity for quantity in rig["quantities"]} for rig in rigs]
    names = dict.fromkeys(name for of in by_rig for name in of)
    return Table(
        "Parameters and effects, since their last change",
        ("quantity", *(rig["name"] for rig in rigs)),
        tuple((name, *(_latest_words(of.get(name)) for of in by_rig)) for name in names),
        "Means with standard deviations by how much the pieces scatter, and of how many pieces; torques over A22.",
    )


def _latest_words(quantity: Section | None) -> str:
    if quantity is None:
        return _NONE
    latest = quantity["latest"]
    return f"{in_unit(latest['value'], latest['std'], quantity['unit'])} ({latest['pieces']})"


def _problems(survey: Section) -> Iterator[Row]:
    for rig in survey["rigs"]:
        for piece in rig["pieces"]:
            if piece["problem"]:
                yield rig["name"], piece["name"], piece["problem"]
            for bag in piece["left_out"]:
                yield rig["name"], bag["bag"], bag["reason"]
    for bag in survey["left_out"]:
        yield _NONE, bag["bag"], bag["reason"]


def _unit(survey: Section, name: str) -> str:
    every = (quantity for rig in survey["rigs"] for quantity in rig["quantities"])
    return unit(next((quantity["unit"] for quantity in every if quantity["name"] == name), ""))


def _percent(value: float, reference: float) -> str:
    return f"{100.0 * (value / reference - 1.0):+.3g} %" if reference else _NONE


def _short(name: str) -> str:
    return name.partition(" = ")[0]


def _counted(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"

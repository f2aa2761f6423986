# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A survey as sentences, tables and figures, for terminal and page: what changed, and which rig differs."""

from collections.abc import Iterator, Sequence

import numpy as np
from markupsafe import Markup

from cdp_ident.fit.physical import CONFIDENCE
from cdp_ident.report.document import Chapter, Charts, Document, Row, Table
from cdp_ident.report.figures.description import Axis, Figure, Line, Panel, series
from cdp_ident.report.pictures import page_of
from cdp_ident.report.schema import Section
from cdp_ident.report.wording import in_unit, milliradians, unit

_NONE = "–"
_MOST_TICKS = 3
"""Dates for which a phone has room."""
_SPREAD = 0.5
"""Of the rigs about the place of their day."""


def survey_html(survey: Section) -> str:
    """Return `survey.html`."""
    names = ", ".join(rig["name"] for rig in survey["rigs"])
    about = f"Cart double pendulum, rigs surveyed by {survey['by']}"
    return page_of(Document(about, names, verdict(survey), (chapter(survey, figures(survey)),)))


def verdict(survey: Section) -> str:
    """Return a survey in one sentence."""
    pieces = [piece for rig in survey["rigs"] for piece in rig["pieces"]]
    without = sum(bool(piece["problem"]) for piece in pieces)
    counted = f"{_counted(len(survey['rigs']), 'rig')}, {_counted(len(pieces), 'piece')}"
    said = [
        f"{change['rig']} changed in {_short(change['quantity'])} between {change['until']} and {change['since']}"
        for change in survey["changes"]
    ]
    said += [
        f"{found['rig']} differs from {' and '.join(found['others'])} in {_short(found['quantity'])}"
        for found in survey["differences"]
    ]
    found = "; ".join(said or ["nothing changed, and no rig differs, by more than the estimates scatter"])
    return f"{counted}{f', {without} of them without a result' if without else ''}; {found}."


def _counted(number: int, noun: str) -> str:
    return f"{number} {noun}{'' if number == 1 else 's'}"


def _short(name: str) -> str:
    return name.partition(" = ")[0]


def chapter(survey: Section, figures: Sequence[Figure] = ()) -> Chapter:
    """Return what changed, which rig differs, where the rigs are now, the pieces, and what has no result."""
    tables = (
        Table(
            "What changed",
            ("rig", "quantity", "last before", "first after", "before", "after", "change", "p"),
            list(_changed(survey)),
            "p: probability that chance shows as clear a change anywhere in the survey; reported below "
            f"{survey['level']:g}.",
        ),
        Table(
            "Which rig differs",
            ("rig", "from", "quantity", "it has", "they have", "difference", "in std", "p"),
            list(_different(survey)),
            "Each rig since its last change; the one that differs most is left out before the others are compared. "
            f"p: probability that chance shows as clear a difference; reported below {survey['level']:g}.",
        ),
        Table(
            "Parameters and effects, since their last change",
            ("quantity", *(rig["name"] for rig in survey["rigs"])),
            list(_latest(survey)),
            "Means with standard deviations by how much the pieces scatter, and of how many pieces; torques over A22.",
        ),
    )
    columns = ("rig", survey["by"], "bags", "held out [mrad]", "result")
    pieces = Table("Pieces", columns, list(_pieces(survey)), at_terminal=False)
    problems = Table("Without a result", ("rig", "what", "why"), list(_problems(survey)))
    return Chapter("result", "", (*tables, Charts(figures), pieces, problems))


def _changed(survey: Section) -> Iterator[Row]:
    for change in survey["changes"]:
        before, after = change["before"], change["after"]
        if change["what"] == "found":
            was, now = (f"found in {side['found']} of {side['of']}" for side in (before, after))
            by = _NONE
        else:
            symbol = _unit(survey, change["quantity"])
            was, now = (in_unit(side["value"], side["std"], symbol) for side in (before, after))
            by = _percent(after["value"], before["value"])
        p_value = f"{change['p_value']:.2g}"
        yield change["rig"], change["quantity"], change["until"], change["since"], was, now, by, p_value


def _different(survey: Section) -> Iterator[Row]:
    for found in survey["differences"]:
        value, others, std = found["value"], found["others_value"], found["std"]
        it_has, they_have = (f"{of:.5g} {_unit(survey, found['quantity'])}".strip() for of in (value, others))
        deviations = f"{(value - others) / std:+.1f}" if std else _NONE
        compared = it_has, they_have, _percent(value, others), deviations, f"{found['p_value']:.2g}"
        yield found["rig"], ", ".join(found["others"]), found["quantity"], *compared


def _latest(survey: Section) -> Iterator[Row]:
    by_rig = [{quantity["name"]: quantity for quantity in rig["quantities"]} for rig in survey["rigs"]]
    for name in dict.fromkeys(name for of in by_rig for name in of):
        yield name, *(_latest_words(of.get(name)) for of in by_rig)


def _latest_words(quantity: Section | None) -> str:
    if quantity is None:
        return _NONE
    latest = quantity["latest"]
    return f"{in_unit(latest['value'], latest['std'], quantity['unit'])} ({latest['pieces']})"


def _pieces(survey: Section) -> Iterator[Row]:
    for rig in survey["rigs"]:
        for piece in rig["pieces"]:
            name, error = piece["name"], _NONE
            if piece["has_report"]:
                name = Markup('<a href="{}/report.html">{}</a>').format(piece["folder"], name)
                error = milliradians(piece["rmse_holdout_rad"])
            bags = len(piece["bags"]) - len(piece["left_out"])
            yield rig["name"], name, str(bags), error, piece["problem"] or piece["verdict"]


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


def figures(survey: Section) -> list[Figure]:
    """Return each quantity over time, rig beside rig."""
    every = [(index, rig["name"], q) for index, rig in enumerate(survey["rigs"]) for q in rig["quantities"]]
    in_order = sorted({_place(survey, estimate) for _, _, quantity in every for estimate in quantity["estimates"]})
    places = {place: index for index, place in enumerate(in_order)}
    return [
        _over_time(survey, number, name, [one for one in every if one[2]["name"] == name], places)
        for number, name in enumerate(dict.fromkeys(quantity["name"] for _, _, quantity in every))
    ]


def _place(survey: Section, estimate: Section) -> str:
    """Return what a piece's place in time goes by: its day, or the start of its bag."""
    return str(estimate["piece"] if survey["by"] == "day" else estimate["start"])


def _over_time(
    survey: Section, number: int, name: str, rigs: list[tuple[int, str, Section]], places: dict[str, int]
) -> Figure:
    marks: list[Line] = []
    count = max(2, len(survey["rigs"]))
    for index, rig, quantity in rigs:
        estimates = quantity["estimates"]
        colour, shape = series(index)
        at = [places[_place(survey, e)] + _SPREAD * (index - (count - 1) / 2) / count for e in estimates]
        values = [e["value"] for e in estimates]
        half_widths = [CONFIDENCE * e["std"] for e in estimates]
        words = [f"{e['piece']}: {e['words']}" for e in estimates]
        marks.append(
            Line(
                rig, colour, np.array(at), np.array(values), 0.0, shape=shape, size=9.0, half_widths=half_widths,
                upright=True, words=words,
            )
        )  # fmt: skip
        last = np.cumsum([stretch["pieces"] for stretch in quantity["stretches"]]) - 1
        for end, stretch in zip(last, quantity["stretches"], strict=True):
            if (begin := end - stretch["pieces"] + 1) < end:
                ends = np.array([at[begin] - 0.2, at[end] + 0.2])
                marks.append(Line(rig, colour, ends, np.full(2, stretch["value"]), dash="dash"))
    return Figure(
        f"survey_{number}",
        name,
        f"With 95 % intervals, one place for each {survey['by']}, in the order of time; dashed: means between changes.",
        [Panel(Axis(ticks=_ticks(places)), Axis(unit(rigs[0][2]["unit"])), marks, height=220.0)],
    )


def _ticks(places: dict[str, int]) -> list[tuple[float, str]]:
    chosen = {round(index) for index in np.linspace(0, len(places) - 1, min(_MOST_TICKS, len(places)))}
    return [(float(index), place[:10]) for place, index in places.items() if index in chosen]

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""`survey.html`: parameters and effects over time, what changed, which rig differs."""

import numpy as np

from cdp_ident.fit.physical import CONFIDENCE
from cdp_ident.report.document import Document
from cdp_ident.report.figures.description import Axis, Figure, Line, Panel, series
from cdp_ident.report.pictures import page_of
from cdp_ident.report.schema import Section
from cdp_ident.report.wording import unit
from cdp_ident.survey.tables import chapter, verdict

_MOST_TICKS = 3
"""Dates for which a phone has room."""
_SPREAD = 0.5
"""Of the rigs about the place of their day."""


def survey_html(survey: Section) -> str:
    """Return `survey.html`."""
    names = ", ".join(rig["name"] for rig in survey["rigs"])
    about = f"Cart double pendulum, rigs surveyed by {survey['by']}"
    return page_of(Document(about, names, verdict(survey), (chapter(survey, figures(survey)),)))


def figures(survey: Section) -> list[Figure]:
    """Return each quantity over time, rig beside rig."""
    every = [(index, rig["name"], q) for index, rig in enumerate(survey["rigs"]) for q in rig["quantities"]]
    places = {
        place: index
        for index, place in enumerate(sorted({_place(survey, e) for _, _, q in every for e in q["estimates"]}))
    }
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
    said = []
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
        for begin, end, level in _stretches(survey, rig, quantity):
            marks.append(
                Line(rig, colour, np.array([at[begin] - 0.2, at[end] + 0.2]), np.array([level, level]), dash="dash")
            )
        said.append(f"{rig}: {quantity['latest']['value']:.4g} in the last {quantity['latest']['pieces']} of {len(at)}")
    return Figure(
        f"survey_{number}",
        name,
        "With 95 % intervals, one place for each " + ("day" if survey["by"] == "day" else "bag")
        + ", in the order of time; dashed: means between changes.",
        f"{name} over time. {'; '.join(said)}.",
        [Panel(Axis(ticks=_ticks(places)), Axis(unit(rigs[0][2]["unit"])), marks, height=220.0)],
    )  # fmt: skip


def _stretches(survey: Section, rig: str, quantity: Section) -> list[tuple[int, int, float]]:
    """Return the first and last estimate of each stretch between changes, and the mean."""
    changes = [
        change
        for change in survey["changes"]
        if (change["rig"], change["quantity"], change["what"]) == (rig, quantity["name"], "value")
    ]
    starts = [estimate["start"] for estimate in quantity["estimates"]]
    begins = [0, *(starts.index(change["since_start"]) for change in changes)]
    ends = [*(begin - 1 for begin in begins[1:]), len(starts) - 1]
    levels = [*(change["before"]["value"] for change in changes), quantity["latest"]["value"]]
    return [stretch for stretch in zip(begins, ends, levels, strict=True) if stretch[0] < stretch[1]]


def _ticks(places: dict[str, int]) -> list[tuple[float, str]]:
    chosen = {round(index) for index in np.linspace(0, len(places) - 1, min(_MOST_TICKS, len(places)))}
    return [(float(index), place[:10]) for place, index in places.items() if index in chosen]

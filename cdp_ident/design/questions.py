# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a next trial is to determine, and the start that answers it best."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.design.discrimination import RecordedMotion, alternatives
from cdp_ident.design.knowledge import Knowledge
from cdp_ident.design.next_trial import Loads, NextTrial, loads_of, telling_weight
from cdp_ident.design.starts import CandidateTrial, Grid, Survey
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.model.parameters import GROUPS, INERTIA, INVERSE_INERTIA
from cdp_ident.model.weights import Weight

ALL = "all"
"""The name that stands for all base parameters."""
_SHOWN = 1.0
"""A value that is not determined yet, and not to so many times itself then, a trial does not show but for rounding."""
_GROUPS = tuple(group.symbol for group in GROUPS)


@dataclass(frozen=True)
class Question:
    """What a next trial is to determine."""

    about: str
    """All base parameters, A22, another unknown by its name, or an effect of the model by its label."""
    against: str = ""
    """Key of the effect that it is to be distinguished from, as in `also_possible`; name and joint stand for all its
    forms."""


@dataclass(frozen=True)
class Advice:
    """The start that answers a question best, and what a trial from there would bring.

    What it brings is the share of their width to which intervals fall or, where one value is not determined yet, its
    relative standard deviation then; of two effects, the standard deviations between them. Infinite is nothing.
    """

    question: Question
    trial: CandidateTrial
    expected: float
    """What it brings: the median over what a hand may miss the start by."""
    worst: float
    """The worst of the same."""
    expected_unloaded: float
    """That of the start that is best without a weight; infinite where that is the trial."""
    grid: Grid
    values: Array
    """(inner, outer) the same as `expected` for each start of the grid, were it met exactly."""
    names: Sequence[str] = ()
    """The unknowns that it tells of."""
    std_now: Array | Sequence[float] = ()
    """Their standard deviations."""
    std_then: Array | Sequence[float] = ()
    """The same after a trial that begins exactly there."""
    deviations_now: float = np.inf
    """Between the two effects in the trials that there are."""

    @classmethod
    def of(cls, question: Question, best: Survey, unit: float, most: float = np.inf, **told: Any) -> "Advice":
        """Return what a survey says; its losses are in a unit, and tell nothing beyond the `most`."""

        def read(losses: Array | float) -> Array:
            shown = unit * np.asarray(losses)
            return np.where(shown > most, np.inf, shown)

        expected, worst = float(read(best.expected)), float(read(best.worst))
        unloaded = float(read(best.unloaded.expected)) if best.unloaded and best.trial.weights else np.inf
        return cls(question, best.trial, expected, worst, unloaded, best.grid, read(best.losses), **told)


def usual_questions(model: MotionModel, possible: Sequence[Sequence[str]]) -> list[Question]:
    """Return the default questions: effects that could be others, all base parameters, each effect's strength, A22.

    `possible` is what could stand in the place of each effect of the model.
    """
    doubts = [Question(label, other) for label, others in zip(model.labels, possible, strict=True) for other in others]
    strengths = [Question(name) for label in model.labels for name in [strength_of(model, label)] if name]
    return [*doubts, Question(ALL), *strengths, Question(INERTIA.symbol)]


def strength_of(model: MotionModel, label: str) -> str:
    """Return the name of the unknown that says how strong an effect is; empty where none does, or it happens once."""
    active = model.effects[model.labels.index(label)]
    if active.trial is not None or active.effect.curve is not None:
        return ""
    return next((f"{label}.{p.name}" for p in active.fitted if not p.shape), "")


def answers(
    knowledge: Knowledge,
    motion: Callable[[Knowledge], RecordedMotion],
    questions: Sequence[Question],
    grid: Grid,
    weights: Sequence[tuple[Weight, ...]] = (),
    ends: Callable[[], bool] = lambda: False,
) -> Iterator[Advice | None]:
    """Yield the best start for each question; None where two effects cannot be compared.

    Each start is tried without a weight, and with each of the weights. Where there is none, and no trial shows A22,
    that is asked for with a weight that would show it, and every second angle: a proposal needs no more.

    Args:
        knowledge: of the rig.
        motion: returns that of the trials that there are, given what is known.
        questions: what is asked.
        grid: starts to choose from.
        weights: what the rods may carry; what is given twice is tried once.
        ends: asked repeatedly; true ends the search for them.

    Raises:
        IdentificationError: it is ended, or none of them has a motion that can be computed.
    """
    loads = loads_of(weights)
    showing = loads if knowledge.shows_inertia else loads[1:] or ((telling_weight(knowledge),),)
    knowledge = knowledge.with_weights(weight for load in (*loads, *showing) for weight in load)
    trials = NextTrial(knowledge, grid, ends)
    few = grid if showing[0] in loads else grid.thinned
    for question in questions:
        if question.against:
            found = alternatives(knowledge, motion(knowledge), question.about, question.against)
            nearest = min(found, key=lambda alternative: alternative.deviations_now, default=None)
            if nearest is None or nearest.can_be_the_same:
                yield None
            else:
                best, now = trials.furthest_apart(nearest, loads), nearest.deviations_now
                yield Advice.of(question, best, -1.0, deviations_now=now)
        elif question.about == INERTIA.symbol:
            yield _sharper(question, (INVERSE_INERTIA.symbol,), trials, showing, few)
        else:
            yield _sharper(question, _GROUPS if question.about == ALL else (question.about,), trials, loads, grid)


def _sharper(question: Question, names: tuple[str, ...], trials: NextTrial, loads: Loads, grid: Grid) -> Advice:
    best, knowledge = trials.sharpest(names, loads, grid), trials.knowledge
    now, then = knowledge.uncertainty(names), trials.uncertainty_after(best.trial, names)
    values, inertia = knowledge.values[knowledge.places(names)], question.about == INERTIA.symbol
    # Of A22 the unknown is the inverse: a small change of it is A22 squared times as large in A22.
    scale = float(np.divide(1.0, values[0] ** 2)) if inertia else 1.0
    told: dict[str, Any] = {
        "names": [INERTIA.symbol] if inertia else names,
        "std_now": scale * now.std,
        "std_then": scale * then.std,
    }
    if np.isfinite(now.size):
        return Advice.of(question, best, 1.0 / now.size, **told)
    size = abs(float(values[0])) if len(names) == 1 else 0.0
    return Advice.of(question, best, 1.0 / size if size else 0.0, _SHOWN, **told)

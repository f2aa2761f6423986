"""The information that a next trial would bring, as `report.json` holds it."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cdp_ident.design.discrimination import Rival, can_be_the_same, rivals
from cdp_ident.design.knowledge import Knowledge
from cdp_ident.design.next_trial import Apart, NextTrial, Sharper
from cdp_ident.design.starts import Grid, Survey
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.windows import Window
from cdp_ident.model.parameters import GROUPS
from cdp_ident.report.outcome import Outcome
from cdp_ident.report.schema import Section

Array = npt.NDArray[np.float64]

ALL = "all"
"""The name that stands for all base parameters."""
REPORT_SPACING = 45.0
"""Of the starts that a report surveys [degrees]."""
_GROUPS = tuple(group.symbol for group in GROUPS)


@dataclass(frozen=True)
class Question:
    """What a next trial is to determine."""

    about: str
    """All base parameters, an unknown by its name, or an effect of the model by its label."""
    against: str = ""
    """Name and joint of the effect that it is to be distinguished from, as in `also_possible`."""


def next_trial_section(outcome: Outcome, failed: Callable[[str], None]) -> Section | None:
    """Return the most informative next trials; None where the fit failed.

    Where no motion can be computed there is none either, and `failed` is called with the reason.
    """
    trace, found = outcome.trace, outcome.identification
    if trace.failure:
        return None
    fit = trace.after.fit
    try:
        knowledge = Knowledge.of(fit, trace.covariance, found.data.scales, found.options.window)
        windows = [replace(w, theta=w.theta - error) for w, error in zip(fit.windows, fit.errors, strict=True)]
        possible = {label: effect.also_possible for label, effect in zip(fit.model.labels, trace.effects, strict=True)}
        questions = usual_questions(knowledge.model, possible)
        advice = answers(knowledge, windows, questions, Grid.of(REPORT_SPACING))
        return {"assumed": _assumed(knowledge), "advice": [section for section in advice if section]}
    except (IdentificationError, np.linalg.LinAlgError) as error:
        failed(f"which trial to record next: {error}")
        return None


def usual_questions(model: MotionModel, possible: Mapping[str, Sequence[str]]) -> list[Question]:
    """Return the default questions: effects that could be others, all base parameters, and each effect's strength.

    Args:
        model: the fitted one.
        possible: of each effect, by its label, what could stand in its place.
    """
    doubts = [Question(label, other) for label, others in possible.items() for other in others]
    strengths = [Question(name) for label in model.labels for name in [strength_of(model, label)] if name]
    return [*doubts, Question(ALL), *strengths]


def strength_of(model: MotionModel, label: str) -> str:
    """Return the name of the unknown that says how strong an effect is; empty where none does, or it happens once."""
    active = model.effects[model.labels.index(label)]
    if active.trial is not None or active.effect.curve is not None:
        return ""
    return next((f"{label}.{p.name}" for p in active.fitted if not p.shape), "")


def answers(
    knowledge: Knowledge, windows: Sequence[Window], questions: Sequence[Question], grid: Grid
) -> Iterator[Section | None]:
    """Yield the best start for each question; None where two effects cannot be compared.

    Args:
        knowledge: what is known.
        windows: of the trials that there are, their angles being those of the fitted model.
        questions: what is asked.
        grid: starts to choose from.

    Raises:
        IdentificationError: none of them has a motion that can be computed.
    """
    trials = NextTrial(knowledge, grid)
    for question in questions:
        if question.against:
            rival = _nearest_rival(knowledge, windows, question)
            yield None if rival is None else _apart(question, trials.furthest_apart(rival))
        else:
            names = _GROUPS if question.about == ALL else (question.about,)
            yield _sharper(question, trials.sharpest(names))


def _nearest_rival(knowledge: Knowledge, windows: Sequence[Window], question: Question) -> Rival | None:
    """Return the form of the other effect that comes nearest; None where it can be the same, or cannot be fitted."""
    name, _, joint = question.against.partition(" ")
    found = rivals(knowledge, windows, question.about, name, joint)
    nearest = min(found, key=lambda rival: rival.deviations_now, default=None)
    return None if nearest is None or can_be_the_same(nearest) else nearest


def _sharper(question: Question, found: Sharper) -> Section:
    return {
        **_surveyed(question, found.survey, 1.0 / found.size_now if np.isfinite(found.size_now) else 0.0),
        "names": list(found.criterion.names),
        "std_now": found.now.tolist(),
        "std_then": found.then.tolist(),
        "deviations_now": None,
    }


def _apart(question: Question, found: Apart) -> Section:
    return {
        **_surveyed(question, found.survey, -1.0),
        "names": [],
        "std_now": [],
        "std_then": [],
        "deviations_now": found.rival.deviations_now,
    }


def _surveyed(question: Question, found: Survey, unit: float) -> Section:
    return {
        "for": question.about,
        "against": question.against or None,
        "inner_rad": found.inner,
        "outer_rad": found.outer,
        "expected": unit * found.expected,
        "worst": unit * found.worst,
        "map": {
            "inner_rad": found.grid.inner.tolist(),
            "outer_rad": found.grid.outer.tolist(),
            "values": (unit * found.losses).tolist(),
        },
    }


def _assumed(knowledge: Knowledge) -> Section:
    sampling = knowledge.sampling
    return {
        "noise_rad": knowledge.noise,
        "whitening": knowledge.whitening.tolist(),
        "duration_s": sampling.duration,
        "interval_s": sampling.interval,
        "window_s": sampling.window,
        "shortest_window_s": sampling.shortest_window,
        "half_width_s": sampling.half_width,
        "step_s": sampling.step,
    }

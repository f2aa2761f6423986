# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The information that a next trial would bring, as `report.json` holds it."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from cdp_ident.design.discrimination import Alternative, RecordedMotion, alternatives
from cdp_ident.design.knowledge import Knowledge
from cdp_ident.design.next_trial import Loads, NextTrial, Sharper, loads_of, telling_weight
from cdp_ident.design.starts import Grid, Survey
from cdp_ident.errors import CdpIdentError
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.model.parameters import GROUPS, INERTIA, INVERSE_INERTIA
from cdp_ident.model.weights import Weight
from cdp_ident.report.curves import Array
from cdp_ident.report.filling import Also, filled
from cdp_ident.report.outcome import Outcome
from cdp_ident.report.schema import ADVICE, REPORT, Section

NOISES = {"new_noise_rad": "new", "noise_kept": "kept", "noise_mixed": "mixed", "unknown_torque_over_A22": "torque"}
"""What is assumed of encoders and unknown torques, as `Noise` names it."""
ALL = "all"
"""The name that stands for all base parameters."""
REPORT_SPACING = 45.0
"""Of the starts that a report surveys [degrees]."""
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


def next_trial_section(outcome: Outcome, failed: Callable[[str], None]) -> Section | None:
    """Return the most informative next trials; None where the fit failed.

    Where no motion can be computed there is none either, and `failed` is called with the reason.
    """
    trace, data = outcome.trace, outcome.identification.data
    if trace.failure:
        return None
    last = trace.completed
    try:
        knowledge = Knowledge.of(last.whole, last.fit.values, trace.covariance, last.inertia.value)
        motion = partial(RecordedMotion.of, trials=data.trials)
        labels = knowledge.model.labels
        possible = {label: effect.also_possible for label, effect in zip(labels, trace.effects, strict=True)}
        questions = usual_questions(knowledge.model, possible)
        used = [trial.weights for trial in (*outcome.loaded.fit, *outcome.loaded.holdout)]
        advice = answers(knowledge, motion, questions, Grid.of(REPORT_SPACING), used)
        section = {"assumed": _assumed(knowledge), "advice": [one for one in advice if one]}
        return dict(filled(REPORT["properties"]["next_trial"], section))
    except (CdpIdentError, np.linalg.LinAlgError) as error:
        failed(f"which trial to record next: {error}")
        return None


def usual_questions(model: MotionModel, possible: Mapping[str, Sequence[str]]) -> list[Question]:
    """Return the default questions: effects that could be others, all base parameters, each effect's strength, A22.

    Args:
        model: the fitted one.
        possible: of each effect, by its label, what could stand in its place.
    """
    doubts = [Question(label, other) for label, others in possible.items() for other in others]
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
) -> Iterator[Section | None]:
    """Yield the best start for each question; None where two effects cannot be compared.

    Each start is tried without a weight, and with each of the weights. Where there is none, and no trial shows A22,
    that is asked for with a weight that would show it, and every second angle: a proposal needs no more.

    Args:
        knowledge: what is known.
        motion: of the trials that there are, given a model and its values.
        questions: what is asked.
        grid: starts to choose from.
        weights: what the rods may carry; what is given twice is tried once.

    Raises:
        IdentificationError: none of them has a motion that can be computed.
    """
    loads = loads_of(weights)
    showing = loads if knowledge.shows_inertia else loads[1:] or ((telling_weight(knowledge),),)
    knowledge = knowledge.with_weights(weight for load in (*loads, *showing) for weight in load)
    trials = NextTrial(knowledge, grid)
    few = grid if showing[0] in loads else grid.thinned
    for question in questions:
        if question.against:
            alternative = _nearest_alternative(knowledge, motion(knowledge), question)
            yield _apart(question, alternative, trials, loads) if alternative else None
            continue
        of_inertia = question.about == INERTIA.symbol
        names = _GROUPS if question.about == ALL else (INVERSE_INERTIA.symbol if of_inertia else question.about,)
        how = (showing, few) if of_inertia else (loads, grid)
        yield _sharper(question, knowledge, names, trials.sharpest(names, *how))


def _nearest_alternative(knowledge: Knowledge, motion: RecordedMotion, question: Question) -> Alternative | None:
    """Return the form of the other effect that comes nearest; None where it can be the same, or cannot be fitted."""
    found = alternatives(knowledge, motion, question.about, question.against)
    nearest = min(found, key=lambda alternative: alternative.deviations_now, default=None)
    return None if nearest is None or nearest.can_be_the_same else nearest


def _sharper(question: Question, knowledge: Knowledge, names: tuple[str, ...], found: Sharper) -> Section:
    values = knowledge.values[knowledge.places(names)]
    inertia = question.about == INERTIA.symbol
    # Of A22 the unknown is the inverse: a small change of it is A22 squared times as large in A22.
    scale = 1.0 / float(values[0]) ** 2 if inertia else 1.0
    told = {
        "names": [INERTIA.symbol] if inertia else names,
        "std_now": scale * found.now.std,
        "std_then": scale * found.then.std,
        "deviations_now": np.inf,
    }
    if np.isfinite(found.now.size):
        return _advice(question, found.survey, told, 1.0 / found.now.size)
    size = abs(float(values[0])) if len(names) == 1 else 0.0
    return _advice(question, found.survey, told, 1.0 / size if size else 0.0, _SHOWN)


def _apart(question: Question, alternative: Alternative, trials: NextTrial, loads: Loads) -> Section:
    told = {"names": [], "std_now": [], "std_then": [], "deviations_now": alternative.deviations_now}
    return _advice(question, trials.furthest_apart(alternative, loads), told, -1.0)


def _advice(question: Question, best: Survey, told: Section, unit: float, most: float = np.inf) -> Section:
    """Return the best start; losses are in a unit, and infinite beyond the most that a trial tells anything with."""

    def read(losses: Array | float) -> Array:
        shown = unit * np.asarray(losses)
        return np.where(shown > most, np.inf, shown)

    start = {
        "for": question.about,
        "against": question.against or None,
        "expected": read(best.expected),
        "worst": read(best.worst),
        "expected_unloaded": read(best.unloaded.expected) if best.unloaded and best.trial.weights else np.inf,
        "map": Also(best.grid, {"values": read(best.losses)}),
    }
    return dict(filled(ADVICE, Also(best.trial, {**start, **told})))


def _assumed(knowledge: Knowledge) -> Also:
    noise, sampling = knowledge.noise, knowledge.sampling
    of_noise = {name: getattr(noise, of) for name, of in NOISES.items()}
    also = {"step_rad": sampling.steps, "time_noise_s": noise.time, "base_moves": noise.of_base}
    return Also(sampling, {**of_noise, **also})

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which trial to record next: what `report.json` holds of it, in words, and as maps over the starts."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.design.discrimination import RecordedMotion, alternatives
from cdp_ident.design.knowledge import Knowledge
from cdp_ident.design.next_trial import Loads, NextTrial, loads_of, telling_weight
from cdp_ident.design.starts import HAND, Grid, Survey
from cdp_ident.errors import CdpIdentError
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.physical import CONFIDENCE
from cdp_ident.model.parameters import GROUPS, INERTIA, INVERSE_INERTIA
from cdp_ident.model.weights import Weight
from cdp_ident.report.figures.description import Axis, Figure, Heat, Line, Panel
from cdp_ident.report.outcome import Outcome
from cdp_ident.report.schema import ADVICE, REPORT, Also, Section, filled
from cdp_ident.report.wording import key_words, short_name, weights_words

NOISES = {
    "new_noise_rad": "new", "noise_kept": "kept", "noise_mixed": "mixed", "unknown_torque_over_A22": "torque",
    "time_noise_s": "time", "base_moves": "of_base", "absolute_angles": "absolute",
}  # fmt: skip
"""What is assumed of encoders and unknown torques, as `Noise` names it."""
ALL = "all"
"""The name that stands for all base parameters."""
REPORT_SPACING = 45.0
"""Of the starts that a report surveys [degrees]."""
_SHOWN = 1.0
"""A value that is not determined yet, and not to so many times itself then, a trial does not show but for rounding."""
_HARDLY_LESS = 0.95
"""What leaves intervals as wide as that share of what they are is not worth a trial."""
_GROUPS = tuple(group.symbol for group in GROUPS)


@dataclass(frozen=True)
class Question:
    """What a next trial is to determine."""

    about: str
    """All base parameters, A22, another unknown by its name, or an effect of the model by its label."""
    against: str = ""
    """Key of the effect that it is to be distinguished from, as in `also_possible`; name and joint stand for all its
    forms."""


def next_trial_section(
    outcome: Outcome, failed: Callable[[str], None], ends: Callable[[], bool] = lambda: False
) -> Section | None:
    """Return the most informative next trials; None where the fit failed.

    Where no motion can be computed, or `ends` returns true meanwhile, there is none either, and `failed` is called with
    the reason.
    """
    trace, data = outcome.trace, outcome.identification.data
    if trace.failure:
        return None
    last = trace.completed
    try:
        knowledge = Knowledge.of(last.whole, last.fit.values, trace.covariance, last.inertia.value)
        motion = partial(RecordedMotion.of, trials=data.trials)
        questions = usual_questions(knowledge.model, [effect.also_possible for effect in trace.effects])
        used = [trial.weights for trial in outcome.loaded.trials]
        advice = answers(knowledge, motion, questions, Grid.of(REPORT_SPACING), used, ends)
        assumed = {name: getattr(knowledge.noise, of) for name, of in NOISES.items()}
        assumed["step_rad"] = knowledge.sampling.steps
        section = {"assumed": Also(knowledge.sampling, assumed), "advice": [one for one in advice if one]}
        return dict(filled(REPORT["properties"]["next_trial"], section))
    except (CdpIdentError, np.linalg.LinAlgError) as error:
        failed(f"which trial to record next: {error}")
        return None


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
) -> Iterator[Section | None]:
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
                told = {"names": [], "std_now": [], "std_then": [], "deviations_now": nearest.deviations_now}
                yield _advice(question, trials.furthest_apart(nearest, loads), told, -1.0)
        elif question.about == INERTIA.symbol:
            yield _sharper(question, (INVERSE_INERTIA.symbol,), trials, showing, few)
        else:
            yield _sharper(question, _GROUPS if question.about == ALL else (question.about,), trials, loads, grid)


def _sharper(question: Question, names: tuple[str, ...], trials: NextTrial, loads: Loads, grid: Grid) -> Section:
    best, knowledge = trials.sharpest(names, loads, grid), trials.knowledge
    now, values = knowledge.uncertainty(names), knowledge.values[knowledge.places(names)]
    inertia = question.about == INERTIA.symbol
    # Of A22 the unknown is the inverse: a small change of it is A22 squared times as large in A22.
    scale = 1.0 / float(values[0]) ** 2 if inertia else 1.0
    told = {
        "names": [INERTIA.symbol] if inertia else names,
        "std_now": scale * now.std,
        "std_then": scale * trials.uncertainty_after(best.trial, names).std,
        "deviations_now": np.inf,
    }
    if np.isfinite(now.size):
        return _advice(question, best, told, 1.0 / now.size)
    size = abs(float(values[0])) if len(names) == 1 else 0.0
    return _advice(question, best, told, 1.0 / size if size else 0.0, _SHOWN)


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


def advice_title(advice: Section) -> str:
    """Say what a trial is to tell of."""
    if advice["against"]:
        return f"{key_words(advice['for'])}, or {key_words(advice['against'])}"
    return "all base parameters" if advice["for"] == "all" else short_name(advice["for"])


def advice_words(report: Section) -> list[str]:
    """Say which trial to record next, for each purpose, and what it would bring."""
    found = report["next_trial"]
    return [one_advice(advice) for advice in found["advice"]] if found else []


def one_advice(advice: Section) -> str:
    """Say from where to let go for one purpose, with which weight, and what that would bring."""
    several = len(advice["names"]) > 1
    if not advice["against"] and is_determined_now(advice) and advice["expected"] > _HARDLY_LESS:
        least = _percent(1.0 - _HARDLY_LESS)
        return f"{advice_title(advice)}: no trial makes {'them' if several else 'it'} surer by as much as {least}"
    start = f"let go with the inner rod {_held(advice['inner_rad'])} and the outer rod {_held(advice['outer_rad'])}"
    if advice["weights"]:
        start = f"clamp {weights_words(advice)}, and {start}"
    besides = ", and with it every torque in N m" if advice["for"] == INERTIA.symbol else ""
    return f"{advice_title(advice)}{besides}: {start}: {_gained(advice, several)}"


def _gained(advice: Section, several: bool) -> str:
    expected, worst, unloaded = (advice[key] for key in ("expected", "worst", "expected_unloaded"))
    otherwise = "; without a weight {}" if np.isfinite(unloaded) else ""
    missed = f"at worst, where the hand misses by {HAND:.0f}°"
    if advice["against"]:
        now = f"the two are then {expected:.2g} standard deviations apart, now {advice['deviations_now']:.2g}"
        return now + otherwise.format(f"{unloaded:.2g}")
    if is_determined_now(advice):
        share = f"{_percent(expected)} of what {'they are' if several else 'it is'} ({_percent(worst)} {missed})"
        falls = "their intervals fall" if several else "its interval falls"
        return f"{falls} to {share}" + otherwise.format(f"to {_percent(unloaded)}")
    if several:
        return "they are determined then"
    if not np.isfinite(expected):
        return "these trials do not show it, and no such trial does"
    width, widest = (_percent(CONFIDENCE * relative_std) for relative_std in (expected, worst))
    return f"these trials do not show it; it is determined then, to ± {width} ({widest} {missed})"


def _percent(share: float) -> str:
    """Write a share to its two leading digits."""
    return f"{float(f'{100 * share:.2g}'):g} %"


def is_determined_now(advice: Section) -> bool:
    """Return whether the trials that there are show all values that a next one is to tell of."""
    return all(np.isfinite(std) for std in advice["std_now"])


def _held(from_hanging: float) -> str:
    angle = round(float(np.degrees(from_hanging)))
    return "upright" if abs(angle) == 180 else f"at {angle:+d}°" if angle else "hanging"


def advice_map(report: Section) -> Iterator[Figure]:
    """Yield the maps of all that is asked of a next trial."""
    found = report["next_trial"]
    if not found or not found["advice"]:
        return
    yield Figure(
        "next_trial",
        "What a next trial would bring",
        "By the angles from hanging from which both rods are let go, at rest. Blue: to what share of their width "
        "intervals fall, the deeper the further, or of a value that no trial shows yet its interval then; of two "
        "effects, vermilion: by how many standard deviations they would differ. The ring is the start to take; "
        f"its number is that for a hand that misses by up to {HAND:.0f}°.",
        [_panel(advice) for advice in found["advice"]],
    )


def _panel(advice: Section) -> Panel:
    of = advice["map"]
    values = np.array(of["values"])
    inner, outer = np.degrees(of["inner_rad"]), np.degrees(of["outer_rad"])
    title = f"{advice_title(advice)}{', with a weight' if advice['weights'] else ''}"
    column, row = _place(inner, advice["inner_rad"]), _place(outer, advice["outer_rad"])
    if np.isfinite(values[column, row]):
        values[column, row] = advice["expected"]  # what the words say of it: where the hand misses it, too
    if not advice["against"]:
        is_known = is_determined_now(advice)
        values, title = (100.0 if is_known else 100.0 * CONFIDENCE) * values, f"{title} [{'' if is_known else '± '}%]"
    most = max(float(np.max(np.abs(values[np.isfinite(values)]), initial=0.0)), 1e-300)
    half = 100.0 if is_determined_now(advice) else most
    limits = (-most, most) if advice["against"] else (0.0, 2.0 * half)
    x, y = (np.array([float(place)]) for place in (column, len(outer) - 1 - row))
    chosen = Line("the start to take", "ink", x, y, 0.0, shape="circle-open", size=34.0)
    return Panel(
        Axis("inner rod, from hanging [°]", ticks=_ticks(inner)),
        Axis("outer rod, from hanging [°]", ticks=_ticks(outer[::-1])),
        [Heat(values.T[::-1], limits, 1 if advice["against"] else 0), chosen],
        title,
        260,
    )


def _place(angles: Array, chosen: float) -> int:
    """Return the place of an angle [rad] among some [degrees]."""
    return int(np.argmin(np.abs(angles - np.degrees(chosen))))


def _ticks(angles: Array) -> list[tuple[float, str]]:
    # Names of all places, as the ends of the axis follow from them; written at quarter turns.
    return [(float(place), f"{angle:.0f}" if round(angle) % 90 == 0 else "") for place, angle in enumerate(angles)]

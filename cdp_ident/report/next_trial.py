"""What a next trial would tell: as `report.json` holds it, in words, and again from a report's folder."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cdp_ident.configuration.fitted_model import fitted_model, fitted_parameters
from cdp_ident.design.discrimination import Rival, can_be_the_same, rivals
from cdp_ident.design.knowledge import Knowledge, Sampling
from cdp_ident.design.next_trial import Apart, NextTrial, Sharper
from cdp_ident.design.starts import Grid, Survey
from cdp_ident.errors import IdentificationError, ReportError
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.windows import FEWEST_SAMPLES, Window, cut_at
from cdp_ident.model.parameters import GROUPS, INERTIA
from cdp_ident.model.weights import Weight
from cdp_ident.report.curves import NO_WINDOW, Curves
from cdp_ident.report.formatting import number
from cdp_ident.report.outcome import Outcome
from cdp_ident.report.schema import Section
from cdp_ident.trial.trial import Trial

Array = npt.NDArray[np.float64]

ALL = "all"
"""What is asked for where all groups are."""
REPORT_SPACING = 45.0
"""Of the starts that a report surveys [degrees]."""
_MOST_SAMPLES, _MOST_UNEQUAL = 1_000_000, 1e6
_GROUPS = tuple(group.symbol for group in GROUPS)


@dataclass(frozen=True)
class Question:
    """What a next trial is to tell."""

    about: str
    """All groups, an unknown by its name, or an effect of the model by its label."""
    against: str = ""
    """Name and joint of the effect that it is to be told from, as `also_possible` has them."""


def next_trial_section(outcome: Outcome) -> Section | None:
    """Return which trials would tell most; None where the fit failed, or no motion can be computed."""
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
    except (IdentificationError, np.linalg.LinAlgError):
        return None


def usual_questions(model: MotionModel, possible: Mapping[str, Sequence[str]]) -> list[Question]:
    """Return what is asked where nobody asks: what could be another effect, all groups, and each effect's strength.

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


def knowledge_of(report: Section) -> Knowledge | None:
    """Return what a report says is known; None where it says nothing of a next trial, as where the fit failed.

    Raises:
        CdpIdentError: its model, or what it assumes of a trial, cannot be.
    """
    if report["next_trial"] is None:
        return None
    assumed = report["next_trial"]["assumed"]
    _refuse_endless(assumed)
    fitted = fitted_model({p.name: p.value for p in fitted_parameters(report)}, "the report")
    correlation = report["after"]["correlation"]
    names = correlation["names"]
    model, values = fitted.motion, fitted.values
    physical = report["after"]["physical"]
    constants = [symbol for symbol in ("L", "g") if symbol in names]
    trials = {trial["name"]: index for index, trial in enumerate(report["trials"])}
    effects = tuple(
        active if active.trial is None else replace(active, trial=trials.get(fitted.trials[active.trial], len(trials)))
        for active in model.effects
    )
    model = replace(model, effects=effects, length_free="L" in names, gravity_free="g" in names)
    values = np.insert(values, len(GROUPS), [number(physical[symbol]["value"]) for symbol in constants])
    std = _standard_deviations(report, model)
    known = Knowledge(
        model,
        values,
        _covariance(model, std, correlation),
        assumed["noise_rad"],
        np.array(assumed["whitening"], dtype=float),
        Sampling(
            duration=assumed["duration_s"],
            interval=assumed["interval_s"],
            window=assumed["window_s"],
            shortest_window=assumed["shortest_window_s"],
            half_width=assumed["half_width_s"],
            step=assumed["step_s"],
        ),
    )
    return known.with_zeros_of_its_own(any(name.startswith("zero.") for name in names))


def _refuse_endless(assumed: Section) -> None:
    """Raise `ReportError` where no trial as a report assumes it could be simulated: a report may come from anyone."""
    shortest = min(assumed["interval_s"], assumed["step_s"], assumed["shortest_window_s"], assumed["half_width_s"])
    endless = shortest <= 0.0 or not assumed["duration_s"] < _MOST_SAMPLES * shortest
    if endless or assumed["noise_rad"] <= 0.0 or not np.linalg.cond(assumed["whitening"]) < _MOST_UNEQUAL:
        raise ReportError("what the report assumes of a next trial is no trial; was it changed? identify again")


def _standard_deviations(report: Section, model: MotionModel) -> Array:
    """Return the standard deviations (unknowns,) of a model's values."""
    after = report["after"]
    quantities = {**after["groups"], "L": after["physical"]["L"], "g": after["physical"]["g"]}
    std = [number(quantities[name]["std"]) for name in model.base_names]
    inertia = number(after["physical"][INERTIA.symbol]["value"])
    for effect, active in zip(report["effects"], model.effects, strict=True):
        if effect["curve"]:
            std += [number(deviation) / inertia for deviation in effect["curve"]["coefficients_std"]]
        else:
            std += [number(effect["parameters"][p.name]["as_fitted"]["std"]) for p in active.fitted]
    return np.array(std)


def _covariance(model: MotionModel, std: Array, correlation: Section) -> Array:
    """Return the covariance (unknowns, unknowns); coefficients of curves count as uncorrelated."""
    names = correlation["names"]
    shared = [name for name in model.names if name in names]
    matrix = np.array(correlation["matrix"], dtype=float)  # null becomes not a number
    rows, places = [names.index(name) for name in shared], [model.names.index(name) for name in shared]
    together = np.eye(len(std))
    together[np.ix_(places, places)] = np.nan_to_num(matrix[np.ix_(rows, rows)])
    np.fill_diagonal(together, 1.0)
    finite = np.where(np.isfinite(std), std, 0.0)
    result = together * np.outer(finite, finite)
    result[np.diag_indices(len(std))] = std**2
    return np.asarray(result)


def fitted_motion(report: Section, curves: Curves, knowledge: Knowledge) -> list[Window]:
    """Return the fitted windows of a report's trials, their angles being those of its final model.

    What weights are wrong by is left out of it.
    """
    sampling = knowledge.sampling
    windows = []
    for index, curve in enumerate(curves.trials):
        weights = tuple(Weight(**weight) for weight in report["trials"][index]["weights"])
        cart = curve.cart if np.ptp(curve.cart) else None
        trial = Trial(str(index), curve.time, curve.after, cart, weights=weights)
        used = (curve.window != NO_WINDOW) & ~curve.held_out & np.isfinite(curve.after).all(axis=1)
        for place in np.unique(curve.window[used]):
            samples = np.flatnonzero(used & (curve.window == place))
            if len(samples) >= FEWEST_SAMPLES:
                bounds = [int(samples[0]), int(samples[-1]) + 1]
                cut = cut_at(trial, index, bounds, sampling.step, sampling.half_width)
                windows += [replace(window, whitening=knowledge.whitening) for window in cut]
    return windows

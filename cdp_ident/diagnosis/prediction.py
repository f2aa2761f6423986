# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How far ahead a model predicts, from the measured motion up to an instant.

At each start the state is fitted to a short stretch of measured angles before it, the parameters held, and the model is
simulated from there (k-step-ahead prediction with k up to the horizon: Ljung, System Identification, 1999, Section
3.2). The error grows by that of the model and, in chaotic motion exponentially, by that of the state.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.data import Data
from cdp_ident.fit.initial_states import Fit, fit_initial_states
from cdp_ident.fit.windows import FEWEST_SAMPLES, cut_at, without_gaps
from cdp_ident.trial.trial import Trial

Array = npt.NDArray[np.float64]

LIMITS = (1.0, 5.0)
"""Errors for which it is reported how long a model stays below them [degrees]."""
POINTS = 120
"""Number of times at which the error is reported."""
_FITTED = 5.0
"""Time units before a start to which its state is fitted: a second on the paper's rig, a swing of the outer rod."""
_HORIZON = 50.0
"""Time units ahead, at most; and half of the longest stretch of motion."""
_MOST_STARTS = 60


@dataclass(frozen=True)
class Start:
    """Where in a trial a prediction begins, by samples."""

    trial: int
    first: int
    """The first sample to which the state is fitted."""
    at: int
    """The first sample that is predicted."""
    end: int
    """The one after the last."""


@dataclass(frozen=True)
class Plan:
    """Where predictions begin, and how far they go."""

    starts: tuple[Start, ...]
    held_out: bool
    """Whether all of them are in trials that neither fit nor choice has seen."""
    fitted_span: float
    """Length of what a state is fitted to [s]."""
    horizon: float
    """How far ahead is predicted [s]."""


@dataclass(frozen=True)
class Within:
    """How long a model predicts."""

    limit: float
    """Error of either angle, up to which [degrees]."""
    median: float
    """For how long: half of the starts stay within the limit so long, or longer [s]."""
    longer: bool
    """Whether these stay within it up to the horizon, so that the time is a lower bound."""


@dataclass(frozen=True)
class Prediction:
    """How the error of a model's prediction grows; an instant's error is the larger one of the two angles'."""

    time: Array
    """(POINTS,) time since the last sample to which the state was fitted [s]."""
    median: Array
    """(POINTS,) median over the starts [rad]; infinite where they diverge."""
    upper: Array
    """(POINTS,) upper quartile [rad]."""
    within: tuple[Within, ...]
    """For each of LIMITS."""


def plan_of(data: Data) -> Plan:
    """Choose the starts: in the trials that are held out as a whole, or in all trials where there are none."""
    fitted = {window.trial for window in data.fit}
    held_out = sorted({window.trial for window in data.holdout} - fitted)
    trials = held_out or range(len(data.trials))
    unit = data.scales.time_unit
    stretches = [(index, *bounds) for index in trials for bounds in without_gaps(data.trials[index].time)]
    longest = max(float(np.ptp(data.trials[index].time[first:last])) for index, first, last in stretches)
    horizon = min(_HORIZON * unit, longest / 2.0)
    spacing = max(_spacing(data.trials[index]) for index in trials)
    fitted_span = max(_FITTED * unit, 2.0 * FEWEST_SAMPLES * spacing)
    starts = [
        start for index, first, last in stretches for start in _starts(data, index, first, last, fitted_span, horizon)
    ]
    every = max(1, -(-len(starts) // _MOST_STARTS))
    return Plan(tuple(starts[::every]), bool(held_out), fitted_span, horizon)


def _spacing(trial: Trial) -> float:
    return float(np.median(np.diff(trial.time)))


def _starts(data: Data, index: int, first: int, last: int, fitted_span: float, horizon: float) -> Iterator[Start]:
    time = data.trials[index].time[first:last]
    room = float(time[-1] - time[0]) - fitted_span - horizon
    count = int(room / data.scales.time_unit) + 1 if room >= 0.0 else 0
    for at in time[0] + fitted_span + np.linspace(0.0, max(room, 0.0), count):
        begin, now, end = (int(place) for place in np.searchsorted(time, [at - fitted_span, at, at + horizon]))
        if now - begin >= FEWEST_SAMPLES and now < len(time):
            yield Start(index, first + begin, first + now, first + min(end + 1, len(time)))


def predicted(final: Fit, data: Data, plan: Plan) -> Prediction | None:
    """Return how far ahead a model predicts; None where there is no start, or no motion can be computed.

    Args:
        final: gives the model and its values, the zeros of all trials' encoders among them.
        data: the trials.
        plan: where predictions begin.
    """
    step = data.scales.step
    seen = [cut_at(data.trials[s.trial], s.trial, [s.first, s.at], step)[0] for s in plan.starts]
    if not seen:
        return None
    try:
        fitted = fit_initial_states(final.model, final.values, seen)
    except IdentificationError:
        return None
    time = plan.horizon * np.arange(POINTS) / (POINTS - 1)
    grown, lasted = [], []
    for start, window in zip(plan.starts, fitted.windows, strict=True):
        trial = data.trials[start.trial]
        whole = cut_at(trial, start.trial, [start.first, start.end], step)[0]
        theta = fitted.model.predict(fitted.values, window.start, whole)
        ahead = slice(start.at - start.first - 1, None)
        error = np.max(np.abs(whole.theta - theta)[ahead], axis=1)
        error[~np.isfinite(error)] = np.inf
        since = whole.time[ahead] - whole.time[ahead][0]
        grown.append(error[np.minimum(np.searchsorted(since, time), len(error) - 1)])
        lasted.append([_lasted(since, error, np.radians(limit)) for limit in LIMITS])
    return Prediction(
        time=time,
        median=np.quantile(grown, 0.5, axis=0, method="lower"),
        upper=np.quantile(grown, 0.75, axis=0, method="lower"),
        within=tuple(
            _within(limit, times, plan.horizon) for limit, times in zip(LIMITS, np.transpose(lasted), strict=True)
        ),
    )


def _lasted(since: Array, error: Array, limit: float) -> float:
    """Return when an error first exceeds a limit [s]; infinite where it never does."""
    beyond = error[1:] > limit
    return float(since[1:][np.argmax(beyond)]) if np.any(beyond) else float("inf")


def _within(limit: float, times: Sequence[float] | Array, horizon: float) -> Within:
    median = float(np.quantile(times, 0.5, method="lower"))
    return Within(limit, min(median, horizon), median > horizon)

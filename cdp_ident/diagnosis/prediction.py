# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How far ahead a model predicts, from the measured motion up to an instant.

At each start the state is fitted to a short stretch of measured angles before it, the parameters held, and the model is
simulated from there (k-step-ahead prediction with k up to the horizon: Ljung, System Identification, 1999, Section
3.2). The error grows by that of the model and, in chaotic motion exponentially, by that of the state.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.data import Data
from cdp_ident.fit.initial_states import Fit, fit_initial_states
from cdp_ident.fit.windows import FEWEST_SAMPLES, Window, cut_at, without_gaps

LIMITS = (1.0, 5.0)
"""Errors for which it is reported how long a model stays below them [degrees]."""
POINTS = 120
"""Number of times at which the error is reported."""
_FITTED = 5.0
"""Time units before a start to which its state is fitted: a second on the paper's rig, a swing of the outer rod."""
_HORIZON = 50.0
"""Time units ahead, at most; and half of the longest stretch of motion."""
_MOST_STARTS = 60


class Start(NamedTuple):
    """An instant from which the motion is predicted."""

    seen: Window
    """The motion before it, to which the state is fitted."""
    whole: Window
    """The same with the motion that is predicted."""


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
    spacing = max(float(np.median(np.diff(data.trials[index].time))) for index in trials)
    fitted_span = max(_FITTED * unit, 2.0 * FEWEST_SAMPLES * spacing)
    places = [
        (index, first + begin, first + at, first + end)
        for index, first, last in stretches
        for begin, at, end in _places(data.trials[index].time[first:last], unit, fitted_span, horizon)
    ]
    every = max(1, -(-len(places) // _MOST_STARTS))
    starts = tuple(
        Start(*(cut_at(data.trials[index], index, [begin, until], data.scales.step)[0] for until in (at, end)))
        for index, begin, at, end in places[::every]
    )
    return Plan(starts, bool(held_out), fitted_span, horizon)


def _places(time: Array, unit: float, fitted_span: float, horizon: float) -> Iterator[tuple[int, int, int]]:
    """Yield samples of a stretch: the first to which a state is fitted, the first predicted, and the end."""
    room = float(time[-1] - time[0]) - fitted_span - horizon
    count = int(room / unit) + 1 if room >= 0.0 else 0
    for instant in time[0] + fitted_span + np.linspace(0.0, max(room, 0.0), count):
        begin, at, end = np.searchsorted(time, [instant - fitted_span, instant, instant + horizon]).tolist()
        if at - begin >= FEWEST_SAMPLES and at < len(time):
            yield begin, at, min(end + 1, len(time))


def predicted(final: Fit, plan: Plan) -> Prediction | None:
    """Return how far ahead a model predicts; None where there is no start, or no motion can be computed.

    `final` gives the model and its values, the zeros of all trials' encoders among them.
    """
    if not plan.starts:
        return None
    try:
        fitted = fit_initial_states(final.model, final.values, [start.seen for start in plan.starts])
    except IdentificationError:
        return None
    time = plan.horizon * np.arange(POINTS) / (POINTS - 1)
    grown, lasted = [], []
    for (seen, whole), window in zip(plan.starts, fitted.windows, strict=True):
        ahead = slice(len(seen.time) - 1, None)
        theta = fitted.model.predict(fitted.values, window.start, whole)
        error = np.max(np.abs(whole.theta - theta)[ahead], axis=1)
        error[~np.isfinite(error)] = np.inf
        since = whole.time[ahead] - whole.time[ahead][0]
        grown.append(error[np.minimum(np.searchsorted(since, time), len(error) - 1)])
        lasted.append([_lasted(since, error, np.radians(limit)) for limit in LIMITS])
    medians = np.quantile(lasted, 0.5, axis=0, method="lower").tolist()
    return Prediction(
        time=time,
        median=np.quantile(grown, 0.5, axis=0, method="lower"),
        upper=np.quantile(grown, 0.75, axis=0, method="lower"),
        within=tuple(
            Within(limit, min(median, plan.horizon), median > plan.horizon)
            for limit, median in zip(LIMITS, medians, strict=True)
        ),
    )


def _lasted(since: Array, error: Array, limit: float) -> float:
    """Return when an error first exceeds a limit [s]; infinite where it never does."""
    beyond = error[1:] > limit
    return float(since[1:][np.argmax(beyond)]) if np.any(beyond) else float("inf")

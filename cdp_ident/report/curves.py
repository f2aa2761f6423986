# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the pictures of a report show beside its numbers: motion, measured and simulated, and missing torques."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.diagnosis.evaluation import free_run
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.likelihood.swing import Swing
from cdp_ident.likelihood.whole_swing import WholeSwings
from cdp_ident.machine.parallel import parallel_map
from cdp_ident.model.layout import RODS_STATES
from cdp_ident.model.motions import accelerations_at
from cdp_ident.report.outcome import Outcome
from cdp_ident.tracing.final_model import FinalModel
from cdp_ident.tracing.missing_torque import MissingTorque
from cdp_ident.trial.trial import Trial

Array = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]
Indices = npt.NDArray[np.int64]

NO_WINDOW = -1


@dataclass(frozen=True)
class TrialCurves:
    """One trial, measured and simulated; columns of angles are theta1 and theta2 [rad].

    *Before* is the paper's model, fitted; *after* is the model with the effects that were found.
    """

    time: Array
    """(n,) time in the trial [s]."""
    cart: Array
    """(n,) the cart's position x [m]; zero where it was not measured."""
    window: Indices
    """(n,) which window of the trial a sample is of; `NO_WINDOW` where of none."""
    held_out: Flags
    """(n,) whether that window was held out."""
    measured: Array
    """(n, 2)"""
    before: Array
    """(n, 2) simulated over each window from a fitted initial state; nan where there is no window."""
    after: Array
    """(n, 2) the same."""
    run_before: Array
    """(n, 2) one continuous simulation from the fitted initial state, as in Eq. (10); nan where it diverged."""
    run_after: Array
    """(n, 2) the same."""


@dataclass(frozen=True)
class TorqueCurves:
    """The torque that a model lacks (see `MissingTorque`), and those of its effects; columns are the two joints."""

    trial: Indices
    """(m,) which trial a value is of."""
    time: Array
    """(m,) its time in the trial [s]."""
    angle: Array
    """(m, 2) angle of each joint: the inner one from hanging, the outer one relative to the inner rod [rad]."""
    speed: Array
    """(m, 2) speed of each joint [rad/s]."""
    missing: Array
    """(m, 2) torque that the model lacks [N m]; zero in a joint where none is missing."""
    std: Array
    """(m, 2) its standard deviation, that of A22 apart [N m]."""
    effects: Array
    """(effects, m, 2) torque of each of its effects [N m]; zero for effects of encoders."""


@dataclass(frozen=True)
class Curves:
    """All curves of a report."""

    trials: tuple[TrialCurves, ...]
    """In their order."""
    before: TorqueCurves
    """Of the paper's model; empty where no effects were looked for."""
    after: TorqueCurves
    """Of the model with the effects; the same."""


def curves(outcome: Outcome) -> Curves:
    """Return the curves of a finished job."""
    trace = outcome.trace
    trials = range(len(outcome.identification.data.trials))
    before, after = (trace.selection.before, trace.whole or trace.selection.after) if trace.selection else (None, None)
    inertia = trace.completed.inertia.value
    return Curves(
        tuple(parallel_map(lambda index: _trial(outcome, index, trace.before, trace.after), trials)),
        _torques(before, inertia),
        _torques(after, inertia),
    )


def _trial(outcome: Outcome, index: int, before: FinalModel, after: FinalModel) -> TrialCurves:
    trial = outcome.identification.data.trials[index]
    samples = len(trial.time)
    window, held_out = np.full(samples, NO_WINDOW, dtype=np.int64), np.zeros(samples, dtype=bool)
    own = [(w, fit is after.holdout) for fit in (after.fit, after.holdout) for w in fit.windows if w.trial == index]
    for number, (w, is_held_out) in enumerate(sorted(own, key=lambda pair: pair[0].first)):
        window[w.samples], held_out[w.samples] = number, is_held_out
    duration = own[0][0].duration
    return TrialCurves(
        time=trial.time,
        cart=np.zeros(samples) if trial.cart is None else trial.cart,
        window=window,
        held_out=held_out,
        measured=trial.theta,
        before=_simulated(before, index, samples),
        after=_simulated(after, index, samples),
        run_before=_run(before, trial, index, duration),
        run_after=_run(after, trial, index, duration),
    )


def _simulated(final: FinalModel, trial: int, samples: int) -> Array:
    simulated = np.full((samples, 2), np.nan)
    for fit in (final.fit, final.holdout):
        for window, residual in zip(fit.windows, fit.errors, strict=True):
            if window.trial == trial:
                simulated[window.samples] = window.theta - residual
    return simulated


def _run(final: FinalModel, trial: Trial, index: int, duration: float) -> Array:
    # The model over what was held out knows the zeros of trials held out, too.
    model, values = final.holdout.model, final.holdout.values
    angles = free_run(model, values, trial, index, duration)
    return np.where(np.isfinite(angles), angles, np.nan)


def _torques(found: WholeSwings | None, inertia: float) -> TorqueCurves:
    """Return the torques of a model along the swings, given A22."""
    if found is None:
        none = np.zeros((0, 2))
        return TorqueCurves(np.zeros(0, dtype=np.int64), np.zeros(0), none, none, none, none, np.zeros((0, 0, 2)))
    lacking = MissingTorque.of(found)
    effects = np.zeros((len(found.model.effects), *lacking.torque.shape))
    for index, active in enumerate(found.model.effects):
        if active.effect.moves:
            effects[index] = np.concatenate(list(_of_effect(found, index)))
    torques = (inertia * over_inertia for over_inertia in (lacking.torque, lacking.std, effects))
    return TorqueCurves(lacking.trial, lacking.time, lacking.angle, lacking.speed, *torques)


def _of_effect(found: WholeSwings, index: int) -> Iterator[Array]:
    """Yield for each swing the torque (nodes - 1, 2) over A22 that an effect brings the joints (inverse dynamics)."""
    others, remain = found.model.without_effect(index)
    bounds = np.cumsum([RODS_STATES, *(active.effect.states for active in found.model.effects)]).tolist()
    own = range(bounds[index], bounds[index + 1])
    for swing, of in zip(found.recorded.swings, found.states, strict=True):
        states, times = of[1:, : found.model.states], swing.begin + swing.node_times[1:]
        u = np.array([u[0] for u in swing.u[1:]])
        there, without = (
            _accelerations(model, values, swing, np.ascontiguousarray(of_model), u, times)
            for model, values, of_model in (
                (found.model, found.values, states),
                (others, found.values[remain], np.delete(states, own, axis=1)),
            )
        )
        weighted = found.model.with_weights(found.values, swing.weights)
        A23, A33 = found.model.coefficients(weighted.values)[:2]
        more, coupling = there - without, A23 * np.cos(states[:, 0] - states[:, 1])
        on_inner = more[:, 0] + coupling * more[:, 1]
        on_outer = coupling * more[:, 0] + A33 * more[:, 1]
        # The outer joint's torque acts on the outer rod and, reversed, on the inner one.
        yield weighted.share * np.stack([on_inner + on_outer, on_outer], axis=1)


def _accelerations(model: MotionModel, values: Array, swing: Swing, states: Array, u: Array, times: Array) -> Array:
    weighted = model.with_weights(values, swing.weights)
    acting = model.acting(weighted.values, swing.trial, weighted.carried)
    return accelerations_at(model.coefficients(weighted.values), states, u, acting, times)

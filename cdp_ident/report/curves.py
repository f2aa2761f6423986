"""What the pictures of a report show beside its numbers: motion, measured and simulated, and missing torques."""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
import numpy.typing as npt

from cdp_ident.diagnosis.evaluation import free_run
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.refinement import Fit
from cdp_ident.machine.parallel import parallel_map
from cdp_ident.report.outcome import Outcome
from cdp_ident.tracing.final_model import FinalModel
from cdp_ident.tracing.torque_residual import TorqueResidual, corrected, torque_residual
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
    """The torques that the models lack over all windows (see `TorqueResidual`); columns are the two joints."""

    trial: Indices
    """(m,) which trial a sample is of."""
    held_out: Flags
    """(m,) whether it was held out."""
    time: Array
    """(m,) its time in the trial [s]."""
    angle: Array
    """(m, 2) angle of each joint: the inner one from hanging, the outer one relative to the inner rod [rad]."""
    speed: Array
    """(m, 2) speed of each joint [rad/s]."""
    before: Array
    """(m, 2) torque that the paper's model, fitted, lacks [N m]."""
    after: Array
    """(m, 2) torque that the model with the effects lacks [N m]."""
    effects: Array
    """(effects, m, 2) torque of each fitted effect [N m]; zero for effects of encoders."""


@dataclass(frozen=True)
class Curves:
    """All curves of a report: its trials in their order, and its torques."""

    trials: tuple[TrialCurves, ...]
    torques: TorqueCurves


def curves(outcome: Outcome) -> Curves:
    """Return the curves of a finished job."""
    before, after = outcome.trace.before, outcome.trace.after
    trials = range(len(outcome.identification.data.trials))
    return Curves(
        tuple(parallel_map(lambda index: _trial(outcome, index, before, after), trials)),
        _torques(outcome, before, after),
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


def _torques(outcome: Outcome, before: FinalModel, after: FinalModel) -> TorqueCurves:
    model, values = after.model, after.fit.values
    inertia = outcome.trace.completed.inertia.value
    rods = corrected(after.fit), corrected(after.holdout)
    lacking = _lacking(rods, model, values)
    effects = np.zeros((len(model.effects), *lacking.torque.shape))
    for index, active in enumerate(model.effects):
        if active.effect.moves:
            # The torque that is missing without an effect, less that missing with it, is the effect's torque.
            others, remain = model.without_effect(index)
            effects[index] = _lacking(rods, others, values[remain]).torque - lacking.torque
    measured = _weighted_as(before.fit, after.fit), _weighted_as(before.holdout, after.holdout)
    return TorqueCurves(
        trial=lacking.trial,
        held_out=np.arange(len(lacking.time)) >= len(_lacking(rods[:1], model, values).time),
        time=lacking.time,
        angle=lacking.angle,
        speed=lacking.speed,
        before=inertia * _lacking(measured, before.model, before.fit.values).torque,
        after=inertia * lacking.torque,
        effects=inertia * effects,
    )


def _weighted_as(fit: Fit, other: Fit) -> Fit:
    """Return a fit whose samples count as much as in another one, so that torques are of the same samples."""
    pairs = zip(fit.windows, other.windows, strict=True)
    return replace(fit, windows=tuple(replace(one, sample_weights=like.sample_weights) for one, like in pairs))


def _lacking(fits: Sequence[Fit], model: MotionModel, values: Array) -> TorqueResidual:
    """Return the torques over A22 that a model lacks over the windows of all fits, one after the other."""
    parts = [torque_residual(replace(fit, model=model, values=values)) for fit in fits]
    return TorqueResidual(*(np.concatenate([getattr(part, name.name) for part in parts]) for name in fields(parts[0])))

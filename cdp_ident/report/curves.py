# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the pictures of a report show beside its numbers: motion, measured and simulated, and missing torques.

They are computed here, written as `curves.npz`, from which pictures are made anew, and read again.
"""

import io
import zipfile
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from cdp_ident.arrays import Array, Indices, Mask
from cdp_ident.diagnosis.evaluation import free_run
from cdp_ident.errors import ReportError
from cdp_ident.files import read_regular
from cdp_ident.likelihood.whole_swing import WholeSwings
from cdp_ident.machine.parallel import parallel_map
from cdp_ident.model.parameters import LARGEST
from cdp_ident.outside_text import shown
from cdp_ident.report.outcome import Outcome
from cdp_ident.tracing.final_model import FinalModel
from cdp_ident.tracing.missing_torque import JointMotion, MissingTorque, torques_of_effects

NO_WINDOW = -1
FORMAT = "cdp_ident/curves/1"
_LARGEST = 2**29
"""Bytes of all arrays together, and of the file: an hour at 1 kHz; one that unfolds to more is none of ours."""


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
    held_out: Mask
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
class TorqueCurves(JointMotion):
    """The torque that a model lacks (see `MissingTorque`), and those of its effects."""

    missing: Array
    """(n, 2) torque that the model lacks [N m]; zero in a joint where none is missing."""
    std: Array
    """(n, 2) its standard deviation, that of A22 apart [N m]."""
    effects: Array
    """(effects, n, 2) torque of each of its effects [N m]; zero for effects of encoders."""


_EMPTY, _EMPTY_PAIRS, _NO_PLACES = np.zeros(0), np.zeros((0, 2)), np.zeros(0, dtype=np.int64)
_NO_TRIAL = TrialCurves(_EMPTY, _EMPTY, _NO_PLACES, np.zeros(0, dtype=bool), *(_EMPTY_PAIRS,) * 5)
_NO_TORQUES = TorqueCurves(_NO_PLACES, _EMPTY, *(_EMPTY_PAIRS,) * 4, effects=np.zeros((0, 0, 2)))
"""Curves of no sample, which have the types and columns that all must have."""
_Part = TypeVar("_Part", TrialCurves, TorqueCurves)


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
    shown = tuple(parallel_map(lambda index: _trial(outcome, index), trials))
    if trace.selection is None:
        return Curves(shown, _NO_TORQUES, _NO_TORQUES)
    before, after = trace.selection.before, trace.whole or trace.selection.after
    return Curves(shown, *(_torques(found, trace.completed.inertia.value) for found in (before, after)))


def _trial(outcome: Outcome, index: int) -> TrialCurves:
    data, before, after = outcome.identification.data, outcome.trace.before, outcome.trace.after
    trial = data.trials[index]
    samples = len(trial.time)
    window, held_out = np.full(samples, NO_WINDOW, dtype=np.int64), np.zeros(samples, dtype=bool)
    own = [(w, fit is after.holdout) for fit in (after.fit, after.holdout) for w in fit.windows if w.trial == index]
    for number, (w, is_held_out) in enumerate(sorted(own, key=lambda pair: pair[0].first)):
        window[w.samples], held_out[w.samples] = number, is_held_out

    def simulated(final: FinalModel) -> Array:
        angles = np.full((samples, 2), np.nan)
        for fit in (final.fit, final.holdout):
            for of, residual in zip(fit.windows, fit.errors, strict=True):
                if of.trial == index:
                    angles[of.samples] = of.theta - residual
        return angles

    def run(final: FinalModel) -> Array:
        # The model over what was held out knows the zeros of trials held out, too.
        angles = free_run(final.holdout.model, final.holdout.values, trial, index, data.window)
        return np.where(np.isfinite(angles), angles, np.nan)

    cart = np.zeros(samples) if trial.cart is None else trial.cart
    models = (simulated(before), simulated(after), run(before), run(after))
    return TrialCurves(trial.time, cart, window, held_out, trial.theta, *models)


def _torques(found: WholeSwings, inertia: float) -> TorqueCurves:
    """Return the torques of a model along the swings, given A22."""
    lacking = MissingTorque.of(found)
    torques = (inertia * over_inertia for over_inertia in (lacking.torque, lacking.std, torques_of_effects(found)))
    return TorqueCurves(lacking.trial, lacking.time, lacking.angle, lacking.speed, *torques)


def curves_npz(written: Curves) -> bytes:
    """Return the contents of `curves.npz`."""
    parts: dict[str, TrialCurves | TorqueCurves] = {f"trial{i}": trial for i, trial in enumerate(written.trials)}
    parts |= {"torques_before": written.before, "torques_after": written.after}
    arrays = {
        f"{part}.{field.name}": getattr(content, field.name)
        for part, content in parts.items()
        for field in fields(content)
    }
    stream = io.BytesIO()
    np.savez_compressed(stream, format=np.array(FORMAT), **arrays)
    return stream.getvalue()


def read_curves(path: Path, trials: int, effects: int) -> Curves:
    """Read `curves.npz` of a report with so many trials and effects.

    Raises:
        ReportError: the file is not there, is damaged, or does not hold these curves.
    """
    if not path.exists():
        raise ReportError(f"there is no {path}: identify writes it beside report.json; identify again")
    try:
        packed = io.BytesIO(read_regular(path, _LARGEST))
        with zipfile.ZipFile(packed) as archive:
            size = sum(member.file_size for member in archive.infolist())
        with np.load(packed, allow_pickle=False) as content:
            arrays = {name: content[name] for name in content.files if size <= _LARGEST}
    except Exception as error:  # what a damaged archive brings zipfile, zlib and numpy to raise has no end
        raise ReportError(f"{path} cannot be read ({shown(error)}): identify again") from error
    if size > _LARGEST:
        raise ReportError(f"{path} would unfold to {size} bytes: it was not written by identify")
    if str(arrays.get("format")) != FORMAT:
        raise ReportError(f"{path} is not of the format {FORMAT}: identify again with this version")
    return Curves(
        tuple(_part(_NO_TRIAL, path, f"trial{index}", arrays) for index in range(trials)),
        _part(_NO_TORQUES, path, "torques_before", arrays),
        _part(_NO_TORQUES, path, "torques_after", arrays, effects),
    )


def _part(like: _Part, path: Path, part: str, arrays: dict[str, npt.NDArray[Any]], effects: int = 0) -> _Part:
    """Return one part of the curves, whose arrays have the types and columns of those that they must be like.

    What is infinite, or larger than anything measured, is not a number there: it is not drawn.
    """
    found: dict[str, npt.NDArray[Any]] = {}
    samples = int(arrays.get(f"{part}.time", np.empty(0)).size)
    for field in fields(like):
        name = f"{part}.{field.name}"
        empty: npt.NDArray[Any] = getattr(like, field.name)
        shape = (effects, samples, 2) if empty.ndim == 3 else (samples, *empty.shape[1:])
        array = arrays.get(name)
        if array is None or array.shape != shape or array.dtype != empty.dtype or (like is _NO_TRIAL and not samples):
            is_now = "missing" if array is None else f"{array.dtype} of shape {array.shape}"
            raise ReportError(
                f"{path} does not fit its report.json: {name} is {is_now}, not {empty.dtype} of shape {shape}: "
                "identify again"
            )
        found[field.name] = array if array.dtype.kind != "f" else np.where(np.abs(array) <= LARGEST, array, np.nan)
    if np.any(np.isnan(found["time"])):
        raise ReportError(f"{path} does not hold usable curves: {part}.time has no time in it; identify again")
    return type(like)(**found)

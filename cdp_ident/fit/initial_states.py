# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How a model follows windows of the motion: its values are held, each window's initial state is fitted.

It measures how well a model predicts. Each window is a least-squares problem of its own, solved by multiple shooting
(Bock, Numerical treatment of inverse problems in chemical reaction kinetics, 1981): the window is parted into pieces,
which begin where its samples show the rods to be, and Gauss and Newton's steps, which are not damped, join them to one
motion. So no first guess matters, however chaotic the motion is, and a rod at rest is found where it rests.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.windows import NEAR_STEPS, Window
from cdp_ident.machine.parallel import parallel_map
from cdp_ident.model.steps import Times
from cdp_ident.trial.kinematics import MEDIAN_OF_SIZE

OUTLIER = 6.0
"""Residuals beyond so many robust standard deviations lose weight (Huber, Robust Statistics, 1981)."""
_ENOUGH = 1e-4
"""Steps end where one changes residuals by less than this share of their squares: errors are as exact as that."""
_UNSEEN = 1e-6
"""A direction of the initial state that moves the angles by less than this share of itself (root mean square) is left
as the samples show it: a joint that stops at once hides the speed that it begins with. What others move them by does
not matter: where motion is chaotic, that is thousands of times more."""
_MOST_STEPS = 12
"""Steps of a window: three or four do, unless joints that stick make them go to and fro."""
_SHARES = 0.25 ** np.arange(6)
"""Shares of a step that are tried where whole steps do not end."""
_PASSES = 3
"""How often zeros of encoders and initial states are fitted in turn."""


@dataclass(frozen=True)
class Fit:
    """The model's motion over windows, from the initial states that fit them best."""

    model: MotionModel
    values: Array
    """(unknowns,) that are held, in the order of `model.names`."""
    windows: tuple[Window, ...]
    """The windows, with their fitted initial states."""
    errors: tuple[Array, ...]
    """(n, 2) measured minus simulated theta1 and theta2 of each window [rad]."""

    def rmse(self, angle: int | None = None) -> float:
        """Root mean square error of one angle (0: theta1, 1: theta2) or of both together [rad]."""
        columns = slice(None) if angle is None else angle
        return float(np.sqrt(np.mean(np.concatenate(self.errors)[:, columns] ** 2)))


def fit_initial_states(model: MotionModel, values: Array, windows: Sequence[Window]) -> Fit:
    """Fit the windows' initial states, with the zeros of trials that the model does not know, where it has such.

    Args:
        model: gives the motion.
        values: (unknowns,) that are held.
        windows: what to follow.

    Raises:
        IdentificationError: there is no window, or a motion cannot be computed.
    """
    if not windows:
        raise IdentificationError("there is nothing to fit: no window of any trial has enough samples")
    new = sorted({window.trial for window in windows} - set(model.zeros)) if model.zeros else []
    model, values = model.with_zeros(values, new) if new else (model, values)
    found = _followed(model, values, windows)
    for _ in range(_PASSES if new else 0):
        values = _with_zeros(found, new)
        found = _followed(model, values, windows)
    return found


def _followed(model: MotionModel, values: Array, windows: Sequence[Window]) -> Fit:
    best = list(parallel_map(lambda window: _Shooting(model, values, window).best(), windows))
    starts = tuple(replace(window, start=one.start) for window, one in zip(windows, best, strict=True))
    return Fit(model, values, starts, tuple(one.errors for one in best))


class _Motion(NamedTuple):
    """A motion through a window."""

    cost: float
    """What it leaves, squared [rad^2]; infinite where it cannot be computed."""
    start: Array
    """(states,)"""
    errors: Array
    """(n, 2) [rad]"""


@dataclass(frozen=True)
class _Shooting:
    """The search for the initial state of one window."""

    model: MotionModel
    values: Array
    window: Window

    @np.errstate(over="ignore", invalid="ignore")  # steps may lead where no motion can be computed
    def best(self) -> _Motion:
        """Return the motion that is nearest to the samples.

        Where a joint sticks, the motion depends on its initial state by jumps, across which derivatives do not lead:
        whole steps may go to and fro. Then the best of the motions from where they led is improved by shares of a step.

        Raises:
            IdentificationError: no motion can be computed.
        """
        window = self.window
        pieces = window.in_pieces(2 * NEAR_STEPS)
        starts = np.array([self.model.initial_state(start) for start in window.states(pieces.begin - window.begin)])
        begins, is_small = [starts[0]], False
        while not is_small and len(begins) <= _MOST_STEPS:
            change, is_small = self._step(pieces, starts)
            if not np.all(np.isfinite(change)):
                break
            starts = starts + change
            begins.append(starts[0])
        best = self._best_of(begins[-1:] if is_small else begins)
        for _ in range(0 if is_small else _MOST_STEPS):
            change, is_small = self._step(window.in_pieces(), best.start[None])
            before, best = best, self._best_of([best.start, *(best.start + _SHARES[:, None] * change)])
            if is_small or not best.cost < (1.0 - _ENOUGH) * before.cost:
                break
        if not np.isfinite(best.cost):
            raise IdentificationError("the model's motion cannot be computed from the parameters to begin with")
        return best

    def _best_of(self, starts: Sequence[Array]) -> _Motion:
        """Return the best of the motions from several initial states."""
        tried = list[_Motion]()
        for start in starts:
            errors = self.window.theta - self.model.predict(self.values, start, self.window)
            cost = float(np.sum(errors**2))
            tried.append(_Motion(cost if np.isfinite(cost) else np.inf, start, errors))
        return min(tried, key=lambda motion: motion.cost)

    def _step(self, pieces: Times, starts: Array) -> tuple[Array, bool]:
        """Return a step (pieces, states) from the states in which pieces begin, and whether it changes nothing.

        A piece begins where the one before ends. So each of these states is a function of the first one, as far as that
        is linear (condensing). There is no step where there is no motion: the numbers are not finite then.
        """
        found = self.model.motions_in(self.values, starts, self.window, pieces, derive=True)
        if not all(np.all(np.isfinite(of)) for of in (found.readings, found.by, found.ends, found.ends_by)):
            return np.full(starts.shape, np.nan), False
        errors, n = self.window.theta - found.readings, starts.shape[1]
        limit = max(OUTLIER * float(np.median(np.abs(errors))) / MEDIAN_OF_SIZE, np.finfo(float).tiny)
        roots = 1.0 / np.sqrt(np.maximum(np.abs(errors) / limit, 1.0))
        residuals, slopes = roots * errors, roots[..., None] * found.by
        by_first, joined = [np.eye(n)], [np.zeros(n)]
        for by, end, after in zip(found.ends_by, found.ends, starts[1:], strict=False):
            by_first.append(by @ by_first[-1])
            joined.append(by @ joined[-1] + end - after)
        piece = np.repeat(np.arange(len(starts)), np.diff(found.bounds))

        def moved(by: Array) -> Array:
            """Return what changes of the states (pieces, n) do to the residuals."""
            return np.asarray(np.einsum("sij,sj->si", slopes, by[piece]).ravel())

        by_start = (slopes @ np.array(by_first)[piece]).reshape(-1, n)
        target = residuals.ravel() - moved(np.array(joined))
        of_angles, sizes, of_start = np.linalg.svd(by_start, full_matrices=False)
        seen = sizes > _UNSEEN * np.sqrt(len(by_start))
        first = of_start[seen].T @ (of_angles[:, seen].T @ target / sizes[seen])
        change = np.array(by_first) @ first + joined
        left = target - by_start @ first
        return change, float(np.sum(moved(change) ** 2)) <= _ENOUGH * float(left @ left)


def _with_zeros(found: Fit, trials: Sequence[int]) -> Array:
    """Return the values with zeros of some trials' encoders that fit, what initial states can imitate set aside."""
    model, values = found.model, found.values.copy()
    by_zeros = np.tri(2) @ model.by_zeros  # theta2 has both
    for trial in trials:
        rows = list[Array]()
        for window, errors in zip(found.windows, found.errors, strict=True):
            if window.trial == trial:
                by_start = model.motions_in(found.values, window.start[None], window, derive=True).by
                basis, _ = np.linalg.qr(by_start.reshape(-1, model.states))
                others = np.concatenate([np.tile(by_zeros, (len(errors), 1)), errors.reshape(-1, 1)], axis=1)
                rows.append(others - basis @ (basis.T @ others))
        those = np.concatenate(rows)
        values[model.zero_places(trial)] += np.linalg.lstsq(those[:, :-1], those[:, -1])[0]
    return values

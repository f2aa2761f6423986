"""When something happened once: the instant at which a knock or a lost count explains a window's residual best."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.identification.motion_model import STATE, ActiveEffect, MotionModel
from cdp_ident.identification.refinement import Fit
from cdp_ident.identification.windows import Window
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.effects.effect import Effect, TorqueEffect
from cdp_ident.model.trajectory import trajectory_with_derivatives
from cdp_ident.tracing.candidates import Candidate

Array = npt.NDArray[np.float64]

_MARGIN = 10
"""Samples at either end of a window between which an instant is looked for: nearer, the start can imitate it."""
_AWAY, _SHARP = 50, 25.0
"""Where an instant so many samples away explains the residual as well, but for so many variances, none is the one."""
_READINGS = {"inner": np.array([1.0, 1.0]), "outer": np.array([0.0, 1.0])}
"""How an error of an encoder enters theta1 and theta2."""


def instants(fit: Fit) -> list[Candidate]:
    """Return for each effect that happens once its most likely instant, the one that gains most first."""
    assert isinstance(fit.model, MotionModel)
    found = []
    for effect in CATALOGUE:
        if effect.at_an_instant:
            scan = _scan_knocks if isinstance(effect, TorqueEffect) else _scan_slips
            best = max(scan(fit, effect), key=lambda instant: instant.gain, default=None)
            if best is not None and best.gain > 0:
                active = ActiveEffect(effect, trial=best.trial)
                found.append(_AtInstant(active, best.gain, np.array([best.strength]), best.time))
    return sorted(found, key=lambda candidate: -candidate.gain)


@dataclass(frozen=True)
class _AtInstant(Candidate):
    time: float

    @property
    def values(self) -> Array:
        return np.array([self.strengths[0], self.time])


@dataclass(frozen=True)
class _Instant:
    gain: float
    strength: float
    trial: int
    time: float


def _motion(fit: Fit, window: Window) -> tuple[Array, Array]:
    """Return the states (n, 4) in a window and their derivatives (n, 4, 4) with respect to its start."""
    assert isinstance(fit.model, MotionModel)
    states, derivatives = trajectory_with_derivatives(
        fit.model.coefficients(fit.values), window.start, window.grid, window.u,
        fit.model.torques(fit.values, window.trial), window.begin,
    )  # fmt: skip
    return states, derivatives[..., :STATE]


def _from_each_on(terms: Array) -> Array:
    """Return the sums of terms (n, …) from each sample on."""
    return np.flip(np.cumsum(np.flip(terms, axis=0), axis=0), axis=0)


def _scan_knocks(fit: Fit, effect: Effect) -> list[_Instant]:
    found = []
    column = 0 if effect.joint == "inner" else 1
    for window, residual in zip(fit.windows, fit.residuals, strict=True):
        if len(residual) <= 2 * _MARGIN:
            continue
        states, transition = _motion(fit, window)
        angles = transition[:, :2]
        # A change of speed at sample j moves the angles as a start changed by `change[j]` would, from j on.
        change = (np.linalg.pinv(transition) @ _speed_change(fit, states, column)[..., None])[..., 0]
        grams = _from_each_on(np.einsum("nrk,nrl->nkl", angles, angles))
        sums = _from_each_on(np.einsum("nrk,nr->nk", angles, residual))
        from_start = np.einsum("nkl,nl->nk", grams, change)
        imitation = from_start @ np.linalg.pinv(grams[0], hermitian=True)
        size = np.einsum("nk,nk->n", change, from_start) - np.einsum("nk,nk->n", from_start, imitation)
        fitting = np.einsum("nk,nk->n", change, sums) - imitation @ sums[0]
        found.append(_best(fit, window, size, fitting))
    return found


def _speed_change(fit: Fit, states: Array, column: int) -> Array:
    """Return the change (n, 4) of the state by a unit of angular impulse on one rod, over A22."""
    A23, A33 = fit.values[:2]
    coupling = A23 * np.cos(states[:, 0] - states[:, 1])
    determinant = A33 - coupling**2
    change = np.zeros_like(states)
    change[:, 2] = (A33 if column == 0 else -coupling) / determinant
    change[:, 3] = (-coupling if column == 0 else 1.0) / determinant
    return change


def _scan_slips(fit: Fit, effect: Effect) -> list[_Instant]:
    reading = _READINGS[effect.joint]
    found = []
    for trial in sorted({window.trial for window in fit.windows}):
        later_size, later_fitting = 0.0, 0.0
        members = [i for i, window in enumerate(fit.windows) if window.trial == trial]
        for index in reversed(members):
            window, residual = fit.windows[index], fit.residuals[index]
            _, transition = _motion(fit, window)
            angles = transition[:, :2]
            gram = np.einsum("nrk,nrl->kl", angles, angles)
            from_start = _from_each_on(np.einsum("nrk,r->nk", angles, reading))
            imitation = from_start @ np.linalg.pinv(gram, hermitian=True)
            counts = np.arange(len(residual), 0, -1)
            size = counts * (reading @ reading) - np.einsum("nk,nk->n", from_start, imitation)
            start_sum = np.einsum("nrk,nr->k", angles, residual)
            fitting = _from_each_on(residual @ reading) - imitation @ start_sum
            if len(residual) > 2 * _MARGIN:
                found.append(_best(fit, window, size + later_size, fitting + later_fitting))
            later_size, later_fitting = later_size + size[0], later_fitting + fitting[0]
    return found


def _best(fit: Fit, window: Window, size: Array, fitting: Array) -> _Instant:
    squared_error, samples = fit.squared_error, sum(residual.size for residual in fit.residuals)
    inner = slice(_MARGIN, -_MARGIN)
    gains = np.where(size[inner] > 1e-9 * size[inner].max(), fitting[inner] ** 2 / np.maximum(size[inner], 1e-300), 0.0)
    place = int(np.argmax(gains)) + _MARGIN
    elsewhere = gains[np.abs(np.arange(len(gains)) + _MARGIN - place) > _AWAY]
    variance = max(squared_error - gains.max(), 0.05 * squared_error) / samples
    if len(elsewhere) and elsewhere.max() > gains.max() - _SHARP * variance:
        gains = np.zeros_like(gains)  # a residual that no instant in particular explains
    return _Instant(
        float(gains[place - _MARGIN]),
        float(fitting[place] / size[place]),
        window.trial,
        window.begin + float(window.time[place]),
    )

"""Effects of an instant: when an impulse or lost counts explain a window's residual best."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.initial_states import InitialState
from cdp_ident.fit.refinement import Fit
from cdp_ident.fit.windows import Window
from cdp_ident.machine.parallel import parallel_map
from cdp_ident.model.effects.catalogue import known_effects
from cdp_ident.model.effects.effect import Effect
from cdp_ident.model.motions import InitialValueProblem, motions
from cdp_ident.tracing import thresholds
from cdp_ident.tracing.candidates import Candidate

Array = npt.NDArray[np.float64]

_MARGIN = 10
"""Samples at either end of a window that are left out: there the initial state could imitate the effect."""
_SINGULAR = 1e-13
"""Singular value, as a share of the largest, below which a change of the state counts as unobservable."""
_READINGS = {"inner": np.array([1.0, 1.0]), "outer": np.array([0.0, 1.0])}
"""How an error of an encoder enters theta1 and theta2."""


def instants(fit: Fit) -> list[Candidate]:
    """Return each effect of an instant at its most likely instant, the largest gain first."""
    found, of_windows = [], list(parallel_map(lambda window: _Motion.of(fit, window), fit.windows))
    for effect in known_effects():
        if effect.at_an_instant:
            scan = _scan_impulses if effect.moves else _scan_slips
            best = max(scan(fit, effect, of_windows), key=lambda instant: instant.gain, default=None)
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


@dataclass(frozen=True)
class _Motion:
    """The states in a window, and their derivatives by its initial state in orthonormal coordinates.

    In chaotic motion the derivatives by the initial state itself are almost parallel.
    """

    states: Array
    """(n, 4)"""
    transition: Array
    """(n, 4, 4) their derivatives with respect to the coordinates."""
    coordinates: Array
    """(n, 4, 4) those of the coordinates with respect to the state at each sample; none of a window that is too short
    for an impulse."""
    basis: Array
    """(n, 2, 4) those of the whitened angles, whose columns are an orthonormal basis."""

    @classmethod
    def of(cls, fit: Fit, window: Window) -> "_Motion":
        values = fit.model.with_weights(fit.values, window.weights).values
        acting = fit.model.acting(values, window.trial).without_directions()
        start = fit.model.initial_state(window.start)
        coefficients = fit.model.coefficients(values)
        problem = InitialValueProblem(coefficients, start, window.grid, window.u, acting, window.begin)
        motion = motions([problem], derive=True, shown=False)
        states, by_start = motion.states, motion.by
        count = fit.model.states
        state = InitialState.of(window.whitened(by_start[:, :2]).reshape(-1, count))
        transition = by_start @ state.transform
        long = transition if len(states) > 2 * _MARGIN else transition[:0]
        coordinates = np.asarray(np.linalg.pinv(long, rcond=_SINGULAR), dtype=np.float64)
        return cls(states, transition, coordinates, state.basis.reshape(-1, 2, count))


def _before_each(terms: Array) -> Array:
    """Return the sums of terms (n, …) before each sample."""
    return np.cumsum(terms, axis=0) - terms


def _from_each_on(terms: Array) -> Array:
    """Return the sums of terms (n, …) from each sample on."""
    return np.flip(np.cumsum(np.flip(terms, axis=0), axis=0), axis=0)


def _scan_impulses(fit: Fit, effect: Effect, of_windows: Sequence[_Motion]) -> list[_Instant]:
    found = []
    column = 0 if effect.joint == "inner" else 1
    for window, residual, motion in zip(fit.windows, fit.residuals, of_windows, strict=True):
        if len(residual) <= 2 * _MARGIN:
            continue
        # A change of speed at sample j moves the angles as changed coordinates `change[j]` would, from j on. The part
        # that the initial state cannot imitate is written in sums before and after j, without subtractions.
        speed_change, basis = _speed_change(fit, window, motion.states, column), motion.basis
        change = (motion.coordinates @ speed_change[..., None])[..., 0]
        gram = np.einsum("nrk,nrl->nkl", basis, basis)
        product = np.einsum("nrk,nr->nk", basis, residual)
        before, after = (np.einsum("nkl,nl->nk", sums(gram), change) for sums in (_before_each, _from_each_on))
        size = np.einsum("nk,nk->n", before, after)
        fitting = np.einsum("nk,nk->n", before, _from_each_on(product))
        fitting -= np.einsum("nk,nk->n", after, _before_each(product))
        found.append(_best(fit, window, size, fitting))
    return found


def _speed_change(fit: Fit, window: Window, states: Array, column: int) -> Array:
    """Return the change (n, 4) of the state by a unit of angular impulse on one rod, over A22."""
    weighted = fit.model.with_weights(fit.values, window.weights)
    A23, A33 = weighted.values[:2]
    coupling = A23 * np.cos(states[:, 0] - states[:, 1])
    determinant = A33 - coupling**2
    change = np.zeros_like(states)
    change[:, 2] = (A33 if column == 0 else -coupling) / determinant
    change[:, 3] = (-coupling if column == 0 else 1.0) / determinant
    return change / weighted.share


def _scan_slips(fit: Fit, effect: Effect, of_windows: Sequence[_Motion]) -> list[_Instant]:
    found = []
    for trial in sorted({window.trial for window in fit.windows}):
        later_size, later_fitting = 0.0, 0.0
        members = [i for i, window in enumerate(fit.windows) if window.trial == trial]
        for index in reversed(members):
            window, residual = fit.windows[index], fit.residuals[index]
            basis = of_windows[index].basis
            reading = window.whitened(np.tile(_READINGS[effect.joint], (len(residual), 1)))
            imitation = _from_each_on(np.einsum("nrk,nr->nk", basis, reading))
            size = _from_each_on(np.sum(reading**2, axis=1)) - np.einsum("nk,nk->n", imitation, imitation)
            fitting = _from_each_on(np.sum(residual * reading, axis=1))
            fitting -= imitation @ np.einsum("nrk,nr->k", basis, residual)
            if len(residual) > 2 * _MARGIN:
                found.append(_best(fit, window, size + later_size, fitting + later_fitting))
            later_size, later_fitting = later_size + size[0], later_fitting + fitting[0]
    return found


def _best(fit: Fit, window: Window, size: Array, fitting: Array) -> _Instant:
    squared_error = fit.squared_error
    inner = slice(_MARGIN, -_MARGIN)
    gains = np.where(size[inner] > 1e-9 * size[inner].max(), fitting[inner] ** 2 / np.maximum(size[inner], 1e-300), 0.0)
    place = int(np.argmax(gains)) + _MARGIN
    elsewhere = gains[np.abs(np.arange(len(gains)) + _MARGIN - place) > thresholds.AWAY]
    variance = max(squared_error - gains.max(), 0.05 * squared_error) / fit.samples
    if len(elsewhere) and elsewhere.max() > gains.max() - thresholds.least_gain(1.0) * variance:
        gains = np.zeros_like(gains)  # no particular instant explains the residual
    return _Instant(
        float(gains[place - _MARGIN]),
        float(fitting[place] / size[place]),
        window.trial,
        window.begin + float(window.time[place]),
    )

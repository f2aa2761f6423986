"""The effects that could be added to a model, and a score test of what each would gain.

The test costs one simulation for all candidates together: each is present with zero strength, and the residual is
projected on its sensitivities, after the part that the model's own unknowns can explain has been removed from both
(Rao's score test).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations, pairwise

import numpy as np
import numpy.typing as npt

from cdp_ident.diagnosis.uncertainty import scaled_inverse
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.autocorrelation import long_run_products
from cdp_ident.fit.bounded import minimum_within_limits
from cdp_ident.fit.initial_states import InitialState
from cdp_ident.fit.kept_columns import TOGETHER
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.refinement import Fit
from cdp_ident.machine.parallel import parallel_for
from cdp_ident.model.effects.catalogue import known_effects
from cdp_ident.model.effects.effect import exclude_each_other
from cdp_ident.tracing import thresholds

Array = npt.NDArray[np.float64]

_INDEPENDENT = 1e-6
"""A candidate counts as new if the model's own sensitivities leave at least this share of its own."""

_ALIKE = 1e-8
"""Directions of candidates with less than this share of the largest curvature are left out."""

_LARGEST = 1e100
"""Sensitivities beyond this have overflowed."""


_FREQUENCIES = (0.25, 0.5, 1.0, 2.0, 4.0)
"""An effect with states of its own is tested with its first shape parameter at so many times the typical value."""


@dataclass(frozen=True)
class Candidate:
    """An effect that could be added, and what the score test says of it."""

    active: ActiveEffect
    gain: float
    """By how much it would lower the squared error of the fit [rad^2]."""
    strengths: Array
    """(k,) the corresponding values of its parameters, shape parameters excepted."""
    shape: float = field(default=1.0, kw_only=True)
    """Value of its first shape parameter, over the typical one, at which that was found."""
    variance_ratio: float = field(default=1.0, kw_only=True)
    """Variance of the residuals' projection on it, over that of white residuals of the same size.

    At least the integrated autocorrelation time, which is that of a mean.
    """
    elsewhere: tuple["Candidate", ...] = field(default=(), kw_only=True)
    """The same effect at other values of its first shape parameter, which gain nearly as much, the best first."""

    @property
    def freedom(self) -> int:
        """How many parameters it adds."""
        return len(self.active.fitted)

    @property
    def values(self) -> Array:
        """Initial values of its fitted parameters for a refinement."""
        shapes, strengths = iter(shapes_of(self.active, self.shape)), iter(self.strengths)
        return np.array([next(shapes if p.shape else strengths) for p in self.active.fitted])


def shapes_of(active: ActiveEffect, first: float = 1.0) -> list[float]:
    """Return typical values of an effect's shape parameters, the first one times a factor."""
    shapes = [p.typical for p in active.fitted if p.shape]
    return [first * shapes[0], *shapes[1:]] if shapes else []


def addable(model: MotionModel, with_states: bool = True) -> list[ActiveEffect]:
    """Return the effects that a score test can show and that may be beside those of a model.

    Args:
        model: what they could be added to.
        with_states: whether those that bring states of their own are among them; their test takes as long as that of
            all others.
    """
    present = [active.effect for active in model.effects]
    return [
        ActiveEffect(effect)
        for effect in known_effects()
        if effect.has_score
        and (with_states or not effect.brings_states)
        and not any(exclude_each_other(effect, other) for other in present)
    ]


@dataclass(frozen=True)
class Pair:
    """Two effects that could be added together, and what the score test says of them."""

    members: tuple[Candidate, Candidate]
    gain: float
    """By how much both together would lower the squared error of the fit [rad^2]."""
    variance_ratio: float
    """As that of a candidate."""

    @property
    def freedom(self) -> int:
        """How many parameters both add."""
        return sum(member.freedom for member in self.members)


class ScoreTest:
    """The gain of each candidate, and of every two of them."""

    def __init__(self, fit: Fit, candidates: Sequence[ActiveEffect]):
        self.candidates = tuple(candidates)
        oscillating = [c for c in candidates if c.effect.brings_states]
        self._together = _Projection(fit, [c for c in candidates if c not in oscillating])
        self._alone = [[_Projection(fit, [c], factor) for factor in _FREQUENCIES] for c in oscillating]

    def reduced(self, index: int) -> tuple[Array, Array]:
        """Return the matrix (k, k) and right-hand side (k,) for the strengths of a candidate [rad^2].

        Not of one with states of its own.
        """
        return self._together.reduced(self._together.candidates.index(self.candidates[index]))

    def imitation(self, candidate: Candidate) -> tuple[Array, Array]:
        """Return how the model's own values imitate a candidate, and how well its strengths are seen beside them.

        These are the values' changes by its strengths (unknowns, k), and the inverse (k, k) of the curvature of the
        squared error by these [rad^-2]. Not of one with states of its own.
        """
        return self._together.imitation(self._together.candidates.index(candidate.active))

    def ranked(self) -> list[Candidate]:
        """Return the candidates that would gain something, the best first."""
        found = self._together.ranked()
        for by_factor in self._alone:
            if ranking := sorted((c for part in by_factor for c in part.ranked()), key=lambda c: -c.gain):
                best, *others = ranking
                near = (c for c in others if c.gain > thresholds.NEAR_A_RIVAL * best.gain)
                found.append(replace(best, elsewhere=tuple(near)))
        return sorted(found, key=lambda c: -c.gain)

    def pairs(self, most: int) -> list[Pair]:
        """Return pairs of candidates, the best first.

        Only pairs that gain clearly more than the sum of their members alone are returned. Effects with states of their
        own are in none.
        """
        return self._together.pairs(most)


class _Projection:
    """The residual and the candidates' sensitivities, orthogonal to the model's own sensitivities.

    The gain of a candidate with states of its own includes what their initial values in each window explain, beyond
    what they would explain of noise.
    """

    def __init__(self, fit: Fit, candidates: Sequence[ActiveEffect], shape: float = 1.0):
        model, values = fit.model, fit.values
        self.candidates = tuple(candidates)
        self._shape = shape
        self._columns: list[npt.NDArray[np.int64]] = []
        for candidate in candidates:
            shapes = iter(shapes_of(candidate, shape))
            first = len(values)
            model = model.with_effect(candidate)
            values = np.concatenate([values, [next(shapes) if p.shape else 0.0 for p in candidate.fitted]])
            self._columns.append(first + np.array([k for k, p in enumerate(candidate.fitted) if not p.shape]))
        own, size, states = len(fit.values), len(values), model.states
        windows = len(fit.windows)
        together = min(windows, TOGETHER)
        squares, products = np.empty((2, together, size, size))
        targets, sizes, lefts = np.empty((windows, size)), np.empty((windows, size)), np.empty(windows)
        whole, of_scores, lags = np.zeros((size, size)), np.zeros((size, size)), fit.autocorrelation.length

        def work(first: int, last: int) -> None:
            for block in blocks[first:last]:
                add_block(range(begin, begin + count)[block])

        def add_block(places: range) -> None:
            windows = fit.windows[places.start : places.stop]
            starts = [window.start for window in windows]
            _, by_unknowns, bounds = model.predict_together(values, starts, windows)
            of_windows = []
            for index, window, end in zip(places, windows, pairwise(bounds.tolist()), strict=True):
                sensitivity = window.whitened(by_unknowns[slice(*end)]).reshape(-1, states + size)
                # A candidate whose sensitivity cannot be computed has zero gain.
                rows = np.where(np.abs(sensitivity) < _LARGEST, sensitivity, 0.0)
                rows *= np.sqrt(fit.weights[index]).reshape(-1, 1)
                of_windows.append(rows)
            known = [window.start_known for window in windows]
            by_state = [rows[:, :states] for rows in of_windows]
            of_states = InitialState.of_each(zip(by_state, known, strict=True))
            for index, rows, state in zip(places, of_windows, of_states, strict=True):
                free, left = rows[:, states:], (fit.residuals[index] * np.sqrt(fit.weights[index])).ravel()
                sizes[index] = np.einsum("nk,nk->k", free, free)
                free, left = state.eliminated_from(free), state.eliminated_from(left)
                squares[index - begin], targets[index], lefts[index] = free.T @ free, free.T @ left, left @ left
                scores = (free * left[:, None]).reshape(-1, 2, size).sum(axis=1)
                products[index - begin] = long_run_products(scores, lags)

        for begin in range(0, windows, together):
            count = min(together, windows - begin)
            blocks = model.blocks(fit.windows[begin : begin + count])
            parallel_for(work, len(blocks))
            whole += squares[:count].sum(axis=0)
            of_scores += products[:count].sum(axis=0)
        target, size_before = targets.sum(axis=0), sizes.sum(axis=0)
        whole[:own, :own] += fit.model.penalty
        target[:own] -= fit.model.penalty @ fit.values
        kept = np.linalg.pinv(whole[:own, :own], rcond=1e-12, hermitian=True)
        remaining = lefts.sum() + fit.values @ fit.model.penalty @ fit.values - target[:own] @ kept @ target[:own]
        added_states = (states - fit.model.states) * windows
        self._added_states = added_states
        self._gain_of_states = float(fit.squared_error - remaining) if added_states else 0.0
        self._of_mean = fit.autocorrelation.integrated_time
        self._imitated = imitated = whole[:, :own] @ kept
        self._gram = whole - imitated @ whole[:own, :]
        self._right = target - imitated @ target[:own]
        remove = np.eye(size)
        remove[:, :own] -= imitated
        self._products = remove @ of_scores @ remove.T
        self._variance = fit.variance
        self._independent = np.diag(self._gram) > _INDEPENDENT * np.maximum(size_before, np.finfo(float).tiny)

    def reduced(self, index: int) -> tuple[Array, Array]:
        """Return the matrix (k, k) and right-hand side (k,) for the strengths of a candidate [rad^2]."""
        columns = self._columns[index]
        return self._gram[np.ix_(columns, columns)], self._right[columns]

    def imitation(self, index: int) -> tuple[Array, Array]:
        """Return what `ScoreTest.imitation` does."""
        columns = self._columns[index]
        return self._imitated[columns].T, scaled_inverse(self._gram[np.ix_(columns, columns)], _ALIKE)[0]

    def ranked(self) -> list[Candidate]:
        """Return the candidates that would gain something, the best first."""
        found = [self._candidate(index) for index in range(len(self.candidates))]
        return sorted((c for c in found if c is not None and c.gain > 0), key=lambda c: -c.gain)

    def pairs(self, most: int) -> list[Pair]:
        """Return what `ScoreTest.pairs` does."""
        single = {index: self._candidate(index) for index in range(len(self.candidates))}
        alone = {index: c.gain if c else 0.0 for index, c in single.items()}
        usable = [index for index in single if np.all(self._independent[self._columns[index]])]
        found = []
        by_size: dict[int, list[tuple[int, int]]] = {}
        for first, second in combinations(usable, 2):
            by_size.setdefault(len(self._columns[first]) + len(self._columns[second]), []).append((first, second))
        for members in by_size.values():
            columns = np.array([np.concatenate([self._columns[one], self._columns[two]]) for one, two in members])
            inverse = np.linalg.pinv(self._gram[columns[:, :, None], columns[:, None, :]], _ALIKE, hermitian=True)
            joint = np.einsum("pk,pkl,pl->p", self._right[columns], inverse, self._right[columns])
            for gain, (first, second) in zip(joint.tolist(), members, strict=True):
                if gain > thresholds.PAIR_GAINS * (alone[first] + alone[second]):
                    found.append((gain, first, second))
        found.sort(reverse=True)
        pairs = []
        for _, first, second in found[: 4 * most]:
            gain, strengths = self._solve([first, second])
            split = len(self._columns[first])
            one = Candidate(self.candidates[first], alone[first], strengths[:split])
            two = Candidate(self.candidates[second], alone[second], strengths[split:])
            if gain > thresholds.PAIR_GAINS * (alone[first] + alone[second]):
                pairs.append(Pair((one, two), gain, self._variance_ratio([first, second])))
        return sorted(pairs, key=lambda pair: -pair.gain)[:most]

    def _candidate(self, index: int) -> Candidate | None:
        if not np.all(self._independent[self._columns[index]]):
            return None
        gain, strengths = self._solve([index])
        ratio = self._variance_ratio([index])
        if gain > 0.0:
            gain += max(self._gain_of_states - self._added_states * self._variance * ratio, 0.0)
        return Candidate(self.candidates[index], gain, strengths, shape=self._shape, variance_ratio=ratio)

    def _variance_ratio(self, indices: Sequence[int]) -> float:
        columns = np.concatenate([self._columns[index] for index in indices])
        own = np.ix_(columns, columns)
        inverse, left_out = scaled_inverse(self._gram[own], _ALIKE)
        directions = max(len(columns) - left_out.shape[1], 1)
        return max(float(np.sum(inverse * self._products[own])) / (self._variance * directions), self._of_mean)

    def _solve(self, indices: Sequence[int]) -> tuple[float, Array]:
        """Return the gain of candidates together [rad^2], with strengths within their limits, and these strengths."""
        columns = np.concatenate([self._columns[index] for index in indices])
        strong = [p for index in indices for p in self.candidates[index].fitted if not p.shape]
        matrix, right = self._gram[np.ix_(columns, columns)], self._right[columns]
        lower, upper = np.array([p.lower for p in strong]), np.array([p.upper for p in strong])
        strengths = minimum_within_limits(matrix, right, lower, upper)
        return float(2 * strengths @ right - strengths @ matrix @ strengths), strengths

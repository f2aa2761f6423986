"""The most likely values of a model's unknowns, given whole swings, and how likely they make what was measured.

States are estimated at nodes along each swing, and each node's follows from the one before: by the model, and by
impulses of *unknown torques* in both joints. Their standard deviations are estimated, joint by joint, as those of the
encoders' noise are. Where the model holds they vanish, and a swing is one motion, chaotic as it may be. Where it does
not, they say what it lacks, and the values are as uncertain as that makes them.

Steps of Gauss and Newton on states and unknowns together end at the maximum of the joint density (Bell, SIAM J. Optim.
4, 1994). By Laplace the likelihood of the standard deviations follows (Kristensen, Madsen and Jorgensen, Automatica 40,
2004). At its maximum the squares of what is taken for noise or torques are what these let expect, less the degrees of
freedom that the estimates took (MacKay, Neural Comput. 4, 1992).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.bounded import minimum_within_limits
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.likelihood.noise import Noise
from cdp_ident.likelihood.sweeps import Whitened, backwards, forwards
from cdp_ident.likelihood.swing import Linearised, Swing

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

_MOST_STEPS = 60
_ROUGHLY, _CLOSE = 1.0, 0.03
"""Standard deviations are estimated once no step changes a value by more than the first share of its own, and steps end
where none changes by more than the second."""
_SPACING, _NEAR = 0.5, 0.2
"""Between nodes, in time units: where nothing is missing, and where torques are, whose impulses are at the nodes."""
_LEAST_TORQUE = 1e-5
"""Unknown torques are at least so large that within a time unit their impulses change an angle by this share of the
encoders' noise: far less than matters, and enough to forget what rounding makes of a chaotic motion."""
_MISSING = 4.0
"""Torques are missing where the least impulses' squares are so many times what is expected of them."""
_LONGEST = 3.0
"""Largest change of a torque's logarithm in a step."""
_PATIENCE, _TO_AND_FRO = 4, 0.3
"""Where friction begins to hold a joint or lets go, steps may go to and fro: they are halved where so many have not
made the change smaller, and end where that is below this share of a standard deviation."""
_BEYOND = 10.0
"""Torques grow at once where their impulses' squares are so many times what is expected."""
_FREE = 0.05
"""A torque whose impulses have fewer degrees of freedom changes nothing: its size need not be known better."""
_SHOWN = 10.0
"""A torque is missing where the misfit would be larger by this without it: odds of 150 against chance."""
_TELLING = 0.05
"""Residuals tell of the noise's memory where estimates took less than this share of their degrees of freedom."""
_NOTHING = 1e-100
"""Length of what is nothing."""
_UNOBSERVABLE = 1e-7
"""Directions of scaled unknowns with less than this share of the largest precision are not determined."""


@dataclass(frozen=True)
class Recorded:
    """What a rig's encoders showed, and what scales with the rig."""

    swings: tuple[Swing, ...]
    encoders: Array
    """(2,) standard deviation of both encoders' noise, roughly [rad]."""
    time_unit: float
    """Of the rig, sqrt(L / g) [s]."""

    @property
    def large_torque(self) -> float:
        """One that hides all that a model says over a time unit, over A22 [1/s^1.5]."""
        return float(self.encoders.max()) / self.time_unit**1.5

    @property
    def least_torque(self) -> float:
        """The least that is taken into account, over A22 [1/s^1.5]."""
        return _LEAST_TORQUE * self.large_torque


@dataclass(frozen=True)
class WholeSwings:
    """A model's most likely values given whole swings, and what belongs to them."""

    model: MotionModel
    values: Array
    """(unknowns,)"""
    covariance: Array
    """(unknowns, unknowns) of these; infinite where the swings do not determine one."""
    recorded: Recorded
    noise: Noise
    """Of encoders and unknown torques, none of which is zero."""
    is_missing: npt.NDArray[np.bool_]
    """(2,) whether a torque is missing in each joint: without it the swings are far less likely."""
    impulses: tuple[Array, ...]
    """(nodes, 2, 2) of each swing: the impulses of unknown torques in both joints after each node, over A22 [1/s], and
    their standard deviations."""
    states: tuple[Array, ...]
    """(nodes, states) of each swing, and where its clock is uncertain by how much that is fast."""
    misfit: float
    """Minus twice the logarithm of the likelihood, but for a constant."""
    steps: int

    @property
    def torque(self) -> Array:
        """(2,) standard deviation of the torques that are missing, over A22 [1/s^1.5]; zero where none is."""
        return np.asarray(np.where(self.is_missing, self.noise.torque, 0.0))


def most_likely(
    model: MotionModel,
    values: Array,
    recorded_with: Callable[[float], tuple[Recorded, Sequence[Array]]],
) -> WholeSwings:
    """Find the most likely values, states and standard deviations.

    It begins with no unknown torque but the least. Where torques are missing, or nothing is found so, it begins anew
    with large ones, and nodes so near to each other that what is unknown does not matter between them.

    Args:
        model: gives the motion.
        values: (unknowns,) to begin with.
        recorded_with: given the spacing of the nodes in time units, returns what was measured, and the states (nodes,
            states) of each swing to begin with, see `Swing.states`.

    Raises:
        IdentificationError: no maximum is found.
    """
    recorded, states = recorded_with(_SPACING)
    try:
        search = _Search(model, values, recorded, states, Noise.white(recorded.encoders, recorded.least_torque))
        search.run()
        if search.converged and np.all(search.excess < _MISSING):
            return search.found()
    except (IdentificationError, np.linalg.LinAlgError):
        pass
    recorded, states = recorded_with(_NEAR)
    search = _Search(model, values, recorded, states, Noise.white(recorded.encoders, recorded.large_torque))
    search.run()
    if not search.converged:
        raise IdentificationError(f"the most likely motion was not found in {_MOST_STEPS} steps")
    return search.found()


class _Search:
    """Gauss and Newton's steps on states and values, with standard deviations that fit what was found so far."""

    def __init__(
        self,
        model: MotionModel,
        values: Array,
        recorded: Recorded,
        states: Sequence[Array],
        noise: Noise,
    ) -> None:
        self._model, self._values, self._recorded = model, values, recorded
        self._swings = recorded.swings
        self._states = [of.copy() for of in states]
        self._noise = noise
        self._impulses: Sequence[Array] = [np.zeros((len(of), 2, 2)) for of in states]
        self._linear: list[Linearised] = []
        self._freedom = np.zeros(2)
        self._taken = 0.0
        self._steps = 0
        self._before: list[tuple[float, float] | None] = [None, None]
        self.excess = np.ones(2)
        """(2,) the squares of the impulses, over what their standard deviation lets expect."""
        self.converged = False

    def run(self) -> None:
        """Go on until nothing changes any more, or for many steps.

        Raises:
            IdentificationError: no motion can be computed.
        """
        change, adapted, least, stalled = np.inf, np.inf, np.inf, 0
        for self._steps in range(_MOST_STEPS + 1):
            self._linear = [
                swing.linearised(self._model, self._values, of)
                for swing, of in zip(self._swings, self._states, strict=True)
            ]
            if not all(np.all(np.isfinite(of.residuals)) for of in self._linear):
                raise IdentificationError("the motion between nodes cannot be computed")
            to_and_fro = stalled >= _PATIENCE and max(change, adapted) < _TO_AND_FRO
            self.converged = max(change, adapted) < _CLOSE or to_and_fro
            if self.converged or self._steps == _MOST_STEPS:
                return
            if change < _ROUGHLY and self._taken < _TELLING:
                self._noise = self._noise.remembering(self._swings, self._linear)
            # Where the motion is nearly linear in all that changes, standard deviations need no other linearisation.
            for _ in range(_MOST_STEPS if change < _ROUGHLY else 1):
                step = self._step()
                near = step.change < _ROUGHLY
                adapted = self._adapt(step.sums, near) if near or step.is_beyond else np.inf
                if not near or adapted < _CLOSE:
                    break
            change, self._freedom = step.change, step.sums[1]
            if change < least or (np.isfinite(adapted) and not near):
                least, stalled = change, 0
            else:
                stalled += 1
            share = 1.0 if stalled < _PATIENCE else 0.5
            self._values = self._values + share * (step.values - self._values)
            self._states = [old + share * (new - old) for old, new in zip(self._states, step.states, strict=True)]
            self._impulses = step.impulses

    def found(self) -> WholeSwings:
        """Return what was found."""
        reduced = self._reduced()
        change, covariance, undetermined = _most_likely_change(self._model, self._values, reduced.of_values)
        covariance[undetermined, undetermined] = np.inf
        misfit = self._misfit(reduced, change, self._noise)
        return WholeSwings(
            model=self._model,
            values=self._values,
            covariance=covariance,
            recorded=self._recorded,
            noise=self._noise,
            is_missing=np.array([self._is_missing(joint, misfit) for joint in range(2)]),
            impulses=tuple(self._impulses),
            states=tuple(self._states),
            misfit=misfit,
            steps=self._steps,
        )

    def _misfit(self, reduced: "_Reduced", change: Array, noise: Noise) -> float:
        left = reduced.of_values[:, :-1] @ change + reduced.of_values[:, -1]
        rest = float(left @ left + reduced.rest + reduced.logarithm)
        return rest + sum(map(noise.logarithm, self._swings))

    def _is_missing(self, joint: int, misfit: float) -> bool:
        """Return whether a torque is missing in a joint, as far as the motion is linear in what it moves."""
        least = self._recorded.least_torque
        if self._freedom[joint] < _FREE or self._noise.torque[joint] <= least:
            return False
        without = replace(self._noise, torque=np.where(np.arange(2) == joint, least, self._noise.torque))
        reduced = self._reduced(without)
        change, _, _ = _most_likely_change(self._model, self._values, reduced.of_values)
        return self._misfit(reduced, change, without) > misfit + _SHOWN

    def _step(self) -> "_Step":
        """Return where the most likely states and values are, as far as the motion is linear in them."""
        reduced = self._reduced()
        change, covariance, undetermined = _most_likely_change(self._model, self._values, reduced.of_values)
        std = np.sqrt(np.diag(covariance))
        known = (undetermined == 0.0) & (std > 0.0)
        largest = float(np.abs(change[known] / std[known]).max(initial=0.0))
        all_states, all_impulses, total = list[Array](), list[Array](), np.zeros((4, 2))
        for states, linear, part in zip(self._states, self._linear, reduced.parts, strict=True):
            (nodes, n, d), sums = part.swing.transitions.shape, np.empty((4, 2))
            torques, deviations, spreads = np.zeros((nodes, 2, 2)), np.empty((nodes, d)), np.empty((nodes, d, d))
            deviations[0], spreads[0] = part.first_node(change[linear.columns], covariance, linear.columns)
            forwards(part.swing, part.impulses, deviations, spreads, torques, sums, np.empty((2 * n + 3, d + 1)))
            all_states.append(states + deviations[:, : states.shape[1]])
            all_impulses.append(torques)
            total += sums
            largest = max(largest, float(np.abs(deviations[:, :2]).max() / self._noise.encoders.max()))
        if not np.isfinite(largest):
            raise IdentificationError("the most likely motion cannot be computed")
        return _Step(self._values + change, all_states, all_impulses, total, largest)

    def _adapt(self, sums: Array, near: bool) -> float:
        """Let the standard deviations fit what was found.

        Return by how many of its own standard deviations the logarithm of one was off; infinity where states and values
        are not near to what they will be.
        """
        noise, (taken, freedom, squares, impulses) = self._noise, sums
        counts = sum(swing.counts.sum(axis=0) for swing in self._swings)
        self._taken = float(np.max(taken / counts))
        new = noise.new * np.sqrt(squares / np.maximum(counts - taken, 1.0))
        freedom, tiny = np.maximum(freedom, 0.0), np.finfo(float).tiny
        self.excess = np.maximum(impulses, tiny) / np.maximum(freedom, tiny)
        steps = [self._step_of_torque(joint) if freedom[joint] > _FREE else 0.0 for joint in range(2)]
        least = self._recorded.least_torque
        torque = np.maximum(noise.torque * np.exp(np.clip(steps, -_LONGEST, _LONGEST)), least)
        if not near:  # what is far from its place yet tells nothing but that torques are larger
            self._before = [None, None]
            self._noise = replace(noise, torque=np.maximum(torque, noise.torque))
            return np.inf
        self._noise = replace(noise, new=new, torque=torque)
        of_encoders = np.abs(squares - (counts - taken)) / np.sqrt(2.0 * np.maximum(counts - taken, 1.0))
        of_torques = np.abs(impulses - freedom) / np.sqrt(2.0 * np.maximum(freedom, tiny))
        matters = (freedom > _FREE) & (torque > least)
        return float(max(of_encoders.max(), np.where(matters, of_torques, 0.0).max()))

    def _step_of_torque(self, joint: int) -> float:
        """Return the change of a torque's logarithm that makes the excess' one zero, from the last one's (secant)."""
        size, excess = float(np.log(self._noise.torque[joint])), float(np.log(self.excess[joint]))
        before, self._before[joint] = self._before[joint], (size, excess)
        if before and size != before[0] and (slope := (excess - before[1]) / (size - before[0])) < 0.0:
            return -excess / slope
        return 0.5 * excess if excess > 0.0 else excess

    def _reduced(self, noise: Noise | None = None) -> "_Reduced":
        rows = _known_before(self._model, self._values)
        return _all_reduced(self._model, rows, self._swings, self._linear, self._states, noise or self._noise)


def _all_reduced(
    model: MotionModel,
    known: Array,
    swings: Sequence[Swing],
    linear: Sequence[Linearised],
    states: Sequence[Array],
    noise: Noise,
) -> "_Reduced":
    """Return what swings say of a model's values, states and impulses being eliminated.

    Args:
        model: gives the motion.
        known: (k, unknowns + 1) rows of what is known beforehand.
        swings: what was measured.
        linear: each of them near states and values.
        states: (nodes, states) of each.
        noise: of encoders and unknown torques.
    """
    unknowns = known.shape[1] - 1
    rows, logarithm, rest, parts = [known], 0.0, 0.0, list[_Part]()
    for swing, of, nodes_states in zip(swings, linear, states, strict=True):
        whitened = noise.whitened(swing, of)
        nodes, n, d = whitened.transitions.shape
        triangle, impulses = np.empty((d, d + 1)), np.empty((nodes, 2, d + 3))
        memory_for_rows = np.empty((d + 3 + 2 * int(np.diff(swing.samples_at).max()), d + 3))
        of_impulses, left = backwards(whitened, impulses, triangle, memory_for_rows)
        first, of_start = _with_start(triangle, swing, model, nodes_states[0], noise, n)
        logarithm += of_impulses + of_start
        rest += left
        of_values = np.zeros((len(first) - n, unknowns + 1))
        of_values[:, np.append(of.columns, unknowns)] = first[n:, n:]
        rows.append(of_values)
        parts.append(_Part(first, impulses, whitened))
    # What the values take from the noise is accounted for as well (Patterson and Thompson, Biometrika 58, 1971).
    whole = _triangle(np.concatenate(rows))
    logarithm += _logarithm_of_square(whole[:unknowns, :unknowns])
    return _Reduced(whole[:unknowns], rest + float(np.sum(whole[unknowns:, unknowns:] ** 2)), logarithm, parts)


def _with_start(
    triangle: Array, swing: Swing, model: MotionModel, start: Array, noise: Noise, n: int
) -> tuple[Array, float]:
    """Return a first node's triangle (k, d + 1) with what is known of its state, and the logarithm of a determinant."""
    deviations = np.append(swing.start_deviations(model), noise.new[: n - len(start)])
    begins = np.zeros((n, triangle.shape[1]))
    begins[:, :n] = np.diag(1.0 / deviations)
    begins[: len(start), -1] = start / deviations[: len(start)]
    first = _triangle(np.concatenate([triangle, begins]))
    known = 2.0 * float(np.sum(np.log(deviations[np.isfinite(deviations)])))
    return first, known + _logarithm_of_square(first[:n, :n])


class _Step(NamedTuple):
    """Where the most likely states and values are."""

    values: Array
    states: list[Array]
    impulses: list[Array]
    sums: Array
    """(4, 2) see `forwards`."""
    change: float
    """The largest: of a value over its deviation, or of an angle over noise."""

    @property
    def is_beyond(self) -> bool:
        """Whether the impulses are far larger than their standard deviations let expect."""
        _, freedom, _, impulses = self.sums
        return bool(np.any(impulses > _BEYOND * freedom))


class _Part(NamedTuple):
    """What a swing says."""

    first: Array
    """(d + 1, d + 1) of the state at its first node and of its unknowns, a triangle."""
    impulses: Array
    """(nodes, 2, d + 3) rows that give the impulses; see `backwards`."""
    swing: Whitened

    def first_node(self, change: Array, covariance: Array, columns: Indices) -> tuple[Array, Array]:
        """Return the most likely deviation (d,) at the first node, and its covariance, given those of the values."""
        n = self.first.shape[1] - 1 - len(columns)
        inverse = np.linalg.pinv(self.first[:n, :n])
        by_values = -inverse @ self.first[:n, n:-1]
        given = np.concatenate([by_values, np.eye(len(columns))])
        spread = given @ covariance[np.ix_(columns, columns)] @ given.T
        spread[:n, :n] += inverse @ inverse.T
        return np.concatenate([by_values @ change - inverse @ self.first[:n, -1], change]), spread


class _Reduced(NamedTuple):
    """What all swings say of the values."""

    of_values: Array
    """(unknowns, unknowns + 1) a triangle."""
    rest: float
    """Sum of squares that no values change."""
    logarithm: float
    """Of a determinant."""
    parts: list[_Part]


def _triangle(rows: Array) -> Array:
    """Return the triangle (k, k) whose products are those of rows (n, k)."""
    return np.asarray(np.linalg.qr(rows, mode="r"))


def _scaled(triangle: Array) -> tuple[Array, Array]:
    """Return a triangle (k, k) with columns of length one, and their lengths (k,)."""
    lengths = np.maximum(np.linalg.norm(triangle, axis=0), _NOTHING)
    return triangle / lengths, lengths


def _logarithm_of_square(triangle: Array) -> float:
    """Return the logarithm of the square of a triangle's determinant, but for what it does not determine."""
    scaled, lengths = _scaled(triangle)
    sizes = np.linalg.svd(scaled, compute_uv=False)
    determined = lengths[lengths > _NOTHING], sizes[sizes > _UNOBSERVABLE * sizes[0]]
    return 2.0 * sum(float(np.sum(np.log(of))) for of in determined)


def _known_before(model: MotionModel, values: Array) -> Array:
    """Return rows (k, unknowns + 1) whose squares are what is known of the values beforehand."""
    precision = model.penalty / max(model.penalty_of_errors, np.finfo(float).tiny)
    sizes, vectors = np.linalg.eigh(precision)
    roots = np.sqrt(np.maximum(sizes, 0.0))[:, None] * vectors.T
    return np.column_stack([roots, roots @ values])


def _most_likely_change(model: MotionModel, values: Array, triangle: Array) -> tuple[Array, Array, Array]:
    """Return the change of the values (unknowns,) within their limits, their covariance, and what is undetermined."""
    of_values, target = triangle[: len(values), :-1], triangle[: len(values), -1]
    scaled, lengths = _scaled(of_values)
    left, sizes, right = np.linalg.svd(scaled)
    kept = sizes > _UNOBSERVABLE * sizes[0]
    inverse = right[kept].T / sizes[kept]
    change = -(inverse @ left[:, kept].T @ target) / lengths
    covariance = inverse @ inverse.T / np.outer(lengths, lengths)
    undetermined = np.any(np.abs(right[~kept]) > 1e-3, axis=0)
    lower, upper = np.minimum(model.limits[0] - values, 0.0), np.maximum(model.limits[1] - values, 0.0)
    if np.any((change < lower) | (change > upper)):
        change = minimum_within_limits(of_values.T @ of_values, -of_values.T @ target, lower, upper)
    return change, covariance, undetermined

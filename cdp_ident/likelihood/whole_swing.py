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

import numpy as np
import numpy.typing as npt

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.bounded import minimum_within_limits
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.likelihood.noise import DIFFERENCE, Noise, memory_of
from cdp_ident.likelihood.sweeps import backwards, forwards
from cdp_ident.likelihood.swing import Linearised, Swing

Array = npt.NDArray[np.float64]

_MOST_STEPS = 60
_ROUGHLY, _CLOSE = 1.0, 0.01
"""Standard deviations are estimated once no step changes a value by more than the first share of its own, and steps end
where none changes by more than the second."""
_SPACING, _NEAR = 0.5, 0.05
"""Between nodes, in time units: where nothing is missing, and where torques are, whose impulses are at the nodes."""
_LEAST_TORQUE = 1e-5
"""Unknown torques are at least so large that within a time unit their impulses change an angle by this share of the
encoders' noise: far less than matters, and enough to forget what rounding makes of a chaotic motion."""
_MISSING = 4.0
"""Torques are missing where the least impulses' squares are so many times what is expected of them."""
_LONGEST = 2.0
"""Largest change of a torque's logarithm in a step."""
_NOTHING = 1e-100
"""Length of what is nothing."""
_UNOBSERVABLE = 1e-7
"""Directions of scaled unknowns with less than this share of the largest precision are not determined."""


@dataclass(frozen=True)
class WholeSwings:
    """The most likely values, and what belongs to them."""

    values: Array
    """(unknowns,)"""
    covariance: Array
    """(unknowns, unknowns) of these; infinite where the swings do not determine one."""
    noise: Noise
    """Of encoders and unknown torques; a torque of zero where none is missing."""
    impulses: tuple[Array, ...]
    """(nodes, 2) of each swing: the impulses of unknown torques in both joints after each node, over A22 [1/s]."""
    states: tuple[Array, ...]
    """(nodes, states) of each swing, and where its clock is uncertain by how much that is fast."""
    misfit: float
    """Minus twice the logarithm of the likelihood, but for a constant."""
    steps: int


def most_likely(
    model: MotionModel,
    values: Array,
    swings_with: Callable[[float], tuple[Sequence[Swing], Sequence[Array]]],
    encoders: Array,
    time_unit: float,
) -> WholeSwings:
    """Find the most likely values, states and standard deviations.

    It begins with no unknown torque but the least. Where torques are missing, or nothing is found so, it begins anew
    with large ones, and nodes so near to each other that what is unknown does not matter between them.

    Args:
        model: gives the motion.
        values: (unknowns,) to begin with.
        swings_with: given the spacing of the nodes [s], returns what was measured, and the states (nodes, states) of
            each swing to begin with, see `Swing.states`.
        encoders: (2,) standard deviation of both encoders' noise to begin with [rad].
        time_unit: of the rig, sqrt(L / g) [s].

    Raises:
        IdentificationError: no maximum is found.
    """
    large = float(encoders.max()) / time_unit**1.5
    least = _LEAST_TORQUE * large
    try:
        search = _Search(model, values, *swings_with(_SPACING * time_unit), encoders, least, least)
        search.run()
        if np.all(search.excess < _MISSING):
            return search.found()
    except (IdentificationError, np.linalg.LinAlgError):
        pass
    search = _Search(model, values, *swings_with(_NEAR * time_unit), encoders, large, least)
    search.run()
    return search.found()


class _Search:
    """Gauss and Newton's steps on states and values, with standard deviations that fit what was found so far."""

    def __init__(
        self,
        model: MotionModel,
        values: Array,
        swings: Sequence[Swing],
        states: Sequence[Array],
        encoders: Array,
        torque: float,
        least: float,
    ) -> None:
        self._model, self._values, self._swings, self._least = model, values, swings, least
        self._states = [of.copy() for of in states]
        self._noise = Noise(encoders, np.zeros(2), np.full(2, torque))
        self._impulses = [np.zeros((len(of), 2)) for of in states]
        self._linear: list[Linearised] = []
        self._steps = 0
        self._before: list[tuple[float, float] | None] = [None, None]
        self.excess = np.ones(2)
        """(2,) the squares of the impulses, over what their standard deviation lets expect."""

    def run(self) -> None:
        """Go on until nothing changes any more.

        Raises:
            IdentificationError: that is not so after many steps, or no motion can be computed.
        """
        change = np.inf
        for self._steps in range(_MOST_STEPS):
            self._linear = [
                swing.linearised(self._model, self._values, of)
                for swing, of in zip(self._swings, self._states, strict=True)
            ]
            if not all(np.all(np.isfinite(of.residuals)) for of in self._linear):
                raise IdentificationError("the motion between nodes cannot be computed")
            if change < _ROUGHLY and max(change, self._adapt()) < _CLOSE:
                return
            change = self._step()
        raise IdentificationError(f"the most likely motion was not found in {_MOST_STEPS} steps")

    def found(self) -> WholeSwings:
        """Return what was found."""
        triangle, logarithm, _ = self._reduced(self._noise)
        change, covariance = _most_likely_change(self._model, self._values, triangle)
        left = triangle[:, :-1] @ change + triangle[:, -1]
        counts = sum(swing.counts.sum(axis=0) for swing in self._swings)
        return WholeSwings(
            values=self._values,
            covariance=covariance,
            noise=replace(self._noise, torque=np.where(self._noise.torque > self._least, self._noise.torque, 0.0)),
            impulses=tuple(self._impulses),
            states=tuple(self._states),
            misfit=float(left @ left + logarithm + 2.0 * counts @ np.log(self._noise.encoders)),
            steps=self._steps,
        )

    def _step(self) -> float:
        """Take a step, and return the largest change: of a value over its deviation, or of an angle over noise."""
        triangle, _, parts = self._reduced(self._noise)
        change, covariance = _most_likely_change(self._model, self._values, triangle)
        deviations = np.sqrt(np.diag(covariance))
        known = np.isfinite(deviations) & (deviations > 0.0)
        changes = [float(np.abs(change[known] / deviations[known]).max(initial=0.0))]
        for states, impulses, linear, (first, of_impulses) in zip(
            self._states, self._impulses, self._linear, parts, strict=True
        ):
            n, of_values, before = states.shape[1], change[linear.columns], states[:, :2].copy()
            start = -np.linalg.lstsq(first[:n, :n], first[:n, -1] + first[:n, n:-1] @ of_values)[0]
            deviation = np.concatenate([start, of_values])
            forwards(*linear[:3], of_impulses, deviation, np.empty(n), states, impulses)
            changes.append(float(np.abs(states[:, :2] - before).max() / self._noise.encoders.max()))
        if not np.all(np.isfinite(changes)):
            raise IdentificationError("the most likely motion cannot be computed")
        self._values = self._values + change
        return max(changes)

    def _adapt(self) -> float:
        """Let the standard deviations fit what was found, and return the largest change of their logarithms."""
        noise, logarithm = self._noise, self._reduced(self._noise)[1]
        larger = np.array([self._reduced(other)[1] for other in noise.each_larger()])
        # Degrees of freedom that the estimates take from the noise, and that the torques have.
        taken, freedom = ((larger - logarithm) / (2.0 * DIFFERENCE)).reshape(2, 2) * [[-1.0], [1.0]]
        counts = sum(swing.counts.sum(axis=0) for swing in self._swings)
        squares = noise.squares(self._swings, self._linear)
        encoders = noise.encoders * np.sqrt(squares / np.maximum(counts - taken, 1.0))
        impulses = sum(
            np.sum(of**2, axis=0) / swing.spacing for swing, of in zip(self._swings, self._impulses, strict=True)
        )
        tiny = np.finfo(float).tiny
        self.excess = np.maximum(impulses / noise.torque**2, tiny) / np.maximum(freedom, tiny)
        steps = [self._step_of_torque(joint) if noise.torque[joint] > self._least else 0.0 for joint in range(2)]
        torque = np.maximum(noise.torque * np.exp(np.clip(steps, -_LONGEST, _LONGEST)), self._least)
        self._noise = Noise(encoders, memory_of(self._swings, self._linear), torque)
        changes = (
            *np.log(encoders / noise.encoders),
            *np.log(torque / noise.torque),
            *(self._noise.memory - noise.memory),
        )
        return float(np.abs(changes).max())

    def _step_of_torque(self, joint: int) -> float:
        """Return the change of a torque's logarithm that makes the excess' one zero, from the last one's (secant)."""
        size, excess = float(np.log(self._noise.torque[joint])), float(np.log(self.excess[joint]))
        before, self._before[joint] = self._before[joint], (size, excess)
        if before and size != before[0] and (slope := (excess - before[1]) / (size - before[0])) < 0.0:
            return -excess / slope
        return 0.5 * excess if excess > 0.0 else excess

    def _reduced(self, noise: Noise) -> tuple[Array, float, list[tuple[Array, Array]]]:
        """Return what all swings say of the values, a triangle (k, unknowns + 1), and a determinant's logarithm.

        With them comes each swing's triangle at its first node, and the rows of its impulses; see `backwards`.
        """
        unknowns = len(self._values)
        rows, logarithm, parts = [_known_before(self._model, self._values)], 0.0, list[tuple[Array, Array]]()
        for swing, linear, states in zip(self._swings, self._linear, self._states, strict=True):
            nodes, n, d = linear.transitions.shape
            first, impulses = np.empty((d + 1, d + 1)), np.empty((nodes, 2, d + 3))
            memory_for_rows = np.empty((d + 5 + 2 * int(np.diff(swing.samples_at).max()), d + 3))
            roots, remembered = noise.roots(swing, linear)
            sizes = noise.torque * np.sqrt(swing.spacing)
            logarithm += backwards(linear, swing.samples_at, roots, remembered, sizes, impulses, first, memory_for_rows)
            precisions = 1.0 / swing.start_deviations(self._model)
            begins = np.zeros((n, d + 1))
            begins[:, :n], begins[:, -1] = np.diag(precisions), precisions * states[0]
            triangle = _triangle(np.concatenate([first, begins]))
            logarithm += _logarithm_of_square(triangle[:n, :n])
            of_values = np.zeros((d + 1 - n, unknowns + 1))
            of_values[:, np.append(linear.columns, unknowns)] = triangle[n:, n:]
            rows.append(of_values)
            parts.append((triangle, impulses))
        # What the values take from the noise is accounted for as well (Patterson and Thompson, Biometrika 58, 1971).
        whole = _triangle(np.concatenate(rows))
        return whole, logarithm + _logarithm_of_square(whole[:unknowns, :unknowns]), parts


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
    return 2.0 * float(np.sum(np.log(lengths)) + np.sum(np.log(sizes[sizes > _UNOBSERVABLE * sizes[0]])))


def _known_before(model: MotionModel, values: Array) -> Array:
    """Return rows (k, unknowns + 1) whose squares are what is known of the values beforehand."""
    precision = model.penalty / max(model.penalty_of_errors, np.finfo(float).tiny)
    sizes, vectors = np.linalg.eigh(precision)
    roots = np.sqrt(np.maximum(sizes, 0.0))[:, None] * vectors.T
    return np.column_stack([roots, roots @ values])


def _most_likely_change(model: MotionModel, values: Array, triangle: Array) -> tuple[Array, Array]:
    """Return the change of the values (unknowns,) within their limits, and their covariance."""
    of_values, target = triangle[: len(values), :-1], triangle[: len(values), -1]
    scaled, lengths = _scaled(of_values)
    left, sizes, right = np.linalg.svd(scaled)
    kept = sizes > _UNOBSERVABLE * sizes[0]
    inverse = right[kept].T / sizes[kept]
    change = -(inverse @ left[:, kept].T @ target) / lengths
    covariance = inverse @ inverse.T / np.outer(lengths, lengths)
    undetermined = np.any(np.abs(right[~kept]) > 1e-3, axis=0)
    covariance[undetermined, undetermined] = np.inf
    lower, upper = np.minimum(model.limits[0] - values, 0.0), np.maximum(model.limits[1] - values, 0.0)
    if np.any((change < lower) | (change > upper)):
        change = minimum_within_limits(of_values.T @ of_values, -of_values.T @ target, lower, upper)
    return change, covariance

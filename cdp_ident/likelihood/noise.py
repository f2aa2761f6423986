# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The noise of encoders and the size of unknown torques, and what readings are worth under them."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cdp_ident.arrays import Array, Mask
from cdp_ident.likelihood.sweeps import Whitened, filter_rows, squares_and_expected
from cdp_ident.likelihood.swing import Linearised, Swing
from cdp_ident.trial.kinematics import MEDIAN_OF_SIZE

_OUTLIER = 4.0
"""Readings that are further off than so many standard deviations lose weight (Huber, Robust Statistics, 1981)."""
_FREEDOM = 3.0
"""Degrees of freedom of the distribution of unknown torques."""
_SURE, _LONGEST_MEMORY = 4.0, 0.99
"""Noise is taken to be remembered where its correlation is so many standard deviations; and the largest correlation."""
_MM_STEPS, _CHANGES_LITTLE = 50, 1e-4
"""So many steps find errors of time, or fewer if one changes no size by more than this share; what is missing then, the
next look at the residuals brings."""


@dataclass(frozen=True)
class Noise:
    """What the model does not say: noise of encoders and unknown torques.

    An encoder's noise is white noise, such as that of rounding, and one of which a part is still there at the next
    reading. Both together are an autoregressive moving average of order (1, 1): what is new in a reading is
    w[k] = y[k] - kept y[k-1] + mixed w[k-1] (Box and Jenkins, Time Series Analysis, 1970).
    """

    new: Array
    """(2,) standard deviation of what is new in each reading of both encoders [rad]."""
    kept: Array
    """(2,) see above; zero for white noise."""
    mixed: Array
    """(2,) see above."""
    torque: Array
    """(2,) standard deviation of unknown torques in both joints, white noise over A22 [1/s^1.5]."""
    time: float = 0.0
    """Standard deviation of the times of readings, the same error for both encoders [s]; where noise is remembered,
    zero."""
    of_base: bool = False
    """Whether in the place of the inner joint's torque the base moves: an acceleration, over L."""
    absolute: bool = False
    """Whether noise is independent in both absolute angles, as where a camera sees them, and not in both encoders: the
    three above are of theta1 and theta2 then."""
    tails: tuple[Array, ...] = ()
    """(nodes, 2) of each swing, how many times as large the torques after each node are."""

    @classmethod
    def white(cls, encoders: Array, torque: float) -> "Noise":
        """Return white noise of both encoders (2,), and the same torque in both joints."""
        return cls(encoders, np.zeros(2), np.zeros(2), np.full(2, torque))

    def with_torque_of_at_least(self, torque: float | Array) -> "Noise":
        """Return the same noise with larger torques, where they are smaller than that."""
        return replace(self, torque=np.maximum(self.torque, torque))

    def tails_of(self, place: int) -> Array | None:
        """Return the tails of a swing, None where all torques are of one size."""
        return self.tails[place] if self.tails else None

    def with_tails(self, impulses: Sequence[Array], swings: Sequence[Swing], torque: Array, least: float) -> "Noise":
        """Return the same noise with torques of a Student's t distribution: rare ones may be large.

        Args:
            impulses: (nodes, 2, 2) of each swing, and their standard deviations.
            swings: of which they are.
            torque: (2,) standard deviation with which they were estimated.
            least: torques that are no larger have one size.
        """
        found = []
        for of, swing in zip(impulses, swings, strict=True):
            with np.errstate(over="ignore"):  # a motion that is lost altogether
                squares = np.sum(of**2, axis=1) / (torque**2 * swing.spacing)
            found.append(np.where(self.torque > least, np.sqrt((_FREEDOM + squares) / (_FREEDOM + 1.0)), 1.0))
        return replace(self, tails=tuple(found))

    @property
    def unlikelihood_of_tails(self) -> float:
        """Twice by how much less likely torques of these sizes are than equally large ones.

        A Student's t distribution is one of Gaussians whose precisions have a gamma distribution.
        """
        return float(sum(np.sum(_unlikelihood(of)) for of in self.tails))

    def regained(self, tails: Array) -> Array:
        """Return by how much the misfit falls (nodes, 2) if a torque need not be so many times as large any more."""
        return _unlikelihood(tails) + 2.0 * np.log(tails)

    @property
    def torque_with_tails(self) -> Array:
        """(2,) standard deviation of unknown torques, over all nodes, over A22 [1/s^1.5]."""
        squares = np.concatenate([of**2 for of in self.tails] or [np.ones((1, 2))])
        return np.asarray(self.torque * np.sqrt(np.mean(squares, axis=0)))

    def with_torque_in_one(self, joint: int, torque: float) -> "Noise":
        """Return the same noise with another torque in one joint, equally large all the time."""
        there = np.arange(2) == joint
        tails = tuple(np.where(there, 1.0, of) for of in self.tails)
        return replace(self, torque=np.where(there, torque, self.torque), tails=tails)

    @property
    def encoders(self) -> Array:
        """(2,) standard deviation of both encoders' noise [rad]."""
        return np.sqrt(np.cumsum(self.sizes**2)) if self.absolute else self.sizes

    def angles(self, counted: Mask) -> Array:
        """Return the standard deviation (2,) of the noise of theta1 and theta2, by that which counts (2,) [rad]."""
        sizes = np.where(counted, self.sizes, 0.0)
        return sizes if self.absolute else np.sqrt(np.cumsum(sizes**2))

    @property
    def sizes(self) -> Array:
        """(2,) standard deviation of the noise of what is independent [rad]."""
        return np.asarray(self.new * np.sqrt(self._gain))

    def _seen(self, linear: Linearised) -> Linearised:
        """Return a linearised swing with readings of what is independent."""
        if not self.absolute:
            return linear
        names = ("slopes", "residuals", "rates")
        return linear._replace(**{name: np.cumsum(getattr(linear, name), axis=1) for name in names})

    @property
    def _gain(self) -> Array:
        """(2,) variance of the noise over that of what is new in it."""
        return np.asarray((1.0 + self.mixed**2 - 2.0 * self.kept * self.mixed) / (1.0 - self.kept**2))

    @property
    def memory(self) -> Array:
        """(2,) correlation of both encoders' noise from one reading to the next."""
        return np.asarray(self.kept - self.mixed / self._gain)

    @property
    def is_white(self) -> bool:
        """Whether nothing of a reading's noise is in the next one's."""
        return not np.any(self.kept)

    @property
    def kind(self) -> tuple[bool, bool, bool]:
        """Whether it is of absolute angles, whether it is white, and whether times have errors."""
        return self.absolute, self.is_white, self.time > 0.0

    def whitened(self, swing: Swing, linear: Linearised, tails: Array | None = None) -> Whitened:
        """Return a linearised swing whose readings have white noise of size one; outliers count less.

        Where noise is remembered, two more numbers of the state carry it from node to node.
        """
        linear = self._seen(linear)
        sizes = self.torque * np.sqrt(swing.spacing) * (np.ones((len(linear.gaps), 2)) if tails is None else tails)
        if self.is_white:
            by_time, residuals = self.time * linear.rates, linear.residuals
            if self.time > 0.0:
                # On average, errors of time show where a joint goes to, by its acceleration.
                residuals = residuals + 0.5 * self.time**2 * np.gradient(linear.rates, swing.time, axis=0)
            roots = self._roots(swing, residuals, by_time)
            shown = np.concatenate([linear.slopes, residuals[..., None]], axis=-1) * roots[..., None]
            if self.time > 0.0:
                shown = _independent(shown, by_time * roots)
            return Whitened(
                linear.transitions, linear.gaps, self._pushes(linear), np.ascontiguousarray(shown[..., :-1]),
                shown[..., -1].copy(), swing.samples_at, sizes,
            )  # fmt: skip
        follows = self._follows(swing)
        nodes, n, d = linear.transitions.shape
        transitions, gaps = np.zeros((nodes, n + 2, d + 2)), np.zeros((nodes, n + 2))
        transitions[:, :n, :n], transitions[:, :n, n + 2 :] = linear.transitions[..., :n], linear.transitions[..., n:]
        gaps[:, :n] = linear.gaps
        rows = np.zeros((len(swing.time), 2, d + 2))
        rows[..., :n], rows[..., n + 2 :] = linear.slopes[..., :n], linear.slopes[..., n:]
        right, new = linear.residuals.copy(), linear.residuals.copy()
        filter_rows(rows, right, new, follows, swing.samples_at, self.kept, self.mixed, transitions, gaps)
        roots = self._roots(swing, new, np.zeros(2)) / np.where(follows, 1.0, np.sqrt(self._gain))
        return Whitened(
            transitions, gaps, self._pushes(linear), rows * roots[..., None], right * roots, swing.samples_at, sizes
        )

    def _pushes(self, linear: Linearised) -> Array:
        """Return the changes (nodes, 2, 2) of the rods' speeds by what is unknown."""
        if not self.of_base:
            return linear.pushes
        return np.ascontiguousarray(np.stack([linear.by_base, linear.pushes[:, :, 1]], axis=2))

    def _follows(self, swing: Swing) -> Mask:
        """Return whether each reading's noise remembers the one before (samples, 2)."""
        return swing.follows & (self.kept > 0.0)

    def _roots(self, swing: Swing, new: Array, by_time: Array) -> Array:
        """Return one over the standard deviation (samples, 2) of what is new; outliers have a larger one.

        Args:
            swing: what is measured.
            new: (samples, 2) in the encoders' noise [rad].
            by_time: (samples, 2) or (2,) standard deviation of what errors of time add [rad].
        """
        # Where times are right, noise that is not known yet is at least the usual size of what is left.
        usual = np.median(np.abs(new[swing.counts[:, 0] > 0.0]), axis=0) / MEDIAN_OF_SIZE
        beyond = np.abs(new) / (_OUTLIER * np.hypot(np.maximum(self.new, usual * (self.time == 0.0)), by_time))
        return np.asarray(np.sqrt(swing.counts / np.maximum(beyond, 1.0)) / self.new)

    def logarithm(self, swing: Swing, linear: Linearised) -> float:
        """Return the logarithm of the determinant of the covariance of a swing's readings, given those before."""
        counted = swing.counts > 0.0
        variances = self.new**2 * (
            np.ones((1, 2)) if self.is_white else np.where(self._follows(swing), 1.0, self._gain)
        )
        found = float(np.sum(counted * np.log(variances)))
        if self.time > 0.0:
            rates = self._seen(linear).rates
            found += float(np.sum(np.log1p(np.sum(counted * (self.time * rates) ** 2 / variances, axis=1))))
        return found

    def with_errors_of_time(self, swings: Sequence[Swing], linear: Sequence[Linearised]) -> "Noise":
        """Return white noise and errors of time as the residuals show them, at the maximum of their likelihood.

        They are looked for where the score of their variance shows them. Each step takes a sum of squares over what is
        expected of it, and does not lower the likelihood (Zhou, Hu, Zhou and Lange, MM algorithms for variance
        components models, J. Comput. Graph. Stat. 28, 2019).
        """
        counted, seen = [np.all(swing.counts > 0.0, axis=1) for swing in swings], [*map(self._seen, linear)]
        left, rates = (  # (samples, 2)
            np.concatenate([getattr(of, name)[kept] for of, kept in zip(seen, counted, strict=True)])
            for name in ("residuals", "rates")
        )
        sizes, time = self.sizes, self.time
        if time == 0.0:
            weighted = rates / sizes**2
            of_left, expected = (np.sum(weighted * of, axis=1) for of in (left, rates))
            more = np.sum(of_left**2 - expected) / np.sqrt(2.0 * np.sum(expected**2))
            if not more >= _SURE:
                return replace(self, time=0.0)
            time = float(np.sqrt(np.sum(sizes**2) / np.sum(np.mean(rates**2, axis=0))))
        for _ in range(_MM_STEPS):
            squares, expected = squares_and_expected(left, rates, sizes, time)
            by_sizes, by_time = np.sqrt(squares[:2] / expected[:2]), float(np.sqrt(squares[2] / expected[2]))
            time, sizes = time * by_time, sizes * by_sizes
            if max(abs(by_time - 1.0), float(np.abs(by_sizes - 1.0).max())) < _CHANGES_LITTLE:
                break
        return replace(self, new=sizes, time=time, kept=np.zeros(2), mixed=np.zeros(2))

    def remembering(self, swings: Sequence[Swing], linear: Sequence[Linearised]) -> "Noise":
        """Return the noise with as much memory as residuals show, as far as that is sure."""
        covariances, pairs = np.zeros((4, 2)), 1
        for swing, of in zip(swings, linear, strict=True):
            whole = np.all(swing.counts == 1.0, axis=1)
            left = np.where(whole[:, None], self._seen(of).residuals, 0.0)
            covariances += [np.sum(left[lag:] * left[: len(left) - lag], axis=0) for lag in range(4)]
            pairs += int(whole.sum())
        variance, first, second, third = np.maximum(covariances / pairs, np.finfo(float).tiny)
        sure = _SURE / np.sqrt(pairs)
        # Of white noise and one that is kept, the latter alone is seen from one reading to the next ones.
        kept = np.where(second > sure * variance, (second + third) / (first + second), first / variance)
        kept = np.where(first > sure * variance, np.minimum(kept, _LONGEST_MEMORY), 0.0)
        white = np.where(kept > 0.0, np.maximum(variance - first / np.maximum(kept, sure), 0.0), 0.0)
        a, b = (1.0 - kept**2) * (variance - white) + (1.0 + kept**2) * white, kept * white
        mixed = np.where(b > 0.0, 2.0 * b / (a + np.sqrt(np.maximum(a**2 - 4.0 * b**2, 0.0))), 0.0)
        found = replace(self, kept=kept, mixed=mixed, time=0.0)
        sizes = np.where(covariances[0] > 0.0, np.sqrt(variance), self.sizes)
        return replace(found, new=sizes / np.sqrt(found._gain))

    def of_other_angles(self, swings: Sequence[Swing], linear: Sequence[Linearised]) -> "Noise":
        """Return white noise that is independent in the absolute angles, or else in the encoders, as residuals show."""
        found, squares, counts = replace(self, absolute=not self.absolute, time=0.0), np.zeros(2), np.zeros(2)
        for swing, of in zip(swings, linear, strict=True):
            squares += np.sum(swing.counts * found._seen(of).residuals ** 2, axis=0)
            counts += swing.counts.sum(axis=0)
        return replace(found, new=np.sqrt(squares / counts), kept=np.zeros(2), mixed=np.zeros(2))


def _independent(shown: Array, by_time: Array) -> Array:
    """Return independent rows (samples, 2, k) in the place of those whose covariance is I + b b', with b (samples, 2).

    They are multiplied by the inverse of its Cholesky factor.
    """
    first, second = by_time.T[..., None]
    inner = 1.0 + first**2
    outer = (inner + second**2) / inner
    along = shown[:, 1] - first * second / inner * shown[:, 0]
    return np.stack([shown[:, 0] / np.sqrt(inner), along / np.sqrt(outer)], axis=1)


def _unlikelihood(tails: Array) -> Array:
    """Return twice the logarithm of how much less likely torques of some size are than one of the usual size."""
    return np.asarray(_FREEDOM * (tails**-2.0 - 1.0 + 2.0 * np.log(tails)))

"""The noise of encoders and the size of unknown torques, and what readings are worth under them."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cdp_ident.likelihood.swing import Linearised, Swing

Array = npt.NDArray[np.float64]

DIFFERENCE = 0.05
"""Change of a standard deviation's logarithm by which degrees of freedom are found."""
_OUTLIER, _FEW = 4.0, 0.05
"""Readings that are further off than so many standard deviations lose weight (Huber, Robust Statistics, 1981), unless
they are a larger share than this: then they are no outliers."""
_REMEMBERED, _SURE, _MOST_REMEMBERED = 0.05, 4.0, 0.99
"""Noise is taken to be remembered where its correlation from one reading to the next is at least so large and so many
standard deviations; and the largest correlation."""


@dataclass(frozen=True)
class Noise:
    """What the model does not say: noise of encoders and unknown torques."""

    encoders: Array
    """(2,) standard deviation of both encoders' noise [rad]."""
    memory: Array
    """(2,) correlation of that from one reading to the next: an autoregressive process."""
    torque: Array
    """(2,) standard deviation of unknown torques in both joints, white noise over A22 [1/s^1.5]."""

    def each_larger(self) -> Iterator["Noise"]:
        """Return it with a larger standard deviation: of each encoder, then of each torque."""
        for name in ("encoders", "torque"):
            for joint in range(2):
                yield replace(
                    self, **{name: getattr(self, name) * np.where(np.arange(2) == joint, np.exp(DIFFERENCE), 1.0)}
                )

    def remembered(self, swing: Swing) -> Array:
        """Return how much of the noise of the reading before is still in each reading (samples, 2)."""
        memory = np.zeros(swing.counts.shape)
        if not np.any(self.memory):
            return memory
        steps = np.diff(swing.time)
        memory[1:] = self.memory ** (steps / np.median(steps))[:, None]
        memory[1:][(swing.counts[1:] < 1.0) | (swing.counts[:-1] < 1.0)] = 0.0
        after_none = swing.samples_at[1:-1][np.diff(swing.samples_at)[:-1] == 0]
        memory[after_none[after_none < len(memory)]] = 0.0
        return memory

    def roots(self, swing: Swing, linear: Linearised) -> tuple[Array, Array]:
        """Return one over the standard deviation of what is new in each reading's noise, outliers having a larger one.

        With it comes how much of the noise of the reading before is still in each; both are (samples, 2).
        """
        memory = self.remembered(swing)
        deviations = self.encoders * np.sqrt(1.0 - memory**2)
        new = linear.residuals - memory * np.roll(linear.residuals, 1, axis=0)
        beyond = np.abs(new) / (_OUTLIER * deviations)
        counts = swing.counts / np.maximum(beyond, 1.0) if np.mean(beyond > 1.0) < _FEW else swing.counts
        return np.sqrt(counts) / deviations, memory

    def squares(self, swings: Sequence[Swing], linear: Sequence[Linearised]) -> Array:
        """Return the sum of squares (2,) of what is new in each reading's noise, over its variance."""
        total = np.zeros(2)
        for swing, of in zip(swings, linear, strict=True):
            roots, memory = self.roots(swing, of)
            total += np.sum((roots * (of.residuals - memory * np.roll(of.residuals, 1, axis=0))) ** 2, axis=0)
        return total


def memory_of(swings: Sequence[Swing], linear: Sequence[Linearised]) -> Array:
    """Return the correlation (2,) of each encoder's residuals from one reading to the next, as far as that is sure."""
    products, squares, count = np.zeros(2), np.full(2, np.finfo(float).tiny), 1
    for swing, of in zip(swings, linear, strict=True):
        whole = np.all(swing.counts == 1.0, axis=1)
        pairs = whole[1:] & whole[:-1]
        now, before = of.residuals[1:][pairs], of.residuals[:-1][pairs]
        products += np.sum(now * before, axis=0)
        squares += np.sum(before**2, axis=0)
        count += len(now)
    memory = products / squares
    return np.where(memory > max(_REMEMBERED, _SURE / np.sqrt(count)), np.minimum(memory, _MOST_REMEMBERED), 0.0)

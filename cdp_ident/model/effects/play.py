"""Play in the coupling between a joint and its encoder, which follows only once the joint has turned through the gap.

What the encoder is turned by depends on what the joint did before: it is the play operator of the joint's angle
(Krasnosel'skii and Pokrovskii, Systems with Hysteresis, 1989). So its derivatives are not those of the same instant:
while the joint turns within the gap, they are those of the instant at which it last pushed the encoder.
"""

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from cdp_ident.model.compilation import compiled

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

_STILL = 1e-11
"""A joint that turns by less from sample to sample is at rest [rad]; it is rounding."""
_BEFORE = -1


@dataclass(frozen=True)
class Followed:
    """What an encoder is turned by, and its derivatives."""

    angle: Array
    """(n,) [rad]"""
    by_gap: Array
    """(n,) its derivative by the gap."""
    source: Indices
    """(n,) index of the sample at which the joint last pushed it, whose derivatives each angle has; -1 before."""

    def slopes(self, of_joint: Array) -> Array:
        """Return the derivatives (n, d) of the angle, given those of the joint's angle."""
        slopes = of_joint[self.source]
        slopes[self.source == _BEFORE] = 0.0
        return slopes


def follow(angle: Array, gap: float, before: float | None = None) -> Followed:
    """Return what an encoder is turned by.

    Args:
        angle: (n,) the joint's, in the order of time [rad]; where it is not a number, so is what is returned.
        gap: the whole one, of which the encoder is in the middle where both show the same [rad].
        before: what the encoder is turned by before the first sample [rad]. Where it is not given, a joint that turns
            has gone through the gap and pushes the encoder, and one at rest is in the middle.
    """
    lost = np.flatnonzero(~np.isfinite(angle))
    ends = int(lost[0]) if len(lost) else len(angle)
    if before is None:
        moved = angle[min(1, len(angle) - 1)] - angle[0]
        before = angle[0] - (np.sign(moved) * gap if abs(moved) > _STILL else 0.0)
    turned, by_gap, source = np.empty(len(angle)), np.empty(len(angle)), np.empty(len(angle), dtype=np.int64)
    _follow(np.array(angle[:ends]), 0.5 * gap, float(before), turned, by_gap, source)
    turned[ends:], by_gap[ends:], source[ends:] = np.nan, np.nan, ends
    return Followed(turned, by_gap, source)


@compiled
def _follow(angle, half, now, turned, by_gap, source):
    side, pushed = 0.0, _BEFORE
    for k in range(len(angle)):
        if angle[k] - half > now:
            now, side, pushed = angle[k] - half, -0.5, k
        elif angle[k] + half < now:
            now, side, pushed = angle[k] + half, 0.5, k
        turned[k], by_gap[k], source[k] = now, side, pushed


@dataclass
class Turned:
    """By what encoders with play were turned, over the piece of a motion that was looked at last.

    A motion that is asked for piece by piece goes on from it. Pieces may overlap.
    """

    _time: dict[int, Array] = field(default_factory=dict)
    _angle: dict[int, Array] = field(default_factory=dict)

    def follow(self, joint: int, time: Array, angle: Array, gap: float, before: float | None = None) -> Followed:
        """Return what the encoder of a joint is turned by in the next piece.

        Args:
            joint: 0 for the inner one, 1 for the outer one.
            time: (n,) of the samples [s]; the first one is not before the first one of the piece before.
            angle: (n,) the joint's [rad].
            gap: the whole one [rad].
            before: what it is turned by before the first piece [rad]; see `follow`.
        """
        place = int(np.searchsorted(self._time.get(joint, np.empty(0)), time[0], side="right")) - 1
        if place >= 0:
            before = float(self._angle[joint][place])
        followed = follow(angle, gap, before)
        self._time[joint], self._angle[joint] = time, followed.angle
        return followed

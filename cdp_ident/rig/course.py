"""Prediction of a rig's next sample, to recognise one that is wrong."""

import math
from collections.abc import Sequence

from cdp_ident.rig.codec import UNSIGNED_32
from cdp_ident.rig.records import Sample

_LEAST = (100.0, 4.0, 4.0, 4.0)
"""A clock that is read this late [us], and counts that flicker by so many, are never doubted."""
_TIMES_USUAL = 8.0
"""A sample is doubted where it is farther off than so many times what is usual."""
_FORGOTTEN = 0.98
"""What is usual shrinks by this from sample to sample."""


class Course:
    """Predicts each sample from the two before it: the time between readings and the joints' speeds hardly change.

    The usual error of the prediction is measured on the way: a device that reads its clock irregularly and a quick
    pendulum have a larger one than a quartz and a pendulum at rest.
    """

    def __init__(self) -> None:
        self.last: Sample | None = None
        self._slopes: list[float] | None = None
        """Change by the reading of time [us] and of the counts of cart, inner and outer joint."""
        self._period = math.inf
        """The shortest time between two readings of late [us]; a device may miss one."""
        self._usual = list(_LEAST)
        """How far off the samples of late were, in the same."""

    def take(self, sample: Sample) -> None:
        """Go on to the next sample of the same run of the device."""
        if self.last is not None:
            steps = steps_between(self.last, sample)
            if self._slopes is not None:
                off = self._off(sample, steps)
                self._usual = [max(error, _FORGOTTEN * usual) for error, usual in zip(off, self._usual, strict=True)]
            self._slopes = [change / steps for change in _changes(self.last, sample)]
            self._period = min(self._slopes[0], _FORGOTTEN**-1 * self._period)
        self.last = sample

    def predicts(self, sample: Sample) -> bool:
        """Tell whether a sample is where the next one, or one a few readings on, is expected.

        The second sample of a run always is: nothing is known of its speeds.
        """
        if self.last is None or self._slopes is None:
            return self.last is not None
        return self._is_near(self._off(sample, steps_between(self.last, sample)))

    def has_between(self, sample: Sample, after: Sample) -> bool:
        """Tell whether a sample lies between the last one and one after it: more is known then than before."""
        if self.last is None:
            return False
        steps, all_steps = steps_between(self.last, sample), steps_between(self.last, after)
        if not steps < all_steps:
            return False
        changes = zip(_changes(self.last, sample), _changes(self.last, after), strict=True)
        return self._is_near([abs(change - whole * steps / all_steps) for change, whole in changes])

    def _is_near(self, off: Sequence[float]) -> bool:
        limits = zip(off, _LEAST, self._usual, strict=True)
        return all(error <= max(least, _TIMES_USUAL * usual) for error, least, usual in limits)

    def has_time_for(self, sample: Sample) -> bool:
        """Tell whether so many readings fit into the time between the last sample and this one."""
        if self.last is None or self._slopes is None:
            return True
        elapsed = (sample.time_us - self.last.time_us) & UNSIGNED_32
        return elapsed >= 0.5 * steps_between(self.last, sample) * self._period

    def _off(self, sample: Sample, steps: int) -> list[float]:
        """Return how far a sample is from where it was expected, by the steps: clocks run off, accelerations add up."""
        assert self.last is not None
        assert self._slopes is not None
        powers = (steps, steps**2, steps**2, steps**2)
        changes = zip(_changes(self.last, sample), self._slopes, powers, strict=True)
        return [abs(change - slope * steps) / power for change, slope, power in changes]


def steps_between(before: Sample, after: Sample) -> int:
    """Return how many readings one sample is after another, by their sequence numbers."""
    return (after.sequence - before.sequence) & UNSIGNED_32


def _changes(before: Sample, after: Sample) -> tuple[int, int, int, int]:
    """Return the changes of time [us] and of the counts of cart, inner and outer joint, their roll-over removed."""
    return (
        (after.time_us - before.time_us) & UNSIGNED_32,
        _rolled(after.cart - before.cart),
        _rolled(after.inner - before.inner),
        _rolled(after.outer - before.outer),
    )


def _rolled(difference: int) -> int:
    return (difference + 2**31) % 2**32 - 2**31

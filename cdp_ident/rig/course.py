# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Prediction of a rig's next sample, to recognise one that is wrong."""

from collections.abc import Sequence
from operator import le

from cdp_ident.rig.records import UNSIGNED_32, Sample, signed_32

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
        self._slopes: Sequence[float] | None = None
        """Change by the reading of time [us] and of the counts of cart, inner and outer joint."""
        self._limits = [_TIMES_USUAL * least for least in _LEAST]
        """How far off a sample may be, in the same."""
        self._step: tuple[Sample, tuple[int, Sequence[float], Sequence[float] | None]] | None = None

    def take(self, sample: Sample) -> None:
        """Go on to the next sample of the same run of the device."""
        if self.last is not None:
            steps, changes, off = self._step_to(sample)
            if off is not None:
                of_each = zip(_LEAST, off, self._limits, strict=True)
                self._limits = [max(x, _TIMES_USUAL * error, _FORGOTTEN * limit) for x, error, limit in of_each]
            self._slopes = changes if steps == 1 else [change / steps for change in changes]
        self.last, self._step = sample, None

    def predicts(self, sample: Sample) -> bool:
        """Tell whether a sample is where the next one, or one a few readings on, is expected.

        The second sample of a run always is: nothing is known of its speeds.
        """
        if self.last is None:
            return False
        _, _, off = self._step_to(sample)
        return off is None or all(map(le, off, self._limits))

    def _step_to(self, sample: Sample) -> tuple[int, Sequence[float], Sequence[float] | None]:
        """Return readings and changes since the last sample, and how far off they are, None where that is not known.

        They are kept: `take` asks for what `predicts` has asked for.
        """
        assert self.last is not None
        if self._step is None or self._step[0] is not sample:
            steps, changes = steps_between(self.last, sample), _changes(self.last, sample)
            off = _off(changes, self._slopes, steps) if self._slopes else None
            self._step = (sample, (steps, changes, off))
        return self._step[1]


def steps_between(before: Sample, after: Sample) -> int:
    """Return how many readings one sample is after another, by their sequence numbers."""
    return (after.sequence - before.sequence) & UNSIGNED_32


def _changes(before: Sample, after: Sample) -> tuple[int, int, int, int]:
    """Return the changes of time [us] and of the counts of cart, inner and outer joint, their roll-over removed."""
    return (
        (after.time_us - before.time_us) & UNSIGNED_32,
        signed_32(after.cart - before.cart),
        signed_32(after.inner - before.inner),
        signed_32(after.outer - before.outer),
    )


def _off(changes: Sequence[float], slopes: Sequence[float], steps: int) -> Sequence[float]:
    """Return how far changes are from those expected, by the steps: clocks run off, accelerations add up."""
    time, *counts = [abs(change - slope * steps) for change, slope in zip(changes, slopes, strict=True)]
    return [time, *counts] if steps == 1 else [time / steps, *[count / steps**2 for count in counts]]

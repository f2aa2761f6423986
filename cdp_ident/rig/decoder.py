# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From a serial port's bytes to verified records: never raises, whatever the bytes are."""

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from operator import le

from cdp_ident.rig.protocol import (
    UNSIGNED_32,
    CartCommand,
    ChecksumError,
    Codec,
    FrameError,
    Hello,
    Record,
    Sample,
    signed_32,
)

LONGEST_FRAME = 160
"""No frame of either codec is longer [bytes]: more bytes without a delimiter are not a frame."""
_RECENT = 64
"""So many samples back, one that comes again is known as a duplicate."""
_LARGEST_LOSS = 1_000_000
"""A larger jump of the sequence number is believed only when the next sample follows it."""
_LEAST = (100.0, 4.0, 4.0, 4.0)
"""A clock that is read this late [us], and counts that flicker by so many, are never doubted."""
_TIMES_USUAL = 8.0
"""A sample is doubted where it is farther off than so many times what is usual."""
_FORGOTTEN = 0.98
"""What is usual shrinks by this from sample to sample."""


@dataclass
class Counters:
    """What has happened since the start; `/diagnostics` tells each by its name."""

    samples: int = 0
    """Samples that were passed on."""
    published: int = 0
    """Measurements made of them."""
    lost: int = 0
    """Sequence numbers that never came, those of frames dropped as bad included."""
    bad_checksum: int = 0
    """Frames whose checksum did not match."""
    malformed: int = 0
    """Stretches of bytes between delimiters that were no frame, and of the length of a frame without a delimiter."""
    duplicates: int = 0
    """Samples that came again."""
    device_resets: int = 0
    """Times that the device started anew."""
    device_overruns: int = 0
    """Samples before which the device missed a reading."""
    encoder_faults: int = 0
    """Samples dropped because the device said that an encoder is faulty."""
    impossible_jumps: int = 0
    """Samples dropped because a joint seemed to move faster than its slew limit."""
    dropped_without_greeting: int = 0
    """Samples dropped because no greeting gave the counts per turn."""
    clock_fits_begun_anew: int = 0
    """How often the mapping of the device's clock was restarted."""


@dataclass(frozen=True)
class Restart:
    """Passed on between two samples that do not belong to the same run of the device: it was reset."""


Event = Sample | Hello | Restart


class Decoder:
    """Decodes a stream of bytes, cut anywhere, into events in the order of arrival.

    A sample is passed on when its frame is intact, and sequence number, time and counts go on from the samples before
    (`Course`). One that does not waits for the next: if that goes on from the samples before, the one that waited is
    dropped, as a damaged frame whose checksum happens to match (one in 65536); if not, both are taken, and the device
    was reset where sequence number and time do not follow either.
    """

    def __init__(self, codec: Codec) -> None:
        self.counters = Counters()
        self._codec = codec
        self._rest = b""
        self._skipping = True  # the first bytes of a stream are likely the end of a frame
        self._course = Course()
        self._doubtful: Sample | None = None
        self._recent: deque[Sample] = deque(maxlen=_RECENT)

    def restart_stream(self) -> None:
        """Discard the unfinished frame: the port was opened again. The sequence goes on where it was."""
        self._rest = b""
        self._skipping = True

    def feed(self, data: bytes) -> list[Event]:
        """Take the next bytes of the stream; return what they complete."""
        return [event for record in self._records(data) for event in self._check(record)]

    def _records(self, data: bytes) -> Iterator[Record]:
        *frames, self._rest = (self._rest + data).split(self._codec.delimiter)
        for frame in frames:
            skipping, self._skipping = self._skipping, False
            if not frame:
                continue
            try:
                yield self._codec.decode(frame)
            except ChecksumError:
                self.counters.bad_checksum += not skipping
            except FrameError:
                self.counters.malformed += not skipping
        if len(self._rest) > LONGEST_FRAME:
            self.counters.malformed += len(self._rest) // LONGEST_FRAME
            self._rest = b""
            self._skipping = True

    def _check(self, record: Record) -> Iterator[Event]:
        if isinstance(record, Hello):
            yield record
        elif isinstance(record, CartCommand):
            self.counters.malformed += 1  # only the host sends these
        elif self._follows(record) and self._course.predicts(record):
            self._doubtful = None
            yield self._pass(record)
        elif record in self._recent or record == self._doubtful:
            self.counters.duplicates += 1
        elif self._doubtful is not None and _can_follow(self._doubtful, record):
            doubtful, self._doubtful = self._doubtful, None
            if not self._follows(doubtful):
                if self._course.last is not None:
                    self.counters.device_resets += 1
                    yield Restart()
                self._course = Course()
                self._recent.clear()
            yield self._pass(doubtful)
            yield self._pass(record)
        else:
            self._doubtful = record

    def _follows(self, sample: Sample) -> bool:
        """Tell whether a sample can come after the last one in the same run of the device."""
        last = self._course.last
        return last is not None and _can_follow(last, sample)

    def _pass(self, sample: Sample) -> Sample:
        self.counters.samples += 1
        if self._course.last is not None:
            self.counters.lost += steps_between(self._course.last, sample) - 1
        self._course.take(sample)
        self._recent.append(sample)
        return sample


def _can_follow(before: Sample, after: Sample) -> bool:
    """Tell whether one sample can come after another in one run of a device, with few enough lost in between."""
    elapsed = (after.time_us - before.time_us) & UNSIGNED_32
    return 1 <= steps_between(before, after) <= _LARGEST_LOSS and 0 < elapsed < 2**31


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

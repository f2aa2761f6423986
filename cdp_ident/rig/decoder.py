# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From a serial port's bytes to verified records: never raises, whatever the bytes are."""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass

from cdp_ident.rig.codec import ChecksumError, Codec, FrameError
from cdp_ident.rig.course import Course, steps_between
from cdp_ident.rig.records import UNSIGNED_32, CartCommand, Hello, Record, Sample

LONGEST_FRAME = 160
"""No frame of either codec is longer [bytes]: more bytes without a delimiter are not a frame."""
_RECENT = 64
"""So many samples back, one that comes again is known as a duplicate."""
_LARGEST_LOSS = 1_000_000
"""A larger jump of the sequence number is believed only when the next sample follows it."""


@dataclass
class Counters:
    """What happened on the line since the port was first opened."""

    samples: int = 0
    """Samples that were passed on."""
    bad_checksum: int = 0
    """Frames whose checksum did not match."""
    malformed: int = 0
    """Stretches of bytes between delimiters that were no frame, and of the length of a frame without a delimiter."""
    lost: int = 0
    """Sequence numbers that never came, those of frames dropped as bad included."""
    duplicates: int = 0
    """Samples that came again."""
    resets: int = 0
    """Times that the device started anew."""


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
                    self.counters.resets += 1
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

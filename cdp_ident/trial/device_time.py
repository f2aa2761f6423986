"""The device's own time of the samples instead of their stamps.

Stamps map the device's clock to ROS time by a running fit, whose rate changes by some parts in a million, and by much
more just after the driver's start, while the fit settles. The device's clock is even. Only its rate is unknown: it is
recorded by the driver, or estimated from a line through the stamps, once for a whole recording.
"""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cdp_ident.bag.diagnostics import ClockRate
from cdp_ident.bag.joint_recording import JointRecording

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

_SET = 20_000_000
"""Where device and stamps go on by times that differ by more than this [ns], one of the clocks was set."""
_SHORTEST = 1_000_000_000
"""A shorter run of the device's clock keeps its stamps [ns]."""
_PARTS = 4
"""The rate's uncertainty is the scatter of the rates over so many parts, as it may have drifted all the way."""
_FEWEST = 10 * _PARTS


@dataclass(frozen=True)
class _Run:
    """The samples of one run of the device's clock."""

    first: int
    last: int
    rate: ClockRate
    stamps: Indices
    """(n,) of the samples, by the device's time [ns]."""
    wander: Array
    """(n,) how far the recorded stamps are from these [s]."""


def in_device_time(recording: JointRecording) -> tuple[JointRecording, ClockRate | None, list[str]]:
    """Return a recording with stamps by the device's own time, how fast that ran, and what there is to say about it.

    Where the recording has no device's time, or less than a second of it, it is returned as it is.
    """
    if recording.device is None:
        return recording, None, []
    runs = _runs(recording)
    if not runs:
        return recording, None, []
    stamps = recording.stamps.copy()
    for run in runs:
        stamps[run.first : run.last] = run.stamps
    longest = max(runs, key=lambda run: run.last - run.first)
    wander = np.concatenate([run.wander for run in runs])
    note = (
        f"times are the device's own; its clock is {longest.rate} fast against ROS time, "
        f"{'by its driver' if recording.device.rate else 'by the stamps'}; the stamps wander from it by "
        f"{1e6 * np.sqrt(np.mean(wander**2)):.2g} us rms, {1e6 * np.max(np.abs(wander)):.2g} us at most"
    )
    return replace(recording, stamps=stamps), longest.rate, [note]


def _runs(recording: JointRecording) -> list[_Run]:
    assert recording.device is not None
    stamps, times = recording.stamps, recording.device.times
    borders = np.flatnonzero(np.abs(np.diff(times) - np.diff(stamps)) > _SET) + 1
    runs = []
    for first, last in zip([0, *borders.tolist()], [*borders.tolist(), len(stamps)], strict=True):
        if last - first >= _FEWEST and np.ptp(times[first:last]) >= _SHORTEST:
            runs.append(_run(first, last, stamps[first:last], times[first:last], recording.device.rate))
    return runs


def _run(first: int, last: int, stamps: Indices, times: Indices, given: ClockRate | None) -> _Run:
    # Differences of the integers first: a float does not resolve nanoseconds since 1970.
    device, host = (np.asarray(values - values[0], dtype=float) * 1e-9 for values in (times, stamps))
    rate = given or _rate_of_stamps(device, host)
    even = device / (1.0 + rate.fast)
    even += np.mean(host - even)
    return _Run(first, last, rate, stamps[0] + np.round(even * 1e9).astype(np.int64), host - even)


def _rate_of_stamps(device: Array, host: Array) -> ClockRate:
    parts = zip(np.array_split(device, _PARTS), np.array_split(host, _PARTS), strict=True)
    scatter = np.std([_slope(y, x) for x, y in parts], ddof=1)
    return ClockRate(_slope(host, device) - 1.0, float(scatter))


def _slope(host: Array, device: Array) -> float:
    """Return the device's time in a second of the host's, by least squares."""
    host, device = host - host.mean(), device - device.mean()
    return float(device @ device / (host @ device))

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The device's own time of the samples instead of their stamps.

Stamps map the device's clock to ROS time by a running fit, whose rate changes by some parts in a million, and by much
more just after the driver's start, while the fit settles. The device's clock is even. Only its rate is unknown: it is
recorded by the driver, or estimated from a line through the stamps, once for a whole recording.
"""

from dataclasses import replace

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.bag.device_messages import ClockRate
from cdp_ident.bag.joint_recording import JointRecording

_SET = 20_000_000
"""Where device and stamps go on by times that differ by more than this [ns], one of the clocks was set."""
_SHORTEST = 1_000_000_000
"""A shorter run of the device's clock keeps its stamps [ns]."""
_PARTS = 4
"""The rate's uncertainty is the scatter of the rates over so many parts, as it may have drifted all the way."""
_FEWEST = 10 * _PARTS


def in_device_time(recording: JointRecording) -> tuple[JointRecording, ClockRate | None, list[str]]:
    """Return a recording with stamps by the device's own time, how fast that ran, and what there is to say about it.

    Where the recording has no device's time, or less than a second of it, it is returned as it is.
    """
    device, recorded = recording.device, recording.stamps
    if device is None:
        return recording, None, []
    set_apart = np.flatnonzero(np.abs(np.diff(device) - np.diff(recorded)) > _SET) + 1
    parts = np.split(np.arange(len(recorded)), set_apart)
    runs = [run for run in parts if len(run) >= _FEWEST and np.ptp(device[run]) >= _SHORTEST]
    if not runs:
        return recording, None, []
    stamps, wander = recorded.copy(), []
    rates = []
    for run in runs:
        # Differences of the integers first: a float does not resolve nanoseconds since 1970.
        ticks, host = ((values[run] - values[run[0]]) * 1e-9 for values in (device, recorded))
        rates.append(recording.device_rate or _rate_of_stamps(ticks, host))
        even = ticks / (1.0 + rates[-1].fast)
        even += np.mean(host - even)
        stamps[run] = recorded[run[0]] + np.round(even * 1e9).astype(np.int64)
        wander.append(host - even)
    _, rate = max(zip(map(len, runs), rates, strict=True), key=lambda run: run[0])
    away = np.concatenate(wander)
    note = (
        f"times are the device's own; its clock is {rate} fast against ROS time, "
        f"{'by its driver' if recording.device_rate else 'by the stamps'}; the stamps wander from it by "
        f"{1e6 * np.sqrt(np.mean(away**2)):.2g} us rms, {1e6 * np.max(np.abs(away)):.2g} us at most"
    )
    return replace(recording, stamps=stamps), rate, [note]


def _rate_of_stamps(device: Array, host: Array) -> ClockRate:
    parts = zip(np.array_split(device, _PARTS), np.array_split(host, _PARTS), strict=True)
    whole, *of_parts = (1.0 / np.polyfit(*of, 1)[0] for of in ((device, host), *parts))
    return ClockRate(float(whole) - 1.0, float(np.std(of_parts, ddof=1)))

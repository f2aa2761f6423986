# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""When samples were measured: by their stamps, by the times of receipt or by the device's own clock.

A stamp may hold milliseconds where nanoseconds belong, or be the same for all: of stamps and times of receipt, the
motion is smooth in those in which it was measured.

Stamps map the device's clock to ROS time by a running fit, whose rate changes by some parts in a million, and by much
more just after the driver's start, while the fit settles. The device's clock is even. Only its rate is unknown: it is
recorded by the driver, or estimated from a line through the stamps, once for a whole recording.
"""

from dataclasses import replace

import numpy as np

from cdp_ident.arrays import Array, Indices
from cdp_ident.bag.device_messages import ClockRate
from cdp_ident.bag.joint_recording import JointRecording
from cdp_ident.trial.bursts import FEWEST, LONGEST_WAIT, NEAR, SMOOTHER
from cdp_ident.trial.kinematics import roughness
from cdp_ident.trial.options import TrialOptions
from cdp_ident.trial.order import counted_on, elapsed, in_order, without_jitter

_GAP = 5.0
"""Steps of so many times the usual one are gaps."""
_RATE = 0.02
"""Share by which durations by stamps and by receipt may differ, and beside it the rounding of stamps to seconds."""
_OTHER_PACE = 0.05
"""Share from which it is said."""
_SECOND = 1_000_000_000
_SHORTEST_STEP, _LONGEST_STEP = 1e-5, 0.5
"""Samples that are nearer or farther apart [s] show no swing."""
_SET = 20_000_000
"""Where device and stamps go on by times that differ by more than this [ns], one of the clocks was set."""
_SHORTEST = 1_000_000_000
"""A shorter run of the device's clock keeps its stamps [ns]."""
_PARTS = 4
"""The rate's uncertainty is the scatter of the rates over so many parts, as it may have drifted all the way."""
_FEWEST_OF_RUN = 10 * _PARTS


def in_measured_time(recording: JointRecording, options: TrialOptions) -> JointRecording:
    """Return a recording whose stamps are the times of its samples, as `options.time` says, and what was done.

    By itself the time of receipt is taken only where stamps are missing, or the motion is far smoother by receipt.
    """
    times, counter = counted_on(recording.stamps.astype(float))
    if counter:
        note = f"the stamps are {counter}: they are counted on where it rolls over"
        recording = replace(recording, stamps=times.astype(np.int64), notes=(*recording.notes, note))
    known = np.isfinite(recording.positions)
    ascending, jitter = without_jitter(recording.stamps, known @ 2.0 ** np.arange(known.shape[1]))
    if jitter:
        recording = replace(recording, stamps=ascending, notes=(*recording.notes, jitter))
    stamps, receipts = recording.stamps, recording.receipts
    if receipts is None or not len(stamps):
        return recording
    stamped = np.flatnonzero(stamps > 0)
    lacking = len(stamps) - len(stamped)
    fault = "are missing" if 2 * lacking > len(stamps) else _fault(recording[stamped], options)
    if options.time == "receipt" or (options.time == "auto" and fault):
        why = f"the stamps {fault}: " if fault else ""
        notes = (*recording.notes, f"{why}the time of receipt is used, with its jitter{_jitter(receipts)}")
        return replace(recording, stamps=receipts, device=None, notes=notes)
    said = [
        f"{lacking} messages without a stamp are dropped" if lacking else "",
        _pace(stamps[stamped], receipts[stamped]),
    ]
    return replace(recording[stamped] if lacking else recording, notes=(*recording.notes, *filter(None, said)))


def _jitter(times: Indices) -> str:
    """Return by how much times (n,) [ns] vary about even ones, by the steps between them; empty if that is unknown."""
    steps = 1e-9 * np.diff(times)
    steps = steps[(steps > 0.0) & (steps < _GAP * np.median(steps))] if len(steps) else steps
    return f" of {1e3 * np.std(steps) / np.sqrt(2.0):.2g} ms" if len(steps) >= FEWEST else ""


def _fault(recording: JointRecording, options: TrialOptions) -> str:
    """Say what is wrong with stamps by which the motion is far rougher than by receipt; empty if nothing is."""
    stamps, receipts = recording.stamps, recording.receipts
    assert receipts is not None
    if len(stamps) < FEWEST:
        return ""
    steps, received = (1e-9 * np.diff(np.sort(times)) for times in (stamps, receipts))
    too = "long" if np.median(steps) > _LONGEST_STEP else "short" if 0.0 < np.mean(steps) < _SHORTEST_STEP else ""
    if too and _SHORTEST_STEP <= np.mean(received) <= _LONGEST_STEP:
        return f"are {np.mean(steps):.3g} s apart, which is too {too} for a swing"
    if np.mean(received) < _SHORTEST_STEP:  # written at once, by a converter
        return ""
    joints = [recording.joints.index(j) for j in (options.inner_joint, options.outer_joint) if j in recording.joints]
    by_stamp, by_receipt = (_columns(times, recording.positions[:, joints]) for times in (stamps, receipts))
    of_both = (*by_stamp, *by_receipt)
    spacing = max((float(np.mean(np.diff(time))) for time, _ in of_both if len(time) > 1), default=0.0)
    rough = [
        max((roughness(*of, NEAR * spacing) for of in columns), default=np.inf) for columns in (by_stamp, by_receipt)
    ]
    lasts = [elapsed(times)[-1] for times in (np.sort(stamps), receipts)]
    is_other = np.isfinite(rough[0]) and abs(lasts[0] - lasts[1]) > 1.0 + _RATE * lasts[1]
    if is_other or not rough[1] < SMOOTHER * rough[0]:
        return ""
    largest = int(np.max(stamps % _SECOND))
    if largest == 0:
        return "are whole seconds"
    if largest < 1_000_000:
        return f"hold {'milli' if largest < 1000 else 'micro'}seconds where nanoseconds belong"
    return "are not the times of the samples, as the motion is smoother by receipt"


def _columns(stamps: Indices, readings: Array) -> list[tuple[Array, Array]]:
    """Return times (m,) and values (m, 1) of joints' readings (n, k) with stamps in any order [ns]; gaps are closed."""
    order, _ = in_order(stamps)
    time, found = elapsed(stamps[order]), []
    time = np.cumsum(np.minimum(np.diff(time, prepend=time[:1]), LONGEST_WAIT))
    for column in readings[order].T:
        known = np.isfinite(column)
        once, first = np.unique(time[known], return_index=True)
        found.append((once, column[known][first, None]))
    return found


def _pace(stamps: Indices, receipts: Indices) -> str:
    """Say that samples come evenly in another time by their stamps than by receipt; empty if they do not."""
    if len(stamps) < FEWEST:
        return ""
    steps = [1e-9 * np.diff(times) for times in (stamps, receipts)]
    usual, whole = ([float(of(step)) for step in steps] for of in (np.median, np.sum))
    if min(*usual, *whole) < _SHORTEST_STEP or max(usual) < (1.0 + _OTHER_PACE) * min(usual):
        return ""
    is_even = abs(usual[0] / usual[1] * whole[1] / whole[0] - 1.0) < _OTHER_PACE
    by = " but ".join(f"{1e3 * step:.3g} ms by {how}" for step, how in zip(usual, ("stamps", "receipt"), strict=True))
    return f"samples are {by} apart (played back at another rate?): time: receipt takes the latter" if is_even else ""


def in_device_time(recording: JointRecording) -> JointRecording:
    """Return a recording with stamps by the device's own time, how fast that ran, and what there is to say about it.

    Where the recording has no device's time, or less than a second of it, it keeps its stamps, and has no rate.
    """
    device, recorded = recording.device, recording.stamps
    if device is None:
        return replace(recording, device_rate=None)
    set_apart = np.flatnonzero(np.abs(np.diff(device) - np.diff(recorded)) > _SET) + 1
    parts = np.split(np.arange(len(recorded)), set_apart)
    runs = [run for run in parts if len(run) >= _FEWEST_OF_RUN and np.ptp(device[run]) >= _SHORTEST]
    if not runs:
        return replace(recording, device_rate=None)
    stamps, wander, rates = recorded.copy(), [], []
    for run in runs:
        # Differences of the integers first: a float does not resolve nanoseconds since 1970.
        ticks, host = ((values[run] - values[run[0]]) * 1e-9 for values in (device, recorded))
        rates.append(recording.device_rate or _rate_of_stamps(ticks, host))
        even = ticks / (1.0 + rates[-1].fast)
        even += np.mean(host - even)
        stamps[run] = recorded[run[0]] + np.round(even * 1e9).astype(np.int64)
        wander.append(host - even)
    rate = rates[int(np.argmax([len(run) for run in runs]))]
    away = np.concatenate(wander)
    note = (
        f"times are the device's own; its clock is {rate} fast against ROS time, "
        f"{'by its driver' if recording.device_rate else 'by the stamps'}; the stamps wander from it by "
        f"{1e6 * np.sqrt(np.mean(away**2)):.2g} us rms, {1e6 * np.max(np.abs(away)):.2g} us at most"
    )
    return replace(recording, stamps=stamps, device_rate=rate, notes=(*recording.notes, note))


def _rate_of_stamps(device: Array, host: Array) -> ClockRate:
    parts = zip(np.array_split(device, _PARTS), np.array_split(host, _PARTS), strict=True)
    whole, *of_parts = (1.0 / np.polyfit(*of, 1)[0] for of in ((device, host), *parts))
    return ClockRate(float(whole) - 1.0, float(np.std(of_parts, ddof=1)))

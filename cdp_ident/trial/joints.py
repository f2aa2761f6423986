# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From a bag's joints to the model's: which column is which, and the conventions of the numbers."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

from cdp_ident.arrays import Array, Indices, Mask, Rows, Times
from cdp_ident.bag.joint_recording import JointRecording
from cdp_ident.errors import TrialError
from cdp_ident.outside_text import shown
from cdp_ident.trial.clock import measured_times
from cdp_ident.trial.options import UNITS, TrialOptions
from cdp_ident.trial.order import elapsed, in_order, recorded_again
from cdp_ident.trial.outliers import TURN, outlier_words, outliers
from cdp_ident.trial.readings import check_publishers, continuous, new_readings, said_again, still_publisher

_WHOLE = np.empty(0, dtype=np.int64)
_BELIEVED = 1e10
"""Largest position [rad or m] that is accepted as a measurement."""
_TOGETHER = 0.9
"""Share of the readings of a joint that have one of the other beside them, up to which joints are measured together."""
_BRIDGED = 3.5
"""No reading is made up in a gap of so many usual spacings."""
_OFTEN = 10
"""A number that stands for missing readings is stored so often at least: what is rarer is left out as an outlier."""


@dataclass(frozen=True)
class Samples(Rows):
    """The samples of the joints that matter, as recorded."""

    stamps: Times
    """(n,) time of each sample [ns since the epoch]."""
    angles: Array
    """(n, 2) positions of the inner and outer joint, in the unit of each."""
    cart: Array | None
    """(n,) position of the cart [m]."""
    torques: Array | None = None
    """(n, 2) torque of a motor in each joint, as measured or commanded; None where none is known."""
    ranges: tuple[float, ...] = (0.0, 0.0)
    """Of counters of a few bits, which angles are known up to; 0 for a joint that has none [its unit]."""
    turns: tuple[float, ...] = (TURN, TURN)
    """By how much each joint's readings change in a full turn [its unit]."""
    pace_std: float = 0.0
    """How sure the pace of their times is: its standard deviation, as a share."""

    @property
    def unwrapped(self) -> Array:
        """(n, 2) the angles, without what looks like full turns from one sample to the next."""
        joints = zip(self.angles.T, self.turns, strict=True)
        return np.column_stack([np.unwrap(angle, period=turn) for angle, turn in joints])


@dataclass(frozen=True)
class Piece(Rows):
    """Samples at known times, in the end a stretch without a gap in which full turns could be lost."""

    samples: Samples
    """As recorded, at strictly increasing stamps, except where the clock was set back; angles of a stretch are
    continuous."""
    time: Array
    """(n,) since the recording's first sample [s]; where the clock was set back, it stands still for one sample."""


def select_joints(recording: JointRecording, options: TrialOptions) -> tuple[Samples, list[str]]:
    """Pick the joints that the options name, at common times and in the order of time.

    Samples without a usable number, repetitions of a reading in motion, and a second publisher that never moves are
    left out. Returns the samples and what there is to say about them. Raises TrialError where a joint is missing.
    """
    wanted = [options.inner_joint, options.outer_joint]
    if missing := [joint for joint in wanted if joint not in recording.joints]:
        there = ", ".join(map(shown, recording.joints)) or "no joint at all"
        raise TrialError(
            f"topic {shown(recording.topic)} has no joint {' and no joint '.join(missing)}; it has {there}: "
            "name the joints by inner_joint and outer_joint"
        )
    again = recorded_again(recording.stamps, recording.positions)
    recording = recording[~again]
    columns = [recording.joints.index(joint) for joint in wanted]
    whole = np.flatnonzero(_usable(recording.positions[:, columns]).all(axis=1))
    of_another, of_which = still_publisher(recording.positions[whole][:, columns], recording.stamps[whole])
    recording = recording[np.delete(np.arange(len(recording.stamps)), whole[of_another])]
    order, notes = in_order(recording.stamps, np.isfinite(recording.positions[:, columns]))
    notes.append(of_which)
    if np.any(again):
        notes.append(f"{np.count_nonzero(again)} samples that are recorded twice count once")
    whole = np.flatnonzero(_usable(recording.positions[order][:, columns]).all(axis=1))
    later, of_relay = said_again(recording.positions[order[whole]][:, columns])
    order = np.delete(order, whole[later])
    notes.append(of_relay)
    stamps, positions = recording.stamps[order], recording.positions[order]
    time = elapsed(stamps)
    readings = positions[:, columns]
    known = _usable(readings)
    both = np.flatnonzero(known.all(axis=1))
    lacking = len(known) - len(both)
    for joint, column, has in zip(wanted, readings.T, known.T, strict=True):
        for number in _in_place_of_none(column[has]):
            of_none = has & (column == number)
            has[of_none] = False
            count = np.count_nonzero(of_none)
            notes.append(f"{count} readings of {joint} that are {number:g} stand for missing ones, and are left out")
    ranges = np.zeros(2)
    turns = TURN * np.array([options.inner_scale, options.outer_scale]) / in_radians(np.ones(2), options)
    new, repeated = new_readings(readings, known, turns)
    for place, (joint, column, has) in enumerate(zip(wanted, readings.T, known.T, strict=True)):
        column[has], ranges[place], wrapped = continuous(column[has])
        notes += [f"readings of {joint} {what}" for what in (repeated[place], wrapped) if what]
    rows, at, angles, said, pace_std = _at_common_times(time, readings, new, turns, bool(np.all(np.diff(stamps) >= 0)))
    notes += said
    if lacking and not said:
        notes.append(f"{lacking} of {len(known)} samples have no usable number for both rods and are dropped")
    if not len(rows):
        raise TrialError(
            f"no sample of {recording.topic} has a usable number for both {' and '.join(wanted)}: {lacking} of "
            f"{len(known)} lack one"
        )
    check_publishers(angles, at, recording.topic)
    cart: Array | None = None
    if options.cart_joint in recording.joints:
        # A cart published in messages of its own is taken at the times of the rods' samples.
        position = positions[:, recording.joints.index(options.cart_joint)]
        times, position, outlying = _measured(time, position, _usable(position))
        if len(outlying):
            notes.append(f"of the cart's position {outlier_words(outlying.tolist(), len(times))}")
        cart = np.interp(at, times, position) if len(times) else None
    elif options.cart_joint:
        notes.append(f"there is no joint {options.cart_joint}: the cart is taken to be at rest")
    torques: Array = np.zeros((len(rows), 2))
    if recording.efforts is not None:
        for torque, effort in zip(torques.T, recording.efforts[order][:, columns].T, strict=True):
            if np.any(has := _usable(effort)):
                torque[:] = np.interp(at, time[has], effort[has])
    stamps = stamps[rows] + np.round(1e9 * (at - time[rows])).astype(np.int64)
    found = Samples(stamps, angles, cart, torques if np.any(torques) else None, tuple(ranges), tuple(turns), pace_std)
    return found, [note for note in notes if note]


def _at_common_times(
    time: Array, readings: Array, known: Mask, turns: Array, goes_on: bool
) -> tuple[Indices, Array, Array, list[str], float]:
    """Return the rows in which both joints have a reading, times and readings (m, 2) there, and in words how they have.

    Where most rows lack one joint, the readings of the joint that is measured more often are taken at the times of the
    other, by a cubic spline. The rows are at `time` (n,), ascending [s]; `known` (n, 2) are the readings, which change
    by `turns` (2,) in a full turn. Each joint has even times of its own where time `goes_on`, and where it was read so.
    The last value is how sure the pace of these is, as a share.
    """
    both = np.flatnonzero(known.all(axis=1))
    counts = np.count_nonzero(known, axis=0)
    together = both, time[both], readings[both], list[str](), 0.0
    if len(both) >= _TOGETHER * counts.max():
        return together
    slow = int(np.argmin(counts))
    rows = np.flatnonzero(known[:, slow])
    at = time[rows]
    times, values, _ = _measured(time, readings[:, 1 - slow], known[:, 1 - slow], turns[1 - slow])
    notes, pace_stds = list[str](), [0.0]
    if goes_on:
        at, said, pace_std = measured_times(at, readings[rows, slow, None] * TURN / turns[slow], _WHOLE)
        times, more, other_std = measured_times(times, values[:, None] * TURN / turns[1 - slow], _WHOLE)
        notes, pace_stds = [*said, *more], [pace_std, other_std]
    if not notes and len(both) >= _TOGETHER * counts.min():
        return together
    there, between = _between(times, values, at)
    found = readings[rows[there]]
    found[:, 1 - slow] = between[there]
    joint = ("inner", "outer")[1 - slow]
    apart = f"joints are measured at times of their own: the {joint} one is taken at the times of the other"
    lost = np.count_nonzero(~there)
    notes.append(f"{apart}; {lost} samples without it nearby are dropped" if lost else apart)
    return rows[there], at[there], found, notes, max(pace_stds)


def _measured(time: Array, values: Array, known: Mask, turn: float | None = None) -> tuple[Array, Array, Array]:
    """Return times (m,), each once, and the known ones of values (n,) then without outliers, and the times of these."""
    times, first = np.unique(time[known], return_index=True)
    values = values[known][first]
    values = np.asarray(np.unwrap(values, period=turn)) if turn else values
    outlying = outliers(times, values, turn)
    return times[~outlying], values[~outlying], times[outlying]


def _between(times: Array, values: Array, at: Array) -> tuple[Mask, Array]:
    """Return at which of some times there are values nearby, and the values there (those elsewhere mean nothing)."""
    if len(times) < 4:
        return np.zeros(len(at), dtype=bool), np.zeros(len(at))
    place = np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 2)
    before, after = times[place], times[place + 1]
    step = np.median(np.diff(times))
    bridged = (at >= before) & (at <= after) & (after - before <= _BRIDGED * step)
    there = bridged | (np.minimum(np.abs(at - before), np.abs(at - after)) <= step / 2)
    return there, np.asarray(CubicSpline(times, values)(at))


def in_angles(samples: Samples, options: TrialOptions) -> Samples:
    """Return samples in radians."""
    ranges = in_radians(np.array(samples.ranges), options)
    turns = TURN * options.inner_scale, TURN * options.outer_scale
    return replace(samples, angles=in_radians(samples.angles, options), ranges=tuple(ranges), turns=turns)


def in_radians(readings: Array, options: TrialOptions) -> Array:
    """Return readings of the inner and outer joint (..., 2) in radians."""
    return np.asarray(readings * [UNITS[options.inner_unit], UNITS[options.outer_unit]])


def model_angles(angles: Array, options: TrialOptions) -> Array:
    """Return theta1, theta2 (n, 2) [rad] of the continuous angles of the inner and outer joint (n, 2) [rad]."""
    scales = np.array([options.inner_scale, options.outer_scale])
    offset = np.pi if options.zero == "hanging" else 0.0
    right_at = np.pi if options.scale_from == "hanging" else offset
    theta1, turned = (angles * [options.inner_sign, options.outer_sign] / scales).T
    from_inner, from_outer = right_at + (offset - right_at) / scales
    theta1 = theta1 + from_inner + options.inner_offset
    theta2 = turned + (theta1 if options.outer_angle == "relative" else from_outer) + options.outer_offset
    return np.column_stack([theta1, theta2])


def _in_place_of_none(readings: Array) -> list[float]:
    """Return numbers that stand for missing readings (n,): each is stored often, far from all others.

    It is as far from the others as these are from one another.
    """
    numbers, counts = np.unique(readings, return_counts=True)
    found = list[float]()
    for extreme in (0, -1) if len(numbers) > _OFTEN else ():
        others = np.delete(numbers, extreme)
        if counts[extreme] >= _OFTEN and np.min(np.abs(numbers[extreme] - others)) > np.ptp(others):
            found.append(float(numbers[extreme]))
    return found


def _usable(values: Array) -> Mask:
    with np.errstate(invalid="ignore"):
        return np.abs(values) <= _BELIEVED

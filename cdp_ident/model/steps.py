# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A motion, step by step, with its derivatives and what encoders show of it (compiled).

A step is divided where a joint with dry friction stops or breaks loose and where a state reaches its limit
(`sticking`), and where its error would be too large (`roughness`).
"""

import math
from functools import cache
from typing import NamedTuple

import numpy as np
from numba import float64, int64, void

from cdp_ident.arrays import Array, Indices
from cdp_ident.machine.compilation import (
    INDICES,
    NUMBERS,
    call,
    call_for_number,
    compiled,
    compiled_at,
    inlined,
    part,
    place,
)
from cdp_ident.model import layout as at
from cdp_ident.model.layout import unfolded
from cdp_ident.model.rates import STICKS, copy, fill_rates
from cdp_ident.model.readings import added_by_laws, lateness, read_encoder, read_state
from cdp_ident.model.runge_kutta import accept, address_of_advance, input_at, step_on, stop
from cdp_ident.model.sticking import AT_ONCE, instant_of, is_at_limit, make_part, settle

_MOST_PARTS = 4096
"""A step that needs more parts, of 1/256 or up to an event, has a motion that cannot be computed: it is given up. So
has an encoder that is late by as many steps."""
FASTEST = math.pi
"""No step resolves a rod that turns by more than this within it [rad]: such a motion is given up."""
_SLIGHTLY = 1e-3
"""Instants so far apart tell how fast the cart's acceleration changes, in steps."""
_ROUNDING = 1e-9
"""A sample at the end of a step, give or take rounding, belongs to that step."""

_MEMORY = INDICES, NUMBERS, NUMBERS
_PARTS = (
    (fill_rates, void(*_MEMORY, int64, float64, float64, int64, int64)),
    (step_on, void(*_MEMORY, float64, float64, float64, float64, int64, int64)),
    (settle, void(*_MEMORY, float64, float64, int64, int64)),
    (instant_of, float64(*_MEMORY, float64, float64, float64, float64, int64)),
    (make_part, float64(*_MEMORY, float64, float64, float64)),
    (read_encoder, float64(*_MEMORY, int64, float64, float64, float64, float64, float64, NUMBERS)),
)
"""What others call by its address, with its signature, in the order of a plan: first come plan, what gives the motion
(see `layout.VALUES`) and room."""


@cache
def addresses(states: int) -> tuple[int, ...]:
    """Return where compiled code is that others call, in the order of a plan, for states of so many numbers."""
    return *(compiled_at(*each) for each in _PARTS), address_of_advance(states)


class Times(NamedTuple):
    """When some motions are computed and read, end to end."""

    begin: Array
    """(motions,) time in the trial at the beginning [s]."""
    step: Array
    """(motions,) length of the steps [s]."""
    steps_at: Indices
    """(motions + 1,) where the steps of each begin among those of all."""
    samples_at: Indices
    """(motions + 1,) where the samples of each begin among those of all."""
    place: Array
    """(samples,) when each sample is taken, in steps from the beginning of its motion."""
    u: Array
    """(2 steps + motions,) the cart's acceleration at the beginnings and middles of steps, and at the end [m/s^2]."""
    drive: Array
    """(2 steps + motions, 2) the motors' torques in both joints then [N m]; (0, 2) where there are none."""


@compiled
def compute(plan, given, starts, times, room, results):
    """Compute motions one after the other, from what gives each (motions, 9 + parameters) and a start (motions, n).

    Of the results, samples are left as they are from where on they cannot be computed.
    """
    next_ones = np.zeros(3, dtype=np.int64)
    laws, work = unfolded(place(plan, 0), place(room, 0))
    for m in range(len(starts)):
        motion, memory = place(given, m * given.shape[1]), (place(plan, 0), place(room, 0))
        late = _begin(memory, laws, motion, work, starts[m], times, m, next_ones, results)
        first, last = times.steps_at[m], times.steps_at[m + 1]
        reached = max(abs(late[0]), abs(late[1])) < _MOST_PARTS and _make_steps(
            memory, laws, motion, work, times, m, (first, last), late, next_ones, results
        )
        for r in range(starts.shape[1]):
            results.ends[m, r] = work.states[at.BEGIN, r] if reached else np.nan
            for d in range(np.uint64(work.directions)):
                results.ends_by[m, r, d] = work.slopes[r, at.OLD, d]
        if reached and len(results.readings) > 0 and min(next_ones[0], next_ones[1]) < times.samples_at[m + 1]:
            # Up to what the earliest encoder shows of the last sample.
            further = last + math.ceil(-min(late[0], late[1])) + 1
            _make_steps(memory, laws, motion, work, times, m, (last, further), late, next_ones, results)


@part
def _begin(memory, laws, motion, work, start, times, m, next_ones, results):
    """Begin a motion, read it before that where encoders are late, and return how late each is, in steps."""
    for k in range(3):
        next_ones[k] = times.samples_at[m]
    _put_start(laws, work, start)
    if len(laws.table) == 0:
        return 0.0, 0.0
    step = times.step[m]
    late = lateness(laws, motion, work, 0) / step, lateness(laws, motion, work, 1) / step
    if 0.0 < max(late[0], late[1]) < _MOST_PARTS and len(results.readings) > 0:
        _read_before(memory, motion, work, times, m, late, next_ones, results)
        _put_start(laws, work, start)
    return late


@inlined
def _put_start(laws, work, start):
    """Set the state, joints slipping forwards, and its derivatives by itself."""
    for r in range(len(start)):
        work.states[at.BEGIN, r] = start[r]
        for d in range(np.uint64(work.directions)):
            work.slopes[r, at.OLD, d] = 1.0 if r == d else 0.0
    begin_modes(laws, work)


@part
def _read_before(memory, motion, work, times, m, late, next_ones, results):
    """Read a motion before its beginning, joints slipping or sticking as they do there.

    The laws' own states are held: backwards they may grow fast.
    """
    (plan, room), step, farthest = memory, times.step[m], max(late[0], late[1])
    for back in range(1, math.ceil(farthest) + 1):
        _fill_step(work, times, m, times.steps_at[m] - back)
        begin = work.numbers[at.STEP_BEGIN]
        if back == 1:
            call(plan[at.SETTLE], (plan, motion, room, times.begin[m], input_at(work, 1.0), at.NO_EVENT, at.NO_EVENT))
            for r in range(at.RODS_STATES, work.states.shape[1]):
                work.modes[at.MODE, 2 + r] = 1
        call(plan[at.STEP_ON], (plan, motion, room, begin, step, 1.0, -1.0, at.END, int(work.directions > 0)))
        if work.directions > 0:
            call(plan[at.ADVANCE], (place(work.slopes, 0), -step, plan[at.DIRECTIONS]))
        for joint in range(2):
            for j in range(times.samples_at[m], times.samples_at[m + 1]):
                when = times.place[j] - late[joint] + back
                if when >= 1.0:
                    break
                if when >= -_ROUNDING:
                    _read_sample(memory, motion, work, joint, j, 1.0, -1.0, when, step, results)
                    next_ones[joint] = max(next_ones[joint], j + 1)
        accept(work)


@part
def _fill_step(work, times, m, k):
    """Fill in when a step begins, and the cart's acceleration and the motors' torques at its beginning, middle and end.

    Before the motion's first step and after its last one they go on evenly.
    """
    step = times.step[m]
    given = min(max(k, times.steps_at[m]), times.steps_at[m + 1] - 1)
    work.numbers[at.STEP_BEGIN] = times.begin[m] + (k - times.steps_at[m]) * step
    work.numbers[at.PER_STEP] = 1.0 / step if len(times.drive) > 0 else 0.0
    for half in range(3):
        work.numbers[at.CART_INPUTS + half] = times.u[2 * given + m + half]
        for joint in range(2 if len(times.drive) > 0 else 0):
            work.numbers[at.DRIVES + 3 * joint + half] = times.drive[2 * given + m + half, joint]
    for first in range(at.CART_INPUTS, at.DRIVES + 6 if k != given else 0, 3):
        begin, middle, end = work.numbers[first], work.numbers[first + 1], work.numbers[first + 2]
        slope = 4.0 * middle - 3.0 * begin - end if k < given else begin - 4.0 * middle + 3.0 * end
        for half in range(3):
            away = k - given + 0.5 * half - (0.0 if k < given else 1.0)
            work.numbers[first + half] = (begin if k < given else end) + away * slope


@part
def _make_steps(memory, laws, motion, work, times, m, steps, late, next_ones, results):
    """Make steps of a motion, from the first one to before the last, and return whether their end is reached.

    Samples up to `next_ones` are filled in.
    """
    (plan, room), n, step = memory, work.states.shape[1], times.step[m]
    state = work.states[at.BEGIN]
    loose, crossed, fresh = at.NO_EVENT, at.NO_EVENT, True
    for k in range(steps[0], steps[1]):
        if max(abs(state[2]), abs(state[3])) * step > FASTEST:
            return False
        _fill_step(work, times, m, k)
        work.numbers[at.LONGEST] = 1.0
        begin, done, work.modes[at.PROGRESS, at.EVENTS] = work.numbers[at.STEP_BEGIN], 0.0, 0
        for parts in range(_MOST_PARTS + 1):
            if done >= 1.0:
                break
            if parts == _MOST_PARTS:
                return False
            if fresh:
                # At the beginning, and after a mode has ended.
                t, u = begin + done * step, input_at(work, done)
                call(plan[at.SETTLE], (plan, motion, room, t, u, loose, crossed))
                fresh, loose, crossed = False, at.NO_EVENT, at.NO_EVENT
            share = call_for_number(plan[at.MAKE_PART], (plan, motion, room, begin, step, done))
            stopped = work.modes[at.PROGRESS, at.STOPPED]
            reached = done + share if done + share <= 1.0 - AT_ONCE else 1.0
            _read(memory, motion, work, times, m, k - times.steps_at[m], (done, reached), late, next_ones, results)
            if stopped >= 0:
                copy(work.states[at.RATES_AT + 4], work.states[at.TRIAL])
            accept(work)
            if 0 <= stopped < 2:
                fresh = True
                if work.modes[at.MODE, stopped] == STICKS:
                    loose = stopped
                else:
                    stop(state, stopped)
                    # A joint that sticks goes on doing so, whatever the other one does.
                    if work.modes[at.MODE, 1 - stopped] == STICKS:
                        stop(state, 1 - stopped)
                    crossed = stopped
            for r in range(at.RODS_STATES, n):
                fresh = fresh or (work.modes[at.MODE, 2 + r] == 0 and is_at_limit(laws, state, r))
            done = reached
    return True


@part
def _read(memory, motion, work, times, m, k, part_of_step, late, next_ones, results):
    """Read the motion at all samples in a part of a step, between two shares of it."""
    done, reached = part_of_step
    step, last = times.step[m], k == times.steps_at[m + 1] - times.steps_at[m] - 1
    end, share = times.samples_at[m + 1], reached - done
    for joint in range(2 if len(results.readings) > 0 else 0):
        while next_ones[joint] < end:
            when = times.place[next_ones[joint]] - late[joint] - k
            if when > reached + _ROUNDING:
                break
            _read_sample(memory, motion, work, joint, next_ones[joint], done, share, when, step, results)
            next_ones[joint] += 1
    while len(results.states) > 0 and next_ones[2] < end:
        when = times.place[next_ones[2]] - k
        if when > reached + _ROUNDING and not (last and reached == 1.0):
            break
        read_state(work, (when - done) / share, share * step, len(work.states[at.READ]))
        copy(work.states[at.READ], results.states[next_ones[2]])
        for r in range(results.by.shape[1] if work.directions > 0 else 0):
            copy(work.slopes[r, at.AT_READING], results.by[next_ones[2], r])
        next_ones[2] += 1


@part
def _read_sample(memory, motion, work, joint, j, done, share, when, step, results):
    """Read a sample of a joint in a part of a step, from `done` on, that is made; `when` is its place in the step."""
    plan, room = memory
    u = input_at(work, when)
    u_rate = (input_at(work, when + _SLIGHTLY) - u) / (_SLIGHTLY * step)
    t, by = work.numbers[at.STEP_BEGIN] + when * step, place(results.by, (2 * j + joint) * results.by.shape[2])
    there = (joint, (when - done) / share, share * step, t, u, u_rate)
    results.readings[j, joint] = call_for_number(plan[at.READ_ENCODER], (plan, motion, room, *there, by))


@part
def begin_modes(laws, work):
    """Let joints slip forwards, and no state be held."""
    for mode in range(work.modes.shape[1]):
        work.modes[at.MODE, mode], work.modes[at.IS_TURNED, mode] = 1 if mode < 2 else 0, 0
    for law in range(len(laws.table)):
        if laws.table[law, at.TURNS]:
            work.modes[at.IS_TURNED, laws.table[law, at.JOINT]] = 1


@compiled
def fill_each_rate(plan, motion, room, states, times, u, rates, jacobians):
    """Fill in the rates (k, n) of states (k, n) at times (k,) and the cart's accelerations (k,).

    Joints slip the way they turn; one at rest that has dry friction sticks where it can. But where the accelerations'
    derivatives (k, 2, n) are wanted, too, joints slip forwards.
    """
    memory = place(plan, 0), place(motion, 0), place(room, 0)
    laws, work = unfolded(memory[0], memory[2])
    for j in range(len(states)):
        copy(states[j], work.states[at.BEGIN])
        begin_modes(laws, work)
        if len(jacobians) > 0:
            call(plan[at.FILL_RATES], (*memory, at.BEGIN, times[j], u[j], 0, 1))
            copy(work.slopes[2, at.RATES_BY], jacobians[j, 0])
            copy(work.slopes[3, at.RATES_BY], jacobians[j, 1])
        else:
            call(plan[at.SETTLE], (*memory, times[j], u[j], at.NO_EVENT, at.NO_EVENT))
        copy(work.states[at.RATES_AT], rates[j])


@compiled
def fill_each_reading(plan, given, room, rods, own, step, begin, readings):
    """Fill in what both encoders show (k, 2) of a given motion of the rods (k, 7), sample by sample.

    That is theta1, theta2, omega1, omega2, both accelerations, and the cart's. The laws' own states and their rates
    (2, states) go on from those at the sample before by Heun's method, and are left as they are at the last one.
    """
    memory, motion = (place(plan, 0), place(room, 0)), place(given, 0)
    laws, work = unfolded(*memory)
    state = work.states[at.BEGIN]
    begin_modes(laws, work)
    for j in range(len(rods)):
        for r in range(len(state)):
            k = r - at.RODS_STATES
            state[r] = rods[j, r] if k < 0 else own[0, k] + step * own[1, k]
        for _ in range(2):
            call(plan[at.FILL_RATES], (memory[0], motion, memory[1], at.BEGIN, begin + j * step, 0.0, 0, 0))
            for r in range(at.RODS_STATES, len(state)):
                k = r - at.RODS_STATES
                moved = own[0, k] + 0.5 * step * (own[1, k] + work.states[at.RATES_AT, r])
                state[r] = min(max(moved, -laws.limits[r]), laws.limits[r])
        for r in range(at.RODS_STATES, len(state)):
            own[0, r - at.RODS_STATES], own[1, r - at.RODS_STATES] = state[r], work.states[at.RATES_AT, r]
        for k in range(3):
            work.z[at.ALPHA1 + k] = rods[j, at.RODS_STATES + k]
        readings[j, 0] = state[0] + added_by_laws(laws, motion, work, state, 0)
        readings[j, 1] = state[1] - state[0] + added_by_laws(laws, motion, work, state, 1)

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A part of a step of a motion: as long as its error allows, and up to where a mode ends (compiled)."""

from numba import float64

from cdp_ident.machine.calls import INDICES, NUMBERS, call, call_for_number, place
from cdp_ident.model import layout as at
from cdp_ident.model.layout import unfolded
from cdp_ident.model.rates import STICKS, copy
from cdp_ident.model.runge_kutta import roughness
from cdp_ident.model.sticking import SMALLEST, dip, resolving_share, violation

_MOST_EVENTS = 32
"""Most events in one step; further ones are ignored."""


def make_part(plan, motion, room, begin, step, done):
    """Make a part of a step, and return which share of it that is; which mode ends with it is left in the progress.

    Args:
        plan: memory with the laws, modes and progress.
        motion: what gives the motion.
        room: memory to work in, with how long the part may be.
        begin: time in the trial at the beginning of the step [s].
        step: its length [s].
        done: share of it that is done.
    """
    laws, work = unfolded(plan, room)
    derive, modes, numbers = int(plan[at.DIRECTIONS] > 0), work.modes, work.numbers
    longest = min(numbers[at.LONGEST], 1.0 - done)
    share = longest
    for law in range(len(laws.table)):
        if laws.table[law, at.RESOLVES] >= 0:
            share = min(share, resolving_share(laws, motion, work, step))
            break
    call(plan[at.STEP_ON], (plan, motion, room, begin, step, done, share, at.END, derive))
    rough = roughness(work, share * step)
    while share > SMALLEST and rough > 1.0:
        share *= 0.5
        longest = share
        call(plan[at.STEP_ON], (plan, motion, room, begin, step, done, share, at.END, derive))
        rough = roughness(work, share * step)
    # A part twice as long would have 16 times the error.
    numbers[at.LONGEST] = min(1.0, 2.0 * longest) if 16.0 * rough < 1.0 else longest
    modes[at.PROGRESS, at.STOPPED] = at.NO_EVENT
    looks = False
    for mode in range(modes.shape[1] if modes[at.IS_TURNED, 0] + modes[at.IS_TURNED, 1] > 0 else 0):
        numbers[at.VIOLATIONS + mode] = violation(laws, work, work.states[at.END], mode)
        slips = mode < 2 and modes[at.IS_TURNED, mode] != 0 and modes[at.MODE, mode] != STICKS
        ends = numbers[at.VIOLATIONS + mode] > 0.0 or (slips and dip(work, mode) > 0.0)
        modes[at.IS_SOUGHT, mode] = 1 if ends else 0
        looks = looks or ends
    if looks and modes[at.PROGRESS, at.EVENTS] < _MOST_EVENTS:
        # The step is repeated, up to the instant or as before: the search overwrites its rates.
        whole = share
        copy(work.states[at.RATES_AT + 4], work.states[at.READ])
        for mode in range(modes.shape[1]):
            if modes[at.IS_SOUGHT, mode]:
                copy(work.states[at.READ], work.states[at.RATES_AT + 4])
                instant = call_for_number(plan[at.INSTANT_OF], (plan, motion, room, begin, step, done, whole, mode))
                if instant <= share:
                    share, modes[at.PROGRESS, at.STOPPED] = instant, mode
        modes[at.PROGRESS, at.EVENTS] += 1
        call(plan[at.STEP_ON], (plan, motion, room, begin, step, done, share, at.END, derive))
    if derive:
        call(plan[at.ADVANCE], (place(work.matrices, 0), place(work.slopes, 0), share * step, plan[at.DIRECTIONS]))
    return share


OF_MAKE_PART = float64(INDICES, NUMBERS, NUMBERS, float64, float64, float64)
"""Signature of `make_part`."""

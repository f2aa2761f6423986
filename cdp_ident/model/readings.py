# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What an encoder shows of a motion at one instant, and its derivatives (compiled)."""

import numpy as np

from cdp_ident.machine.compilation import call, inlined, part
from cdp_ident.model import layout as at
from cdp_ident.model.formulas.language import INNER, LATENESS
from cdp_ident.model.layout import unfolded
from cdp_ident.model.rates import call_law, fill_inputs, fill_slopes, joint_speed
from cdp_ident.model.runge_kutta import chain, hermite

_NEAR = 1e-6
"""Instants so far apart tell how fast a reading changes [s]."""


@part
def lateness(laws, motion, work, joint):
    """Return how late the encoder of a joint is read [s]; what it depends on is left in the reading's rows."""
    fill_inputs(motion, work, work.states[at.BEGIN], 0.0)
    late = 0.0
    for law in range(len(laws.table)):
        if laws.table[law, at.KIND] & at.LATE and laws.table[law, at.JOINT] == joint:
            call_law(laws, motion, work, law, work.states[at.BEGIN])
            late += work.rows[laws.table[law, at.ROWS_AT] + LATENESS * laws.table[law, at.WIDTH]]
    return late


@inlined
def read_state(work, share, length, rows):
    """Fill in the state within a step, and the derivatives of so many of its numbers."""
    w0, w1, w2, w3 = hermite(share, length)
    states, slopes = work.states, work.slopes
    for r in range(states.shape[1]):
        states[at.READ, r] = (
            w0 * states[at.BEGIN, r]
            + w1 * states[at.END, r]
            + w2 * states[at.RATES_AT, r]
            + w3 * states[at.RATES_AT + 4, r]
        )
    for r in range(rows):
        for d in range(np.uint64(work.directions)):
            slopes[r, at.AT_READING, d] = (
                w0 * slopes[r, at.OLD, d] + w1 * slopes[r, at.NEW, d]
                + w2 * slopes[r, at.OLD_SLOPE, d] + w3 * slopes[r, at.NEW_SLOPE, d]
            )  # fmt: skip


def read_encoder(plan, motion, room, joint, share, length, t, u, u_rate, by):
    """Return what the encoder of a joint (0 inner, 1 outer) shows, and fill in its derivatives `by` directions (d,).

    It is looked at in a step of a length [s] that is made, after a share of it, when the time in the trial is t [s],
    and the cart's acceleration u [m/s^2], which changes by `u_rate` [m/s^3].
    """
    laws, work = unfolded(plan, room)
    n, directions = work.states.shape[1], work.directions
    alters, changes, accelerated, late, derive = False, False, False, False, 0
    for law in range(len(laws.table)):
        if laws.table[law, at.KIND] & at.READ_KIND:
            alters, kind = True, laws.table[law, at.KIND]
            changes = changes or kind & at.SHOWN != 0
            late = late or (directions > 0 and kind & at.LATE != 0 and laws.table[law, at.JOINT] == joint)
            if kind & at.ACCELERATED:
                accelerated = True
                derive = 1 if directions > 0 and not kind & at.OF_NO_STRENGTH else derive
    rate = 0.0
    if late and changes:
        rate = _rate_of_reading((plan, motion, room), laws, work, joint, share, length, t, u, u_rate)
    read_state(work, share, length, n if alters else 2)
    state, slopes = work.states[at.READ], work.slopes
    for d in range(np.uint64(directions)):
        by[d] = slopes[0, at.AT_READING, d] if joint == 0 else slopes[1, at.AT_READING, d] - slopes[0, at.AT_READING, d]
    angle = state[0] if joint == 0 else state[1] - state[0]
    if not alters:
        return angle
    if accelerated:
        call(plan[at.FILL_RATES], (plan, motion, room, at.READ, t, u, at.STAGES, derive))
    else:
        fill_inputs(motion, work, state, t)
        work.z[at.U] = u
    angle += added_by_laws(laws, motion, work, state, joint)
    rate = rate if changes else joint_speed(state, joint)
    for law in range(len(laws.table) if directions > 0 else 0):
        if laws.table[law, at.KIND] & at.READ_KIND:
            width, first = laws.table[law, at.WIDTH], laws.table[law, at.ROWS_AT]
            _add_derivatives(laws, work, law, first + (INNER + joint) * width, 1.0, by)
            if late and laws.table[law, at.JOINT] == joint:
                _add_derivatives(laws, work, law, first + LATENESS * width, -rate, by)
    return angle


@part
def _rate_of_reading(memory, laws, work, joint, share, length, t, u, u_rate):
    """Return how fast what the encoder of a joint shows changes, by differences [rad/s]."""
    plan, motion, room = memory
    state, rate = work.states[at.READ], 0.0
    for side in (-1.0, 1.0):
        later = side * _NEAR
        read_state(work, share + later / length, length, 0)
        call(plan[at.FILL_RATES], (plan, motion, room, at.READ, t + later, u + u_rate * later, at.STAGES, 0))
        angle = state[0] if joint == 0 else state[1] - state[0]
        rate += side * (angle + added_by_laws(laws, motion, work, state, joint)) / (2.0 * _NEAR)
    return rate


@part
def added_by_laws(laws, motion, work, state, joint):
    """Return what laws add to what the encoder of a joint shows in a state, whose inputs of laws are filled in."""
    added = 0.0
    for law in range(len(laws.table)):
        if laws.table[law, at.KIND] & at.READ_KIND:
            call_law(laws, motion, work, law, state)
            added += work.rows[laws.table[law, at.ROWS_AT] + (INNER + joint) * laws.table[law, at.WIDTH]]
    return added


@part
def _add_derivatives(laws, work, law, of, factor, by):
    """Add a row's derivatives, times a factor, to those by all directions."""
    fill_slopes(laws, work, law, of, at.STAGES, at.READING_BY, factor)
    chain(work, at.READING_BY, at.RATES_BY + at.STAGES, at.AT_READING, by, True)

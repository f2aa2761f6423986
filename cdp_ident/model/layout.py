# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A model's laws and the room to compute motions in, as compiled code takes them.

Each is a structure with named fields, and what is in an array has named places: what is looked at by its place in an
argument list could be exchanged unnoticed. They have few fields, for the compiler takes time for each at each call.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba import carray

from cdp_ident.arrays import Array, Indices
from cdp_ident.machine.compilation import further, inlined_with_arrays
from cdp_ident.model.formulas.language import COEFFICIENTS, INPUTS, PARAMETERS, ROWS, STATE

RODS_STATES = len(STATE)
ALPHA1, ALPHA2, U, OWN, COEFFICIENT, T, DIRECTION, ROD_LENGTH, SINES, DRIVES_NOW = map(
    INPUTS.index,
    ("alpha1", "alpha2", "u", "own0", "A23", "t", "direction_inner", "outer_length", "sin1", "drive_inner"),
)
"""Where these stand among the inputs of laws, each followed by what is of its kind, as in `INPUTS`."""
BY_ALPHA1, BY_ALPHA2, BY_U, BY_OWN, BY_COEFFICIENT = (1 + place for place in (ALPHA1, ALPHA2, U, OWN, COEFFICIENT))
"""Columns of what laws return with the derivatives by these, the coefficients and the law's parameters being last."""
VECTOR = 8
"""So many directions of derivatives are carried together, in the widest vector registers."""
ROOM = 328
"""Room for a row of derivatives, by the state and by directions: an odd number of cache lines, so that rows do not
displace each other."""
OUTER_LENGTH, CARRIED, VALUES = (len(COEFFICIENTS) + k for k in range(3))
"""What gives a motion: the coefficients, then the outer rod's length [m], the mass of weights on the rods over A22
[1/m^2], and the parameters of all laws."""

CODE, KIND, JOINT, VALUES_AT, WIDTH, LANES_AT, ROWS_AT, OWN_AT, OWNS, RESOLVES, TURNS = range(11)
LAW_COLUMNS = 11
"""Of each law: the address of its compiled code; its kind; its joint (0 inner, 1 outer, 2 base); where its parameters
begin among those of all laws; columns of its rows, and where their lanes and the rows begin; where its own states
begin, and how many these are; which parameter is a speed or angle within which it changes, -1 for none; whether its
joint's speed passes through zero between steps only."""
MOVES, SHOWN, LATE, FRICTION_KIND, CART_KIND, ACCELERATED, WITHIN_ANGLE, OF_NO_STRENGTH = (1 << k for k in range(8))
READ_KIND = SHOWN + LATE
"""Kinds, added up: adds to the motion, or has states; adds to what encoders show; says how late an encoder is read; dry
friction; moves the cart's joint; depends on accelerations; changes within an angle, not a speed; has no strength."""


class Laws(NamedTuple):
    """The laws of a model."""

    table: Indices
    """(laws, 11) see `CODE` and what follows."""
    lanes: Indices
    """Place of each column of rows in a row of derivatives, by the n numbers of the state and then by directions, -1
    for none: first of the columns that all laws share, then of each law's."""
    limits: Array
    """(states,) size at which a number of the state stays; infinite for most."""


BEGIN, HERE, END, TRIAL, READ, RATES_AT = range(6)
"""States: at a step's beginning, at a stage, at its end, at that of a trial step, where one is read; then rates: at the
beginning, at three stages, at the end, and where the state is read."""
STAGES, RATES_READ = 5, RATES_AT + 5
"""Where a step's rates are computed: at its beginning, at three stages on the way, and at its end."""
OLD, OLD_SLOPE, NEW, NEW_SLOPE, AT_READING, RATES_BY = range(6)
"""Derivatives of the state by all directions: at a step's beginning and its end, and their slopes there, and where they
are read. Then, for each of the stages and where the state is read, those of the rates: n columns by the state there,
and further ones by the directions themselves."""
CART_BY, READING_BY = 0, 1
"""Among these, in the place of theta1 and theta2, whose rates are other numbers of the state: derivatives of the cart's
acceleration and, where the state is read, of a reading."""
ROWS_OF_SLOPES = RATES_BY + STAGES + 1
MODE, IS_TURNED, IS_SOUGHT, PROGRESS = range(4)
"""Of both joints, then of each number of the state: 1 or -1 where a joint slips that way and 0 where it sticks, or 1 or
-1 where a number is held at a limit; whether a joint's speed passes through zero between steps only; whether a mode may
have ended within a step. The last row is of the step, see `STOPPED`."""
STOPPED, EVENTS, NO_EVENT = 0, 1, -1
"""Which mode ended with a part of a step, if any; and how many events there were in the step so far."""
SIZES, HOLDS, INERTIAS, CART_INPUTS, DRIVES, STEP_BEGIN, PER_STEP, LONGEST, VIOLATIONS = 0, 2, 4, 8, 11, 17, 18, 19, 20
"""Places of the joints' dry friction, the torques that hold sticking joints, the inertia matrix, all over A22; the
cart's acceleration at a step's beginning, middle and end [m/s^2], and the torques of the inner and the outer joint's
motor there [N m]; where motors act, when the step begins [s], and one over its length [1/s]; how long the next part of
a step may be, as a share of it; and by how much each mode's condition is violated at its end."""


class Work(NamedTuple):
    """Room for a step of a motion, of a state of n numbers in d directions."""

    z: Array
    """The inputs of laws, see `language.INPUTS`."""
    rows: Array
    """What laws add."""
    sums: Array
    """(2, 3 columns) what all laws add to the rods' equations and to the cart's, and the derivatives of that; and
    the same of those that do not depend on accelerations."""
    numbers: Array
    """See `SIZES` and what follows."""
    states: Array
    """(11, n) see `BEGIN` and what follows."""
    slopes: Array
    """(n, 11, ROOM) see `OLD` and what follows; of the room, some is used."""
    directions: int
    """A multiple of `VECTOR`."""
    modes: Indices
    """(4, 2 + n) see `MODE` and what follows."""


LAWS, STATES, DIRECTIONS, LANES, ROWS_LENGTH = range(5)
FILL_RATES, STEP_ON, SETTLE, INSTANT_OF, MAKE_PART, READ_ENCODER, ADVANCE, TABLE = range(5, 13)
"""What stands in a plan: how many laws, states, directions, lanes and rows' numbers there are; the addresses of
compiled code; and then the laws' table, their lanes, and the modes."""


def most_directions(states: int) -> int:
    """Return how many directions of derivatives there is room for, beside a state of so many numbers."""
    return (ROOM - states) // VECTOR * VECTOR


def plan_and_room(laws: Laws, directions: int, addresses: Sequence[int]) -> tuple[Indices, Array]:
    """Return the memory of compiled code: whole numbers that say what there is, and room for numbers."""
    states, rows = len(laws.limits), ROWS * int(laws.table[:, WIDTH].sum()) + 1
    if directions > most_directions(states):
        raise ValueError(f"{directions} directions of derivatives and {states} states: there is room for {ROOM} in all")
    counts = [len(laws.table), states, -(-directions // VECTOR) * VECTOR, len(laws.lanes), rows, *addresses]
    plan = np.concatenate([counts, laws.table.ravel(), laws.lanes, np.zeros(4 * (2 + states))]).astype(np.int64)
    room = states + len(INPUTS) + rows + 6 * PARAMETERS + VIOLATIONS + 2 + states
    room += states * (RATES_READ + 1 + ROWS_OF_SLOPES * ROOM)
    memory = np.zeros(room)
    memory[:states] = laws.limits
    return plan, memory


@inlined_with_arrays
def unfolded(plan, room):
    """Return the laws and the work in memory, given where it begins."""
    laws, n, d, lanes, rows = plan[LAWS], plan[STATES], plan[DIRECTIONS], plan[LANES], plan[ROWS_LENGTH]
    table, at = further(plan, TABLE), further(plan, TABLE + laws * LAW_COLUMNS)
    z = further(room, n)
    of_rows = further(z, len(INPUTS))
    sums = further(of_rows, rows)
    numbers = further(sums, 6 * PARAMETERS)
    states = further(numbers, VIOLATIONS + 2 + n)
    slopes = further(states, (RATES_READ + 1) * n)
    return (
        Laws(carray(table, (laws, LAW_COLUMNS)), carray(at, (lanes,)), carray(room, (n,))),
        Work(
            carray(z, (len(INPUTS),)), carray(of_rows, (rows,)), carray(sums, (2, 3 * PARAMETERS)), carray(numbers,
            (VIOLATIONS + 2 + n,)), carray(states, (RATES_READ + 1, n)),
            carray(slopes, (n, ROWS_OF_SLOPES, ROOM)), d, carray(further(at, lanes), (4, 2 + n)),
        ),
    )  # fmt: skip

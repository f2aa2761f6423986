"""The torques of effects on several motions side by side in lanes (compiled): see `lane_rows`.

Each law is a loop over the lanes of its own, so that it is chosen once for all of them and vectorised.
"""

import math
from collections.abc import Callable

from cdp_ident.model.compilation import Compilable, part
from cdp_ident.model.dynamics import COUPLING, RODS, between_bodies, onto_rods, times3
from cdp_ident.model.effects.catalogue import in_loops
from cdp_ident.model.effects.constants import COUNT
from cdp_ident.model.effects.effect import MOST_OF_A_LAW, Form
from cdp_ident.model.equations import RODS_STATES, sines_and_cosines
from cdp_ident.model.lane_rows import (
    ACTING,
    BEFORE_PARAMETERS,
    BY_COEFFICIENTS,
    BY_PARAMETERS,
    BY_STATE,
    CONSTANTS,
    COUPLED,
    DIRECT,
    HERE,
    LENGTH,
    MODE,
    MODES,
    SIZE,
    SIZES,
    STAGE,
    TIME,
    TORQUES,
    TURNED,
    VALUES,
    row,
)
from cdp_ident.model.parameters import COEFFICIENTS

_COEFFICIENTS = len(COEFFICIENTS)
_SUMS = 2 + 2 + 1 + 2 * RODS_STATES + 2 * _COEFFICIENTS
"""Rows that effects add to, from `TORQUES` on."""


def loop_of_joint_law(law: Compilable, dry: bool) -> Callable[..., None]:
    """Return a loop that adds the torques by a law of form JOINT to all lanes."""

    def add(motion, joint, along, width):
        onto1, onto2 = onto_rods(joint)
        hanging = math.pi if joint == 0 else 0.0
        for i in range(width):
            at, v, to = row(HERE) + i, row(ACTING) + i, row(TORQUES) + i
            torque, by_angle, by_speed, by = law(
                onto1 * motion[at] + onto2 * motion[at + row(1)] - hanging,
                onto1 * motion[at + row(2)] + onto2 * motion[at + row(3)],
                (motion[v], motion[v + row(1)], motion[v + row(2)]),
            )
            against = 1.0
            if dry:
                motion[row(SIZE) + i] = torque
                against = -motion[row(MODE) + i]
            to1, to2 = against * onto1, against * onto2
            motion[to] += to1 * torque
            motion[to + row(1)] += to2 * torque
            to = row(BY_STATE) + i
            motion[to] += to1 * onto1 * by_angle
            motion[to + row(1)] += to1 * onto2 * by_angle
            motion[to + row(2)] += to1 * onto1 * by_speed
            motion[to + row(3)] += to1 * onto2 * by_speed
            motion[to + row(4)] += to2 * onto1 * by_angle
            motion[to + row(5)] += to2 * onto2 * by_angle
            motion[to + row(6)] += to2 * onto1 * by_speed
            motion[to + row(7)] += to2 * onto2 * by_speed
            to = row(BY_PARAMETERS) + i
            motion[to], motion[to + row(1)], motion[to + row(2)] = times3(to1, by)
            motion[to + row(3)], motion[to + row(4)], motion[to + row(5)] = times3(to2, by)

    return add


def loop_of_rods_law(law: Compilable, dry: bool) -> Callable[..., None]:
    """Return a loop that adds the torques by a law of form RODS to all lanes."""

    def add(motion, joint, along, width):
        onto1, onto2 = onto_rods(joint)
        for i in range(width):
            at, t, v, c = row(HERE) + i, row(TURNED) + i, row(ACTING) + i, row(CONSTANTS) + i
            torque1, torque2, x, y, to1, to2, by1, by2 = law(
                (motion[at], motion[at + row(1)], motion[at + row(2)], motion[at + row(3)]),
                (motion[t], motion[t + row(1)], motion[t + row(2)], motion[t + row(3)]),
                motion[row(TIME) + i] + along * motion[row(LENGTH) + i],
                (motion[v], motion[v + row(1)], motion[v + row(2)]),
                (
                    motion[c], motion[c + row(1)], motion[c + row(2)], motion[c + row(3)], motion[c + row(4)],
                    motion[c + row(5)], motion[c + row(6)], motion[c + row(7)], motion[c + row(8)], motion[c + row(9)],
                ),
            )  # fmt: skip
            if dry:
                motion[row(SIZE) + i] = torque1
                against = -motion[row(MODE) + i]
                torque1, torque2, x, y, to1, to2, by1, by2 = between_bodies(
                    against * onto1, against * onto2, torque1, x, to1, by1
                )
            to = row(TORQUES) + i
            motion[to] += torque1
            motion[to + row(1)] += torque2
            to = row(BY_STATE) + i
            motion[to] += x[0]
            motion[to + row(1)] += x[1]
            motion[to + row(2)] += x[2]
            motion[to + row(3)] += x[3]
            motion[to + row(4)] += y[0]
            motion[to + row(5)] += y[1]
            motion[to + row(6)] += y[2]
            motion[to + row(7)] += y[3]
            to = row(BY_COEFFICIENTS) + i
            motion[to] += to1[0]
            motion[to + row(1)] += to1[1]
            motion[to + row(2)] += to1[2]
            motion[to + row(3)] += to1[3]
            motion[to + row(4)] += to1[4]
            motion[to + row(5)] += to1[5]
            motion[to + row(6)] += to1[6]
            motion[to + row(7)] += to2[0]
            motion[to + row(8)] += to2[1]
            motion[to + row(9)] += to2[2]
            motion[to + row(10)] += to2[3]
            motion[to + row(11)] += to2[4]
            motion[to + row(12)] += to2[5]
            motion[to + row(13)] += to2[6]
            to = row(BY_PARAMETERS) + i
            motion[to], motion[to + row(1)], motion[to + row(2)] = by1
            motion[to + row(3)], motion[to + row(4)], motion[to + row(5)] = by2

    return add


assert COUNT == 10, "the constants are counted out above"
_add_by_joint_law = in_loops(Form.JOINT, loop_of_joint_law, "joint")
_add_by_rods_law = in_loops(Form.RODS, loop_of_rods_law, "rods")


@part
def turn(motion, width):
    """Fill in sines and cosines of the angles at a stage."""
    for i in range(width):
        at, t = row(HERE) + i, row(TURNED) + i
        sin1, cos1, sin2, cos2 = sines_and_cosines(motion[at], motion[at + row(1)])
        motion[t], motion[t + row(1)], motion[t + row(2)], motion[t + row(3)] = sin1, cos1, sin2, cos2


@part
def fill_in_torques(motion, stages, stage, directions, width, table, lanes_of):
    """Fill in the effects' torques at a stage, and their derivatives.

    Those by the effects' parameters are left in the rows of the stage where those of the accelerations are to be.
    """
    for k in range(_SUMS):
        for i in range(width):
            motion[row(TORQUES + k) + i] = 0.0
    along = 0.0 if stage == 0 else (0.5 if stage < 3 else 1.0)
    for e in range(len(table)):
        kind, form, joint = table[e, 0], table[e, 1], table[e, 2]
        if form == COUPLING:
            # What its constant changes follows from the accelerations.
            for i in range(width):
                motion[row(COUPLED) + i] += motion[row(VALUES + MOST_OF_A_LAW * e) + i]
            continue
        for p in range(MOST_OF_A_LAW):
            for i in range(width):
                motion[row(ACTING + p) + i] = motion[row(VALUES + MOST_OF_A_LAW * e + p) + i]
        dry = table[e, 3] != 0
        if dry:
            for i in range(width):
                motion[row(MODE) + i] = motion[row(MODES + joint) + i]
        if form == RODS:
            _add_by_rods_law(kind, motion, joint, along, width)
        else:
            _add_by_joint_law(kind, motion, joint, along, width)
        if dry:
            for i in range(width):
                motion[row(SIZES + joint) + i] += motion[row(SIZE) + i]
        if directions > BEFORE_PARAMETERS:
            for p in range(MOST_OF_A_LAW):
                if lanes_of[e, p] >= 0:
                    direct = row(stage * STAGE + DIRECT + 2 * (BEFORE_PARAMETERS + lanes_of[e, p]))
                    for i in range(width):
                        by = row(BY_PARAMETERS + p) + i
                        stages[direct + i], stages[direct + row(1) + i] = motion[by], motion[by + row(MOST_OF_A_LAW)]

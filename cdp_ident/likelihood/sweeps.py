# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The sweeps over the nodes of a swing: backwards for the information, forwards for the states (compiled).

Between nodes k and k + 1 the deviations x of the state from where it was linearised, and those of the unknowns p, obey
x[k+1] = A[k] (x[k], p) + c[k] + G[k] u[k], u being the impulses of unknown torques in both joints; what the encoders
show is off by H (x, p) + r. What all later readings say of (x, p) is a triangular matrix R and a right-hand side, so
that the sum of squares is |R (x, p) + z|^2 plus what nothing can change. It is carried backwards by orthogonal
transformations: the square-root information filter (Bierman, Factorization Methods for Discrete Sequential Estimation,
1977, chapters 5 and 6), which loses no digits where motion is chaotic.
"""

import math
from typing import NamedTuple

import numpy as np

from cdp_ident.arrays import Array, Indices
from cdp_ident.machine.compilation import compiled, part
from cdp_ident.model.layout import RODS_STATES

_NOTHING = 1e-280
"""The square of the length of a column in which there is nothing."""
_A_STEP = 1.0 + 1e-6
"""Readings are a step apart, give or take rounding."""
_SPEEDS = RODS_STATES - 2
"""Where the rods' speeds are in a state, which impulses of torques change."""


class Whitened(NamedTuple):
    """A linearised swing whose readings' noise is white and of size one."""

    transitions: Array
    """(nodes, n, d) A: where the motion comes at the next node, by state and unknowns."""
    gaps: Array
    """(nodes, n) c."""
    pushes: Array
    """(nodes, 2, 2) changes of the rods' speeds by impulses of torque over A22 in both joints."""
    rows: Array
    """(samples, 2, d) H, by the state at the node before and the unknowns."""
    right: Array
    """(samples, 2) r."""
    samples_at: Indices
    """(nodes + 1,) where the samples of each node begin."""
    sizes: Array
    """(nodes, 2) standard deviation of the impulses of both joints."""


@compiled
def filter_rows(rows, right, new, follows, samples_at, kept, mixed, transitions, gaps):
    """Turn what readings are off by into what is new in their noise; see `Noise`.

    Args:
        rows: (samples, 2, d) derivatives by a state whose last two numbers carry noise, and by the unknowns.
        right: (samples, 2) residuals; what is carried at each node's beginning is in the state, not here.
        new: (samples, 2) the same; here it is.
        follows: (samples, 2) whether a reading's noise remembers the one before.
        samples_at: (nodes + 1,) where the samples of each node begin.
        kept: (2,) of the noise.
        mixed: (2,) of the noise.
        transitions: (nodes, n, d) takes those of what is carried.
        gaps: (nodes, n) takes those of what is carried.
    """
    nodes, n, d = transitions.shape
    carried = np.zeros(d + 1)
    for joint in range(2):
        before = 0.0
        for k in range(nodes):
            carried[:] = 0.0
            carried[n - 2 + joint] = 1.0
            for sample in range(samples_at[k], samples_at[k + 1]):
                shown = right[sample, joint]
                left = shown
                if follows[sample, joint]:
                    left += carried[d]
                    new[sample, joint] += before
                for j in range(d):
                    of = rows[sample, joint, j]
                    total = of + carried[j] if follows[sample, joint] else of
                    rows[sample, joint, j] = total
                    carried[j] = mixed[joint] * total - kept[joint] * of
                right[sample, joint] = left
                carried[d] = mixed[joint] * left - kept[joint] * shown
                before = mixed[joint] * new[sample, joint] - kept[joint] * shown
            for j in range(d):
                transitions[k, n - 2 + joint, j] = carried[j]
            gaps[k, n - 2 + joint] = carried[d]


@compiled
def share_rounding(reading, step, weights):
    """Fill in the weights (n,) of an encoder's readings (n,): those within a step count together; see `Swing`."""
    begin, least, most = 0, reading[0], reading[0]
    for k in range(1, len(reading) + 1):
        if k < len(reading):
            lower, upper = min(least, reading[k]), max(most, reading[k])
            if upper - lower <= _A_STEP * step:
                least, most = lower, upper
                continue
        shown = 1.0 if most - least < 0.5 * step else 2.0
        weights[begin:k] = min(1.0, shown / (k - begin))
        if k < len(reading):
            begin, least, most = k, reading[k], reading[k]


@compiled
def squares_and_expected(left, rates, sizes, time):
    """Return sums (3,) of squares that belong to both encoders' noise and to errors of time, and those expected.

    The inverse of a sample's covariance is that of the encoders' noise less what errors of time take from it.

    Args:
        left: (samples, 2) residuals.
        rates: (samples, 2) of change of what the encoders show.
        sizes: (2,) standard deviation of both encoders' noise.
        time: standard deviation of errors of time.
    """
    squares, expected = np.zeros(3), np.zeros(3)
    one, other = sizes[0] ** -2.0, sizes[1] ** -2.0
    for k in range(len(left)):
        first, second = one * rates[k, 0], other * rates[k, 1]
        of_rates = first * rates[k, 0] + second * rates[k, 1]
        share = time * time / (1.0 + time * time * of_rates)
        of_left = first * left[k, 0] + second * left[k, 1]
        squares[0] += (one * left[k, 0] - share * first * of_left) ** 2
        squares[1] += (other * left[k, 1] - share * second * of_left) ** 2
        expected[0] += one - share * first * first
        expected[1] += other - share * second * second
        squares[2] += (of_left * (1.0 - share * of_rates)) ** 2
        expected[2] += of_rates * (1.0 - share * of_rates)
    return squares, expected


@part
def triangularise(matrix, rows, pivots, upper, new):
    """Make the first pivots of a matrix's columns an upper triangle, by Householder's reflections of all columns.

    Args:
        matrix: (columns, at least rows) its transpose, so that each column lies together in memory.
        rows: how many it has.
        pivots: how many of the columns.
        upper: rows before this one are full.
        new: rows from this one on are; those between are a triangle already.
    """
    for j in range(min(pivots, rows - 1)):
        of, above, below = matrix[j], matrix[j, j + 1 : max(upper, j + 1)], matrix[j, max(new, j + 1) : rows]
        square = 0.0
        for i in range(len(above)):
            square += above[i] * above[i]
        for i in range(len(below)):
            square += below[i] * below[i]
        if square >= _NOTHING:  # of less a square root times a number would be lost, and by nothing nothing is divided
            norm = -math.copysign(math.sqrt(of[j] * of[j] + square), of[j])
            head = of[j] - norm
            scale = 1.0 / (norm * head)
            for k in range(j + 1, len(matrix)):
                other, other_below = matrix[k, j + 1 : max(upper, j + 1)], matrix[k, max(new, j + 1) : rows]
                along = head * matrix[k, j]
                for i in range(len(above)):
                    along += above[i] * other[i]
                for i in range(len(below)):
                    along += below[i] * other_below[i]
                along *= scale
                matrix[k, j] += along * head
                for i in range(len(above)):
                    other[i] += along * above[i]
                for i in range(len(below)):
                    other_below[i] += along * below[i]
            of[j] = norm
        above[:] = 0.0
        below[:] = 0.0


@part
def _product(one, other):
    """Return the scalar product of two rows."""
    total = 0.0
    for i in range(len(one)):  # a range over a length is made into vector instructions, others are not
        total += one[i] * other[i]
    return total


@compiled
def backwards(swing, impulses, triangles, others, begins, matrix):
    """Carry the information of all readings back to the first node, and return the logarithm of a determinant.

    Args:
        swing: see `Whitened`.
        impulses: (nodes, 2, d + 3) takes the rows that give them: derivatives by both, by state and unknowns, the rest.
        triangles: (nodes, own, d + 1) takes R and z at each node. Of the d directions the first ones, `own`, are
            estimated; the others are candidates.
        others: (nodes or 1, d + 1 - own, d + 1 - own) takes the products of what is left of candidates and readings,
            once the rest is estimated, from each node or the first one on.
        begins: (d + 1 - own,) the first one with which each has a product that is wanted.
        matrix: memory (d + 3, own + 2 + 2 times the most samples of a node), a row for each column.
    """
    transitions, gaps, pushes = swing.transitions, swing.gaps, swing.pushes
    all_rows, right, samples_at, sizes = swing.rows, swing.right, swing.samples_at, swing.sizes
    nodes, n, d = transitions.shape
    own, logarithm = triangles.shape[1], 0.0
    others[:] = 0.0
    for k in range(nodes - 1, -1, -1):
        rows = 2
        for i in range(2):
            for j in range(d + 3):
                matrix[j, i] = 0.0
            matrix[i, i] = 1.0 / sizes[k, i]
        upper = 2
        if k < nodes - 1:
            triangle = triangles[k + 1]
            for i in range(own):
                for torque in range(2):
                    matrix[torque, rows] = (
                        triangle[i, _SPEEDS] * pushes[k, 0, torque] + triangle[i, _SPEEDS + 1] * pushes[k, 1, torque]
                    )
                for j in range(d):
                    matrix[2 + j, rows] = triangle[i, j] if j >= n else 0.0
                matrix[2 + d, rows] = triangle[i, d]
                for state in range(n if i < n else 0):
                    for j in range(d):
                        matrix[2 + j, rows] += triangle[i, state] * transitions[k, state, j]
                    matrix[2 + d, rows] += triangle[i, state] * gaps[k, state]
                rows += 1
            upper += n
        new = rows
        for sample in range(samples_at[k], samples_at[k + 1]):
            for joint in range(2):
                matrix[0, rows], matrix[1, rows] = 0.0, 0.0
                for j in range(d):
                    matrix[2 + j, rows] = all_rows[sample, joint, j]
                matrix[2 + d, rows] = right[sample, joint]
                rows += 1
        triangularise(matrix, rows, 2 + own, upper, new)
        for i in range(2):
            logarithm += 2.0 * math.log(abs(matrix[i, i]) * sizes[k, i])
            for j in range(d + 3):
                impulses[k, i, j] = matrix[j, i]
        for i in range(own):
            for j in range(d + 1):
                triangles[k, i, j] = matrix[2 + j, 2 + i] if 2 + i < rows else 0.0
        at = k if len(others) == nodes else 0
        if 0 < at + 1 < len(others):
            others[at] = others[at + 1]
        for i in range(d + 1 - own):
            for j in range(begins[i], i + 1):
                others[at, i, j] += _product(matrix[2 + own + i, 2 + own : rows], matrix[2 + own + j, 2 + own : rows])
    for at in range(len(others)):
        for i in range(d + 1 - own):
            for j in range(i):
                others[at, j, i] = others[at, i, j]
    return logarithm


@part
def _quadratic(spread, row):
    """Return a row (d,) times a symmetric matrix (d, d) times that row."""
    total = 0.0
    for i in range(len(row)):
        total += row[i] * (0.5 * spread[i, i] * row[i] + _product(spread[i, :i], row))
    return 2.0 * total


@compiled
def forwards(swing, impulses, deviations, spreads, torques, freedom, matrix):
    """Find the most likely deviation at each node from where the motion was linearised, and the impulses.

    Args:
        swing: see `Whitened`.
        impulses: (nodes, 2, d + 3) rows that `backwards` found.
        deviations: (nodes, own) takes the most likely ones, of the state and of the unknowns; the first one is given.
        spreads: (nodes, own, own) takes their covariances; the first one is given.
        torques: (nodes, 2, 2) takes the impulses of both joints and their standard deviations.
        freedom: (4, 2) takes how many degrees of freedom the estimates took from each encoder's noise, how many each
            joint's impulses have, the sum of what readings decide of each, from 0 to 1, and the sum of squares of what
            is new in each encoder's noise, over its variance, and of the impulses.
        matrix: memory for 2 n + 2 rows and own + 1 columns.
    """
    transitions, gaps, pushes = swing.transitions, swing.gaps, swing.pushes
    rows, right, samples_at, sizes = swing.rows, swing.right, swing.samples_at, swing.sizes
    (nodes, n, last), d = transitions.shape, deviations.shape[1]
    last += 2
    for i in range(4):
        freedom[i, 0], freedom[i, 1] = 0.0, 0.0
    first_gain, second_gain, product = n, n + 1, n + 2
    for k in range(nodes):
        deviation, spread = deviations[k], spreads[k]
        for sample in range(samples_at[k], samples_at[k + 1]):
            for joint in range(2):
                of = rows[sample, joint, :d]
                left = right[sample, joint] + _product(of, deviation)
                freedom[0, joint] += _quadratic(spread, of)
                freedom[2, joint] += left * left
        if k == nodes - 1:
            break
        # The impulses are what the rows give, and have a spread beside that: (u0, u1) = (a, b) times independent ones.
        a, b = 1.0 / impulses[k, 0, 0], 1.0 / impulses[k, 1, 1]
        c = -impulses[k, 0, 1] * a * b
        for j in range(d + 1):
            place = 2 + j if j < d else last
            matrix[second_gain, j] = -impulses[k, 1, place] * b
            matrix[first_gain, j] = -impulses[k, 0, place] * a - impulses[k, 1, place] * c
        for torque in range(2):
            gain = first_gain + torque
            of, square = matrix[gain, :d], a * a + c * c if torque == 0 else b * b
            mean = matrix[gain, d] + _product(of, deviation)
            square += _quadratic(spread, of)
            torques[k, 0, torque], torques[k, 1, torque] = mean, math.sqrt(max(square, 0.0))
            freedom[1, torque] += 1.0 - square / sizes[k, torque] ** 2
            freedom[3, torque] += (mean / sizes[k, torque]) ** 2
        # Where the next node's state is, as a function of this deviation and of the two independent ones.
        for state in range(n):
            total = gaps[k, state]
            for j in range(d):
                total += transitions[k, state, j] * deviation[j]
                matrix[state, j] = transitions[k, state, j]
            matrix[state, d] = total
        for rod in range(2):
            state = _SPEEDS + rod
            for torque in range(2):
                matrix[state, d] += pushes[k, rod, torque] * torques[k, 0, torque]
                for j in range(d):
                    matrix[state, j] += pushes[k, rod, torque] * matrix[first_gain + torque, j]
        # The spread at the next node: T spread T' + what the independent ones add, T being rows of the state alone.
        later, spread_later = deviations[k + 1], spreads[k + 1]
        for j in range(d):
            later[j] = matrix[j, d] if j < n else deviation[j]
        for i in range(n, d):
            for j in range(n, d):
                spread_later[i, j] = spread[i, j]
        for state in range(n):
            for j in range(d):
                matrix[product + state, j] = _product(matrix[state, :d], spread[j])
        for state in range(n):
            for j in range(n, d):
                spread_later[state, j] = matrix[product + state, j]
                spread_later[j, state] = matrix[product + state, j]
            for j in range(state + 1):
                total = _product(matrix[product + state, :d], matrix[j, :d])
                if state >= _SPEEDS and j >= _SPEEDS and state < RODS_STATES:
                    one_a, other_a = pushes[k, state - _SPEEDS, 0], pushes[k, j - _SPEEDS, 0]
                    one_b, other_b = pushes[k, state - _SPEEDS, 1], pushes[k, j - _SPEEDS, 1]
                    total += one_a * other_a * a * a + (one_a * c + one_b * b) * (other_a * c + other_b * b)
                spread_later[state, j] = total
                spread_later[j, state] = total

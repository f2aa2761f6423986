"""The sweeps over the nodes of a swing: backwards for the information, forwards for the states (compiled).

Between nodes k and k + 1 the deviations x of the state from where it was linearised, and those of the unknowns p, obey
x[k+1] = A[k] (x[k], p) + c[k] + G[k] u[k], u being the impulses of unknown torques in both joints; what the encoders
show is off by H (x, p) + r. What all later readings say of (x, p) is a triangular matrix R and a right-hand side, so
that the sum of squares is |R (x, p) + z|^2 plus what nothing can change. It is carried backwards by orthogonal
transformations: the square-root information filter (Bierman, Factorization Methods for Discrete Sequential Estimation,
1977, chapters 5 and 6), which loses no digits where motion is chaotic.
"""

import math

from cdp_ident.machine.compilation import compiled, part
from cdp_ident.model.layout import RODS_STATES

_SPEEDS = RODS_STATES - 2
"""Where the rods' speeds are in a state, which impulses of torques change."""


@part
def triangularise(matrix, rows, columns):
    """Make the first rows and columns of a matrix an upper triangle, by Householder's reflections."""
    for j in range(min(columns, rows - 1)):
        square = 0.0
        for i in range(j, rows):
            square += matrix[i, j] * matrix[i, j]
        if square == 0.0:
            continue
        norm = -math.sqrt(square) if matrix[j, j] > 0.0 else math.sqrt(square)
        head = matrix[j, j] - norm
        scale = -1.0 / (norm * head)
        matrix[j, j] = norm
        for k in range(j + 1, columns):
            along = head * matrix[j, k]
            for i in range(j + 1, rows):
                along += matrix[i, j] * matrix[i, k]
            along *= scale
            matrix[j, k] -= along * head
            for i in range(j + 1, rows):
                matrix[i, k] -= along * matrix[i, j]
        for i in range(j + 1, rows):
            matrix[i, j] = 0.0


@compiled
def backwards(linear, samples_at, roots, memory, sizes, impulses, triangle, matrix):
    """Carry the information of all readings back to the first node, and return the logarithm of a determinant.

    Args:
        linear: see `Linearised`: A, c, G, H and r.
        samples_at: (nodes + 1,) where the samples of each node begin.
        roots: (samples, 2) one over the standard deviation of what is new in each reading's noise.
        memory: (samples, 2) how much of the noise of the reading before is still in each, 0 for the first ones.
        sizes: (2,) standard deviation of the impulses.
        impulses: (nodes, 2, d + 3) takes the rows that give them: derivatives by both, by state and unknowns, the rest.
        triangle: (d + 1, d + 1) takes R and z at the first node.
        matrix: memory for d + 5 + 2 times the most samples of a node rows, d + 3 columns.
    """
    transitions, gaps, pushes, slopes = linear.transitions, linear.gaps, linear.pushes, linear.slopes
    residuals = linear.residuals
    nodes, n, d = transitions.shape
    logarithm = 0.0
    for i in range(d + 1):
        for j in range(d + 1):
            triangle[i, j] = 0.0
    for k in range(nodes - 1, -1, -1):
        rows = 2
        for i in range(2):
            for j in range(d + 3):
                matrix[i, j] = 0.0
            matrix[i, i] = 1.0 / sizes[i]
        if k < nodes - 1:
            for i in range(d + 1):
                for torque in range(2):
                    matrix[rows, torque] = (
                        triangle[i, _SPEEDS] * pushes[k, 0, torque] + triangle[i, _SPEEDS + 1] * pushes[k, 1, torque]
                    )
                for j in range(d):
                    total = triangle[i, j] if j >= n else 0.0
                    for state in range(n):
                        total += triangle[i, state] * transitions[k, state, j]
                    matrix[rows, 2 + j] = total
                total = triangle[i, d]
                for state in range(n):
                    total += triangle[i, state] * gaps[k, state]
                matrix[rows, 2 + d] = total
                rows += 1
            # The next node's first readings have noise that remembers this one's last.
            first = samples_at[k + 1]
            for joint in range(2 if samples_at[k + 2] > first else 0):
                root, remembered = roots[first, joint], memory[first, joint]
                for torque in range(2):
                    matrix[rows, torque] = root * (
                        slopes[first, joint, _SPEEDS] * pushes[k, 0, torque]
                        + slopes[first, joint, _SPEEDS + 1] * pushes[k, 1, torque]
                    )
                for j in range(d):
                    total = slopes[first, joint, j] if j >= n else 0.0
                    for state in range(n):
                        total += slopes[first, joint, state] * transitions[k, state, j]
                    before = remembered * slopes[first - 1, joint, j] if remembered != 0.0 else 0.0
                    matrix[rows, 2 + j] = root * (total - before)
                total = residuals[first, joint]
                for state in range(n):
                    total += slopes[first, joint, state] * gaps[k, state]
                before = remembered * residuals[first - 1, joint] if remembered != 0.0 else 0.0
                matrix[rows, 2 + d] = root * (total - before)
                rows += 1
        for sample in range(samples_at[k] + (1 if k > 0 else 0), samples_at[k + 1]):
            for joint in range(2):
                root, remembered = roots[sample, joint], memory[sample, joint]
                matrix[rows, 0], matrix[rows, 1] = 0.0, 0.0
                for j in range(d):
                    before = remembered * slopes[sample - 1, joint, j] if remembered != 0.0 else 0.0
                    matrix[rows, 2 + j] = root * (slopes[sample, joint, j] - before)
                before = remembered * residuals[sample - 1, joint] if remembered != 0.0 else 0.0
                matrix[rows, 2 + d] = root * (residuals[sample, joint] - before)
                rows += 1
        triangularise(matrix, rows, d + 3)
        for i in range(2):
            logarithm += 2.0 * math.log(abs(matrix[i, i]) * sizes[i])
            for j in range(d + 3):
                impulses[k, i, j] = matrix[i, j]
        for i in range(d + 1):
            for j in range(d + 1):
                triangle[i, j] = matrix[2 + i, 2 + j] if 2 + i < rows else 0.0
    return logarithm


@compiled
def forwards(transitions, gaps, pushes, impulses, deviation, change, states, torques):
    """Move the states at all nodes to the most likely ones, and fill in the impulses (nodes, 2).

    Given are the deviation (d,) at the first node, of the state and of the unknowns, and memory (n,).
    """
    nodes, n, d = transitions.shape
    for k in range(nodes):
        for state in range(n):
            states[k, state] += deviation[state]
        if k == nodes - 1:
            break
        first, second = impulses[k, 0, d + 2], impulses[k, 1, d + 2]
        for j in range(d):
            first += impulses[k, 0, 2 + j] * deviation[j]
            second += impulses[k, 1, 2 + j] * deviation[j]
        torques[k, 1] = -second / impulses[k, 1, 1]
        torques[k, 0] = -(first + impulses[k, 0, 1] * torques[k, 1]) / impulses[k, 0, 0]
        for state in range(n):
            total = gaps[k, state]
            for j in range(d):
                total += transitions[k, state, j] * deviation[j]
            change[state] = total
        for state in range(n):
            deviation[state] = change[state]
        for rod in range(2):
            for torque in range(2):
                deviation[_SPEEDS + rod] += pushes[k, rod, torque] * torques[k, torque]

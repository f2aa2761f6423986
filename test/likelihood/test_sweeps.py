"""The sweeps find what one large least-squares problem of all states, impulses and unknowns has as its solution."""

import numpy as np
import pytest

from cdp_ident.likelihood.sweeps import backwards, forwards
from cdp_ident.likelihood.swing import Linearised


def problem(rng, nodes=6, n=5, unknowns=3, memory=0.0):
    d = n + unknowns
    transitions = rng.normal(size=(nodes, n, d)) * 0.6
    gaps, pushes = rng.normal(size=(nodes, n)) * 0.1, rng.normal(size=(nodes, 2, 2))
    samples_at = np.concatenate([[0], np.cumsum(rng.integers(1, 4, nodes))])
    samples = int(samples_at[-1])
    remembered = np.full((samples, 2), memory)
    remembered[0] = 0.0
    slopes, residuals = rng.normal(size=(samples, 2, d)), rng.normal(size=(samples, 2))
    roots = rng.uniform(1.0, 3.0, (samples, 2))
    return transitions, gaps, pushes, slopes, residuals, samples_at, roots, remembered, rng.uniform(0.1, 1.0, 2)


def solved_at_once(transitions, gaps, pushes, slopes, residuals, samples_at, roots, remembered, sizes):
    """Return states (nodes, n), unknowns, impulses (nodes, 2), the sum of squares, and the logarithm of a determinant.

    The columns of the problem are the first state, the unknowns, and all impulses: later states follow from these.
    """
    nodes, n, d = transitions.shape
    unknowns, columns = d - n, d + 2 * (nodes - 1)
    states, constants = [np.eye(n, columns)], [np.zeros(n)]
    of_unknowns = np.zeros((unknowns, columns))
    of_unknowns[:, n:d] = np.eye(unknowns)
    for k in range(nodes - 1):
        state = transitions[k] @ np.vstack([states[-1], of_unknowns])
        state[2:4, d + 2 * k : d + 2 * k + 2] += pushes[k]
        constants.append(transitions[k][:, :n] @ constants[-1] + gaps[k])
        states.append(state)
    shown, left = np.zeros((len(slopes), 2, columns)), residuals.copy()
    for k in range(nodes):
        for j in range(samples_at[k], samples_at[k + 1]):
            shown[j] = slopes[j] @ np.vstack([states[k], of_unknowns])
            left[j] += slopes[j][:, :n] @ constants[k]
    rows, target = [], []
    for j in range(len(slopes)):
        for joint in range(2):
            before = remembered[j, joint]
            rows.append(roots[j, joint] * (shown[j, joint] - (before * shown[j - 1, joint] if before else 0.0)))
            target.append(roots[j, joint] * (left[j, joint] - (before * left[j - 1, joint] if before else 0.0)))
    impulses = np.zeros((2 * (nodes - 1), columns))
    impulses[:, d:] = np.diag(np.tile(1.0 / sizes, nodes - 1))
    matrix, right = np.vstack([*rows, impulses]), np.concatenate([target, np.zeros(len(impulses))])
    solution = np.linalg.lstsq(matrix, -right)[0]
    squares = float(np.sum((matrix @ solution + right) ** 2))
    found = np.array([state @ solution + constant for state, constant in zip(states, constants, strict=True)])
    logarithm = np.linalg.slogdet(matrix.T @ matrix)[1] + 2.0 * (nodes - 1) * np.log(sizes).sum()
    return found, solution[n:d], solution[d:].reshape(-1, 2), squares, logarithm


@pytest.mark.parametrize("memory", [0.0, 0.7])
@pytest.mark.parametrize("seed", range(4))
def test_they_solve_the_problem_of_all_states_impulses_and_unknowns_together(seed, memory):
    given = problem(np.random.default_rng(seed), memory=memory)
    nodes, n, d = given[0].shape
    triangle, impulses = np.empty((d + 1, d + 1)), np.empty((nodes, 2, d + 3))
    logarithm = backwards(
        Linearised(*given[:5], np.arange(d - n)), *given[5:], impulses, triangle, np.empty((d + 13, d + 3))
    )
    deviation = -np.linalg.solve(triangle[:d, :d], triangle[:d, -1])
    states, torques = np.zeros((nodes, n)), np.zeros((nodes, 2))
    forwards(*given[:3], impulses, deviation.copy(), np.empty(n), states, torques)
    expected = solved_at_once(*given)
    np.testing.assert_allclose(states, expected[0], atol=1e-9)
    np.testing.assert_allclose(deviation[n:], expected[1], atol=1e-9)
    np.testing.assert_allclose(torques[:-1], expected[2], atol=1e-9)
    assert triangle[d, d] ** 2 == pytest.approx(expected[3])
    whole = logarithm + 2.0 * np.sum(np.log(np.abs(np.diag(triangle)[:d])))
    assert whole == pytest.approx(expected[4])

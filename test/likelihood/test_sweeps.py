# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The sweeps find what one large least-squares problem of all states, impulses and unknowns has as its solution."""

import numpy as np
import pytest

from cdp_ident.likelihood.sweeps import Whitened, backwards, filter_rows, forwards


def problem(rng, nodes=6, n=5, unknowns=3):
    d = n + unknowns
    samples_at = np.concatenate([[0], np.cumsum(rng.integers(1, 4, nodes))])
    samples = int(samples_at[-1])
    return Whitened(
        transitions=rng.normal(size=(nodes, n, d)) * 0.6,
        gaps=rng.normal(size=(nodes, n)) * 0.1,
        pushes=rng.normal(size=(nodes, 2, 2)),
        rows=rng.normal(size=(samples, 2, d)),
        right=rng.normal(size=(samples, 2)),
        samples_at=samples_at,
        sizes=rng.uniform(0.1, 1.0, (nodes, 2)),
    )


class Dense:
    """The same at once: its columns are the first state, the unknowns and all impulses, from which the rest follows."""

    def __init__(self, swing):
        nodes, n, d = swing.transitions.shape
        columns = d + 2 * (nodes - 1)
        of_unknowns = np.eye(d, columns)[n:]
        states, constants = [np.eye(n, columns)], [np.zeros(n)]
        for k in range(nodes - 1):
            state = swing.transitions[k] @ np.vstack([states[-1], of_unknowns])
            state[2:4, d + 2 * k : d + 2 * k + 2] += swing.pushes[k]
            constants.append(swing.transitions[k][:, :n] @ constants[-1] + swing.gaps[k])
            states.append(state)
        shown, left = np.zeros((len(swing.rows), 2, columns)), swing.right.copy()
        for k in range(nodes):
            for j in range(swing.samples_at[k], swing.samples_at[k + 1]):
                shown[j] = swing.rows[j] @ np.vstack([states[k], of_unknowns])
                left[j] += swing.rows[j][:, :n] @ constants[k]
        self.shown, self.left, self.states, self.constants = shown, left, np.array(states), np.array(constants)
        self.of_unknowns, self.d, self.sizes = of_unknowns, d, swing.sizes
        impulses = np.eye(columns)[d:] / swing.sizes[:-1].reshape(-1, 1)
        self.matrix = np.vstack([shown.reshape(-1, columns), impulses])
        self.right = np.concatenate([left.ravel(), np.zeros(len(impulses))])
        self.covariance = np.linalg.inv(self.matrix.T @ self.matrix)
        self.solution = -self.covariance @ self.matrix.T @ self.right


def swept(swing, own=None, all_nodes=False, begins=None):
    (nodes, n, d), own = swing.transitions.shape, own or swing.transitions.shape[2]
    triangles, impulses = np.full((nodes, own, d + 1), np.nan), np.full((nodes, 2, d + 3), np.nan)
    others = np.full((nodes if all_nodes else 1, d + 1 - own, d + 1 - own), np.nan)
    most = int(np.diff(swing.samples_at).max())
    begins = np.zeros(d + 1 - own, dtype=np.int64) if begins is None else begins
    logarithm = backwards(swing, impulses, triangles, others, begins, np.empty((d + 3, own + 2 + 2 * most)))
    deviations, spreads = np.full((nodes, own), np.nan), np.full((nodes, own, own), np.nan)
    inverse = np.linalg.inv(triangles[0, :, :own])
    deviations[0], spreads[0] = -inverse @ triangles[0, :, d], inverse @ inverse.T
    torques, freedom = np.zeros((nodes, 2, 2)), np.full((4, 2), np.nan)
    forwards(swing, impulses, deviations, spreads, torques, freedom, np.empty((2 * n + 3, own + 1)))
    return logarithm, triangles, others, deviations, spreads, torques, freedom


@pytest.mark.parametrize("seed", range(4))
def test_they_solve_the_problem_of_all_states_impulses_and_unknowns_together(seed):
    swing = problem(np.random.default_rng(seed))
    dense, (logarithm, triangles, others, deviations, spreads, torques, freedom) = Dense(swing), swept(swing)
    nodes, n, d = swing.transitions.shape
    np.testing.assert_allclose(deviations[:, :n], dense.states @ dense.solution + dense.constants, atol=1e-9)
    np.testing.assert_allclose(deviations[:, n:], np.tile(dense.solution[n:d], (nodes, 1)), atol=1e-9)
    np.testing.assert_allclose(torques[:-1, 0].ravel(), dense.solution[d:], atol=1e-9)
    left = dense.matrix @ dense.solution + dense.right
    assert others[0, 0, 0] == pytest.approx(left @ left)
    whole = logarithm + 2.0 * np.sum(np.log(np.abs(np.diag(triangles[0]))))
    of_impulses = 2.0 * np.log(swing.sizes[:-1]).sum()
    assert whole == pytest.approx(np.linalg.slogdet(dense.matrix.T @ dense.matrix)[1] + of_impulses)
    # So are the covariances at each node and of each impulse,
    for spread, states in zip(spreads, dense.states, strict=True):
        both = np.vstack([states, dense.of_unknowns])
        np.testing.assert_allclose(spread, both @ dense.covariance @ both.T, atol=1e-9)
    variances = np.diag(dense.covariance)[d:].reshape(-1, 2)
    np.testing.assert_allclose(torques[:-1, 1], np.sqrt(variances), atol=1e-9)
    # and the degrees of freedom that readings and impulses take.
    taken = np.einsum("sje,ef,sjf->j", dense.shown, dense.covariance, dense.shown)
    np.testing.assert_allclose(freedom[0], taken)
    np.testing.assert_allclose(freedom[1], np.sum(1.0 - variances / swing.sizes[:-1] ** 2, axis=0))
    np.testing.assert_allclose(freedom[2], np.sum((dense.shown @ dense.solution + dense.left) ** 2, axis=0))
    np.testing.assert_allclose(freedom[3], np.sum((torques[:-1, 0] / swing.sizes[:-1]) ** 2, axis=0))
    # What is determined in all: the state, the unknowns, and as much of the impulses as readings decide.
    assert freedom[0].sum() == pytest.approx(d + freedom[1].sum())


@pytest.mark.parametrize("seed", range(4))
def test_candidates_keep_what_the_estimated_ones_do_not_explain(seed):
    swing = problem(np.random.default_rng(seed), unknowns=5)
    d, own = swing.transitions.shape[2], 7
    dense, (_, _, others, *_) = Dense(swing), swept(swing, own, all_nodes=True)
    at = np.arange(dense.matrix.shape[1])
    estimated = dense.matrix[:, (at < own) | (at >= d)]
    candidates = np.column_stack([dense.matrix[:, own:d], dense.right])
    left = candidates - estimated @ np.linalg.lstsq(estimated, candidates)[0]
    np.testing.assert_allclose(others[0], left.T @ left, atol=1e-9)
    np.testing.assert_allclose(others[0], swept(swing, own)[2][0], atol=1e-9)
    # Of two effects that are looked at side by side, each has products of its own and with the readings.
    apart = swept(swing, own, begins=np.array([0, *range(1, d - own), 0]))[2][0]
    wanted = np.eye(d + 1 - own, dtype=bool)
    wanted[-1] = wanted[:, -1] = True
    np.testing.assert_allclose(apart, np.where(wanted, others[0], 0.0), atol=1e-9)


def test_a_node_s_triangle_says_what_all_readings_from_it_on_say():
    swing = problem(np.random.default_rng(9))
    _, triangles, others, *_ = swept(swing, all_nodes=True)
    from_second = swing.samples_at[2]
    later = Whitened(
        *(part[2:] for part in swing[:3]), swing.rows[from_second:], swing.right[from_second:],
        swing.samples_at[2:] - from_second, swing.sizes[2:],
    )  # fmt: skip
    _, of_later, left, *_ = swept(later)
    for expected, found in ((of_later[0], triangles[2]), (left[0], others[2])):
        np.testing.assert_allclose(found.T @ found, expected.T @ expected, atol=1e-9)


def test_what_is_new_in_noise_does_not_depend_on_where_nodes_are():
    rng, samples, d = np.random.default_rng(3), 12, 6
    kept, mixed, follows = np.array([0.8, 0.6]), np.array([0.3, 0.0]), np.ones((samples, 2), dtype=bool)
    follows[0] = False
    follows[7, 0] = False
    right = rng.normal(size=(samples, 2))
    news = []
    for samples_at in (np.array([0, samples]), np.array([0, 3, 5, 10, samples])):
        nodes = len(samples_at) - 1
        new, transitions, gaps = right.copy(), np.zeros((nodes, d - 1, d)), np.zeros((nodes, d - 1))
        filter_rows(np.zeros((samples, 2, d)), right.copy(), new, follows, samples_at, kept, mixed, transitions, gaps)
        news.append(new)
    np.testing.assert_allclose(news[0], news[1])
    expected = right.copy()
    for k in range(1, samples):
        for joint in range(2):
            if follows[k, joint]:
                before = mixed[joint] * expected[k - 1, joint] - kept[joint] * right[k - 1, joint]
                expected[k, joint] += before
    np.testing.assert_allclose(news[0], expected)

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
        sizes=rng.uniform(0.1, 1.0, 2),
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
        impulses = np.eye(columns)[d:] / np.tile(swing.sizes, nodes - 1)[:, None]
        self.matrix = np.vstack([shown.reshape(-1, columns), impulses])
        self.right = np.concatenate([left.ravel(), np.zeros(len(impulses))])
        self.covariance = np.linalg.inv(self.matrix.T @ self.matrix)
        self.solution = -self.covariance @ self.matrix.T @ self.right


def swept(swing):
    nodes, n, d = swing.transitions.shape
    triangle, impulses = np.full((d, d + 1), np.nan), np.full((nodes, 2, d + 3), np.nan)
    most = int(np.diff(swing.samples_at).max())
    logarithm, rest = backwards(swing, impulses, triangle, np.empty((d + 3 + 2 * most, d + 3)))
    deviations, spreads = np.full((nodes, d), np.nan), np.full((nodes, d, d), np.nan)
    inverse = np.linalg.inv(triangle[:, :d])
    deviations[0], spreads[0] = -inverse @ triangle[:, d], inverse @ inverse.T
    torques, sums = np.zeros((nodes, 2, 2)), np.full((4, 2), np.nan)
    forwards(swing, impulses, deviations, spreads, torques, sums, np.empty((2 * n + 3, d + 1)))
    return logarithm, triangle, rest, deviations, spreads, torques, sums


@pytest.mark.parametrize("seed", range(4))
def test_they_solve_the_problem_of_all_states_impulses_and_unknowns_together(seed):
    swing = problem(np.random.default_rng(seed))
    dense, (logarithm, triangle, rest, deviations, _, torques, _) = Dense(swing), swept(swing)
    nodes, n, d = swing.transitions.shape
    np.testing.assert_allclose(deviations[:, :n], dense.states @ dense.solution + dense.constants, atol=1e-9)
    np.testing.assert_allclose(deviations[:, n:], np.tile(dense.solution[n:d], (nodes, 1)), atol=1e-9)
    np.testing.assert_allclose(torques[:-1, 0].ravel(), dense.solution[d:], atol=1e-9)
    left = dense.matrix @ dense.solution + dense.right
    assert rest == pytest.approx(left @ left)
    whole = logarithm + 2.0 * np.sum(np.log(np.abs(np.diag(triangle))))
    of_impulses = 2.0 * (nodes - 1) * np.log(swing.sizes).sum()
    assert whole == pytest.approx(np.linalg.slogdet(dense.matrix.T @ dense.matrix)[1] + of_impulses)


@pytest.mark.parametrize("seed", range(4))
def test_covariances_at_each_node_and_of_each_impulse_are_those_of_that_problem(seed):
    swing = problem(np.random.default_rng(seed))
    dense, (_, _, _, _, spreads, torques, _) = Dense(swing), swept(swing)
    for spread, states in zip(spreads, dense.states, strict=True):
        both = np.vstack([states, dense.of_unknowns])
        np.testing.assert_allclose(spread, both @ dense.covariance @ both.T, atol=1e-9)
    np.testing.assert_allclose(torques[:-1, 1].ravel(), np.sqrt(np.diag(dense.covariance)[dense.d :]), atol=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_degrees_of_freedom_are_what_readings_and_impulses_take(seed):
    swing = problem(np.random.default_rng(seed))
    dense, (*_, torques, freedom) = Dense(swing), swept(swing)
    taken = np.einsum("sje,ef,sjf->j", dense.shown, dense.covariance, dense.shown)
    of_impulses = np.diag(dense.covariance)[dense.d :].reshape(-1, 2) / swing.sizes**2
    np.testing.assert_allclose(freedom[0], taken)
    np.testing.assert_allclose(freedom[1], np.sum(1.0 - of_impulses, axis=0))
    np.testing.assert_allclose(freedom[2], np.sum((dense.shown @ dense.solution + dense.left) ** 2, axis=0))
    np.testing.assert_allclose(freedom[3], np.sum((torques[:-1, 0] / swing.sizes) ** 2, axis=0))
    # What is determined in all: the state, the unknowns, and as much of the impulses as readings decide.
    assert freedom[0].sum() == pytest.approx(dense.d + freedom[1].sum())


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

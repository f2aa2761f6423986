"""What a window's initial state accounts for, also where the window does not show all of it."""

import numpy as np
import pytest

from cdp_ident.fit.initial_states import InitialState, inverse_factor

RNG = np.random.default_rng(0)
ROWS = RNG.normal(size=(50, 4))
OTHER = RNG.normal(size=(50, 3))


def test_the_factor_is_that_of_the_inverse_for_each_matrix_of_a_stack():
    stack = np.array([ROWS.T @ ROWS, np.diag([1.0, 1e-12, 1e6, 3.0])])
    factors = inverse_factor(stack)
    np.testing.assert_allclose(factors @ factors.transpose(0, 2, 1) @ stack, [np.eye(4)] * 2, atol=1e-12)


@pytest.mark.parametrize("spread", [1.0, 1e-3, 1e-6])
def test_what_is_left_is_what_least_squares_leave(spread):
    rows = ROWS.copy()
    rows[:, 3] = rows[:, 0] + spread * rows[:, 3]  # almost parallel
    state = InitialState.of(rows)
    expected = OTHER - rows @ np.linalg.lstsq(rows, OTHER, rcond=None)[0]
    np.testing.assert_allclose(state.eliminated_from(OTHER), expected, atol=1e-8)
    np.testing.assert_allclose(OTHER - rows @ state.change_for(OTHER), expected, atol=1e-8)
    np.testing.assert_allclose(state.basis.T @ state.basis, np.eye(4), atol=1e-12)


@pytest.mark.parametrize("column", [np.zeros(50), ROWS[:, 0], 1e-40 * ROWS[:, 3], np.full(50, np.nan)])
def test_what_does_not_show_is_left_as_it_is(column):
    rows = ROWS.copy()
    rows[:, 3] = column
    shown = ROWS[:, :3]
    factor = inverse_factor(rows.T @ rows)
    assert np.all(np.isfinite(factor))
    if np.all(np.isfinite(column)):
        state = InitialState.of(rows)
        expected = OTHER - shown @ np.linalg.lstsq(shown, OTHER, rcond=None)[0]
        np.testing.assert_allclose(state.eliminated_from(OTHER), expected, atol=1e-12)
        assert np.all(np.abs(state.change_for(OTHER)) < 10)


def test_a_known_initial_state_accounts_for_nothing():
    state = InitialState.of(ROWS, known=True)
    assert np.array_equal(state.eliminated_from(OTHER), OTHER)
    assert not np.any(state.change_for(OTHER))
    assert not np.any(state.covariance)


def test_the_covariance_is_that_of_least_squares():
    np.testing.assert_allclose(InitialState.of(ROWS).covariance, np.linalg.inv(ROWS.T @ ROWS), rtol=1e-10)

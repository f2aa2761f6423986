"""Derivatives by unknowns follow from those by directions, by the chain rule."""

import numpy as np

from cdp_ident.model.unknowns import ChainRule

RULE = ChainRule(np.array([1, 0, -1, 4]), np.array([2, 2]), np.array([0, 3]), np.array([0.5, -2.0]))


def test_an_unknown_s_derivative_is_the_sum_over_the_directions_on_which_it_acts():
    derivatives = np.random.default_rng(0).normal(size=(3, 2, 4))
    found = RULE.by_unknowns(derivatives, 6)
    one, two, three, four = np.moveaxis(derivatives, 2, 0)
    expected = np.stack([two + 0.5 * three, one, np.zeros((3, 2)), -2.0 * three, four, np.zeros((3, 2))], axis=2)
    np.testing.assert_allclose(found, expected)


def test_of_fewer_directions_only_what_is_their_own_is_there():
    derivatives = np.random.default_rng(0).normal(size=(3, 2, 2))
    found = RULE.by_unknowns(derivatives, 6)
    np.testing.assert_array_equal(found[..., :2], derivatives[..., ::-1])
    assert not np.any(found[..., 2:])

"""What keeps curves smooth."""

import numpy as np
import pytest

from cdp_ident.fit.stiffness import penalties, penalty
from cdp_ident.model.effects.curves import CURVES

EACH = pytest.mark.parametrize(
    "curve", list(dict.fromkeys(effect.curve for effect in CURVES)), ids=lambda curve: curve.over
)


@EACH
def test_what_does_not_bend_is_not_held_by_its_bends(curve):
    bends, *_ = penalties(curve)
    even, rising = np.ones(curve.count), np.arange(curve.count, dtype=float)
    assert even @ bends @ even == pytest.approx(0.0, abs=1e-12)
    # Over a turn nothing can rise for ever.
    assert (rising @ bends @ rising == pytest.approx(0.0, abs=1e-9)) == (curve.over == "speed")


@EACH
def test_each_coefficient_is_of_one_part(curve):
    _, *sizes = penalties(curve)
    np.testing.assert_array_equal(sum(sizes), np.eye(curve.count))


@EACH
def test_a_penalty_is_the_weighted_sum(curve):
    weights = tuple(np.random.default_rng(0).uniform(size=len(penalties(curve))))
    values = np.random.default_rng(1).normal(size=curve.count)
    parts = [weight * values @ form @ values for weight, form in zip(weights, penalties(curve), strict=True)]
    assert values @ penalty(curve, weights) @ values == pytest.approx(sum(parts))

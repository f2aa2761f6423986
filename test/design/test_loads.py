# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the rods may carry in a next trial."""

import pytest

from cdp_ident.design.loads import loads_of, telling_weight
from scenarios.next_swing import PRIOR
from scenarios.weighted import WEIGHT


def test_starts_are_tried_without_a_weight_and_with_each_set_of_them_once():
    assert loads_of([]) == ((),)
    assert loads_of([(WEIGHT,), (), (WEIGHT,)]) == ((), (WEIGHT,))


def test_a_weight_that_would_show_the_inertia_adds_a_tenth_of_it_at_the_end_of_the_outer_rod(known):
    weight = telling_weight(known)
    assert weight.added(PRIOR.length)[0] == pytest.approx(0.1 * known.model.mechanism.inertia, rel=0.05)
    assert (weight.rod, weight.place) == ("outer", known.model.mechanism.outer_length)
    assert (weight.mass_std, weight.place_std) == (pytest.approx(0.01 * weight.mass), 1e-3)

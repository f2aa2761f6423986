# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What weights add to the pendulum's inertias and moments, held against rods that have them."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.model.parameters import SYMBOLS, groups_of, inertia_about_cart
from cdp_ident.model.weights import Weight, added_by, mass_beyond
from reference.pendulum import TABLE_5
from reference.weights import with_weight

LENGTH = TABLE_5["L"]
INNER = Weight("inner", 0.08, 0.25, 3e-5, 0.001, 0.002)
OUTER = Weight("outer", 0.05, 0.3, 2e-5, 0.0005, 0.001)


def numerators(values):
    """Return A22 and the numerators of the groups."""
    physical = np.array([values[symbol] for symbol in SYMBOLS])
    inertia = inertia_about_cart(physical, values["L"])
    return inertia * np.append(1.0, groups_of(physical, values["L"]))


@pytest.mark.parametrize("weights", [(INNER,), (OUTER,), (INNER, OUTER)])
def test_a_weight_adds_what_a_rod_with_it_has_more(weights):
    heavier = TABLE_5
    for weight in weights:
        heavier = with_weight(heavier, weight.rod, weight.mass, weight.place, weight.inertia)
    assert added_by(weights, LENGTH) == pytest.approx(numerators(heavier) - numerators(TABLE_5), abs=1e-15)


@pytest.mark.parametrize("weight", [INNER, OUTER])
def test_derivatives_by_length_mass_and_place_are_those_of_differences(weight):
    step = 1e-6
    by_length = (weight.added(LENGTH + step) - weight.added(LENGTH - step)) / (2 * step)
    assert weight.by_length(LENGTH) == pytest.approx(by_length, abs=1e-9)
    for error in weight.errors:
        sides = [weight.with_errors({error: sign * step}).added(LENGTH) for sign in (1, -1)]
        assert weight.by_error(error, LENGTH) == pytest.approx((sides[0] - sides[1]) / (2 * step), abs=1e-12)


def test_errors_are_in_standard_deviations_and_what_is_exact_has_none():
    off = OUTER.with_errors({("mass", None, 0.05): 2.0, ("place", "outer", 0.3): -1.0, ("place", "inner", 0.3): 5.0})
    assert (off.mass, off.place) == pytest.approx((0.051, 0.299))
    assert replace(OUTER, mass_std=0.0).errors == (("place", "outer", 0.3),)
    assert replace(OUTER, mass_std=0.0, place_std=0.0).errors == ()


def test_the_same_weight_and_the_same_clamping_have_one_error():
    elsewhere, heavier = replace(OUTER, place=0.2), replace(OUTER, mass=0.08)
    errors = [set(weight.errors) for weight in (OUTER, elsewhere, heavier)]
    assert errors[0] & errors[1] == {("mass", None, 0.05)}
    assert errors[0] & errors[2] == {("place", "outer", 0.3)}
    assert not errors[1] & errors[2]


def test_the_outer_joint_carries_what_is_on_the_outer_rod_and_the_others_all():
    assert [mass_beyond((INNER, OUTER), joint) for joint in ("inner", "outer", "base")] == pytest.approx(
        [0.13, 0.05, 0.13]
    )

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From the base parameters to the nearest possible physical values."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.fit.physical import logarithmic_derivatives, nearest_physical_values, shown_by_trials
from cdp_ident.fit.prior import Prior
from cdp_ident.model.parameters import SYMBOLS, groups_of
from reference.pendulum import TABLE_5
from reference.strategies import pendulums
from scenarios.paper_rig import GROUPS, LENGTH
from scenarios.paper_rig import PHYSICAL as TRUTH

SMALL = np.diag((0.002 * GROUPS) ** 2)
M1, M2, M0, L1, L2, J1, J2, C1, C2 = range(9)


def nearest(groups=GROUPS, prior=None, covariance=SMALL):
    return nearest_physical_values(groups, covariance, prior or Prior(), LENGTH)


def distance(values, prior):
    """Return the squared distance from the prior that the choice is made by; frictions follow from the others."""
    inertial = slice(M1, C1)
    return np.sum((np.log(values / prior.centre) / prior.relative_std)[..., inertial] ** 2, axis=-1)


def is_possible(values):
    m1, m2, _, l1, l2, j1, j2, *_ = np.moveaxis(values, -1, 0)
    return (j1 <= m1 * l1 * (LENGTH - l1) * (1 + 1e-6)) & (
        j2 <= m2 * l2 * (np.maximum(LENGTH, 2 * l2) - l2) * (1 + 1e-6)
    )


@given(values=pendulums())
def test_the_values_have_the_groups_and_are_positive_and_are_found_where_there_are_any(values):
    truth = np.array([values[symbol] for symbol in SYMBOLS])
    groups = groups_of(truth, LENGTH)
    found = nearest(groups, covariance=np.diag((0.002 * groups) ** 2))
    assert found.possible or not is_possible(truth)
    if found.possible:
        assert groups_of(found.values, LENGTH) == pytest.approx(groups, rel=1e-5)
        assert np.all(found.values > 0)
        assert np.all(np.isfinite(found.std))
        assert is_possible(found.values)


def test_nominal_values_are_their_own_nearest():
    prior = Prior()
    found = nearest(groups_of(prior.centre, LENGTH), prior)
    assert found.possible
    assert found.values == pytest.approx(prior.centre, rel=1e-4)


def test_no_other_values_with_the_groups_are_nearer():
    prior = Prior()
    found = nearest(prior=prior)
    assert found.possible
    assert is_possible(found.values)
    # All inertial parameters with three given groups: choose m1, l1, J1 and l2 freely (the scale is arbitrary), and
    # the base parameters give m2, m0 and J2.
    rng = np.random.default_rng(0)
    near = found.values * np.exp(rng.normal(0, 1, (400_000, 9)) * rng.choice([0.003, 0.03, 0.3], (400_000, 1)))
    m1, l1, j1, l2 = near[:, M1], near[:, L1], near[:, J1], near[:, L2]
    a23, a33, a1, *_ = GROUPS
    # a1 A22 = m1 l1 + (m2 + m0) L and A22 = m1 l1^2 + J1 + (m2 + m0) L^2 are linear in A22 and m2 + m0.
    inertia = (m1 * l1**2 + j1 - LENGTH * m1 * l1) / (1 - LENGTH * a1)
    outer = (a1 * inertia - m1 * l1) / LENGTH
    m2 = a23 * inertia / (LENGTH * l2)
    others = np.stack(
        [m1, m2, outer - m2, l1, l2, j1, a33 * inertia - m2 * l2**2, GROUPS[3] * inertia, GROUPS[4] * inertia], axis=1
    )
    others = others[np.all(others > 0, axis=1)]
    others = others[is_possible(others)]
    assert len(others) > 10_000
    assert np.allclose(groups_of(others, LENGTH), GROUPS, rtol=1e-6)
    best = distance(others, prior).min()
    assert distance(found.values, prior) <= best * (1 + 1e-6)
    assert best < 1.5 * distance(found.values, prior)  # or the random search has not looked near enough to object


def test_rounding_of_the_groups_does_not_lose_the_values():
    """At the minimum for these groups, of a measured swing, the method often does not notice that it has converged."""
    nominal = {"m1": 0.0938, "m2": 0.1376, "m0": 0.0, "l1": 0.1086, "l2": 0.1168, "J1": 4.4e-4, "J2": 1.27e-3,
               "c1": 2.4e-4, "c2": 1.0e-5}  # fmt: skip
    groups = np.array([0.49296044157, 0.55997662032, 6.01194465691, 0.02050552511, 0.00209927848])
    rng = np.random.default_rng(0)
    every = [
        nearest_physical_values(groups * (1 + error), np.diag((1e-3 * groups) ** 2), Prior(nominal=nominal), 0.17272)
        for error in rng.normal(scale=1e-12, size=(30, 5))
    ]
    assert all(each.possible for each in every)
    assert [each.values[M1] for each in every] == pytest.approx([0.09395] * len(every), rel=1e-4)


def test_an_inertia_that_no_rod_of_that_mass_and_length_has_is_not_chosen():
    # A prior that wants J1 far above m1 l1 (L - l1) must give way.
    prior = Prior(nominal={"J1": 0.02})
    found = nearest(prior=prior)
    assert is_possible(found.values)
    assert found.values[J1] < 0.01


def test_groups_alone_determine_no_physical_value_and_leave_the_truth_within_their_uncertainty():
    found = nearest()
    assert np.all(np.abs(found.values - TRUTH) < 3 * found.std)
    assert not np.any(found.determined)
    assert not nearest(np.array([3.0, 0.1, 2.0, 0.1, 0.1])).possible


def test_a_known_mass_makes_the_friction_relative_to_it_determined_but_only_with_enough_others():
    found = nearest(prior=Prior(known={"m1": TABLE_5["m1"]}))
    assert found.values[M1] == pytest.approx(TABLE_5["m1"], rel=0.02)
    assert found.determined[M1]
    assert not np.all(found.determined)


def test_four_measured_values_determine_all_and_give_the_truth():
    known = {symbol: TABLE_5[symbol] for symbol in ("m1", "m2", "m0", "l1")}
    found = nearest(prior=Prior(known=known, known_std={symbol: 1e-5 * value for symbol, value in known.items()}))
    assert np.all(found.determined)
    assert found.values == pytest.approx(TRUTH, rel=1e-3)


def test_better_groups_give_surer_values_where_they_are_determined():
    prior = Prior(known={symbol: TABLE_5[symbol] for symbol in ("m1", "m2", "m0", "l1")})
    rough = nearest(prior=prior, covariance=100 * SMALL)
    assert np.all(nearest(prior=prior).std[[J2, C1, C2]] < rough.std[[J2, C1, C2]])


def test_a_friction_of_zero_stays_zero_with_its_group_s_deviation():
    groups = GROUPS * [1, 1, 1, 1, 0]
    spread = np.diag([*np.diag(SMALL)[:4], 1e-3**2])
    found = nearest(groups, covariance=spread)
    assert found.possible
    assert found.values[C2] == 0.0
    inertia = groups_of(np.array([*found.values[:C1], 1.0, 1.0]), LENGTH)[4] ** -1
    assert found.std[C2] == pytest.approx(1e-3 * inertia)


def test_a_group_about_which_nothing_is_known_says_nothing():
    spread = SMALL.copy()
    spread[4, 4] = np.inf
    known = Prior(known={symbol: TABLE_5[symbol] for symbol in ("m1", "m2", "m0", "l1")})
    found = nearest(covariance=spread, prior=known)
    assert not found.determined[C2]
    assert found.determined[C1]
    assert np.all(np.isfinite(found.std))


def test_a_rig_without_an_encoder_between_the_rods_has_none_found():
    values = TRUTH * [1, 1, 0, 1, 1, 1, 1, 1, 1]
    found = nearest(groups_of(values, LENGTH), Prior(nominal={"m0": 0.0}))
    assert found.values[M0] == 0.0
    assert not found.determined[M0]


def test_with_A22_the_chosen_values_have_it_and_frictions_are_determined():  # noqa: N802 - a symbol
    shown = shown_by_trials(TRUTH, LENGTH, with_inertia=True)
    found = nearest(shown, covariance=np.diag((0.002 * shown) ** 2))
    assert shown_by_trials(found.values, LENGTH, with_inertia=True) == pytest.approx(shown, rel=1e-5)
    assert found.determined.tolist() == [*7 * [False], True, True]
    assert found.values[C1:] == pytest.approx(TRUTH[C1:], rel=1e-5)
    assert found.std[C1] == pytest.approx(np.sqrt(2) * 0.002 * TRUTH[C1], rel=0.01)
    assert found.inertia_relative_std == pytest.approx(0.002, rel=0.01)


@given(values=pendulums(), scale=st.floats(0.5, 2.0))
def test_scaling_all_masses_inertias_and_frictions_changes_nothing_but_A22(values, scale):  # noqa: N802 - a symbol
    physical = scale * np.array([values[symbol] for symbol in SYMBOLS])
    scaled = np.array([symbol not in ("l1", "l2") for symbol in SYMBOLS], dtype=float)
    assert logarithmic_derivatives(physical, LENGTH) @ scaled == pytest.approx(np.zeros(5), abs=1e-7)
    slopes = logarithmic_derivatives(physical, LENGTH, with_inertia=True) @ scaled
    assert slopes == pytest.approx([0, 0, 0, 0, 0, -1], abs=1e-7)


def test_a_factor_of_three_in_all_masses_fits_into_the_interval_where_only_the_paper_s_rig_is_known():
    guessed = nearest()
    assert 1.0 + 1.96 * guessed.inertia_relative_std > 3.0
    assert nearest(prior=Prior(nominal={"m1": 0.11, "m2": 0.11})).inertia_relative_std < 0.3
    weighed = nearest(prior=Prior(known={"m2": guessed.values[M2]}))
    assert weighed.inertia_relative_std == pytest.approx(guessed.inertia_std_once_weighed, rel=0.02)

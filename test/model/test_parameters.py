# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
from hypothesis import given

from cdp_ident.errors import OptionError
from cdp_ident.model.parameters import (
    COEFFICIENTS,
    GROUPS,
    NOMINAL,
    PARAMETERS,
    SYMBOLS,
    coefficients_of,
    groups_of,
    inertia_about_cart,
    physical_coefficients,
)
from reference.pendulum import TABLE_2, TABLE_5
from reference.strategies import pendulums

EQUATION_9 = {  # its two lines exchanged; the lower limits of c1 and c2 as printed
    "m1": (0.054, 0.216),
    "m2": (0.054, 0.216),
    "m0": (0.104, 0.416),
    "l1": (0.18, 0.36),
    "l2": (0.12, 0.24),
    "J1": (0.00066, 0.00266),
    "J2": (0.00066, 0.00266),
    "c1": (0.00353, 0.03528),
    "c2": (0.00153, 0.01528),
}


def chromosome(values):
    return np.array([values[symbol] for symbol in SYMBOLS])


def test_nominal_values_are_table_2_and_the_chromosome_is_equation_8_with_its_second_m1_mended():
    assert pytest.approx(TABLE_2) == NOMINAL
    assert SYMBOLS == ("m1", "m2", "m0", "l1", "l2", "J1", "J2", "c1", "c2")


@pytest.mark.parametrize("parameter", PARAMETERS, ids=lambda parameter: parameter.symbol)
def test_the_default_box_is_equation_9_its_lines_exchanged_and_lower_frictions_a_tenth(parameter):
    lowest, highest = EQUATION_9[parameter.symbol]
    if parameter.symbol in ("c1", "c2"):
        lowest /= 10
    assert parameter.nominal * parameter.lower_factor == pytest.approx(lowest, rel=0.01)
    assert parameter.nominal * parameter.upper_factor == pytest.approx(highest, rel=0.01)
    assert parameter.description
    assert parameter.unit


def test_the_papers_own_results_lie_in_the_default_box_but_not_in_the_printed_one():
    assert all(p.nominal * p.lower_factor < TABLE_5[p.symbol] < p.nominal * p.upper_factor for p in PARAMETERS)
    assert TABLE_5["c2"] < EQUATION_9["c2"][0]


def test_groups_of_table_2_are_those_computed_by_hand():
    # A22 = 0.108 * 0.04 + 0.00133 + 0.316 * 0.16 = 0.05621
    A22 = 0.05621
    expected = [0.00864 / A22, 0.00565 / A22, 0.148 / A22, 0.00705 / A22, 0.00305 / A22]
    assert inertia_about_cart(chromosome(TABLE_2), 0.4) == pytest.approx(A22)
    np.testing.assert_allclose(groups_of(chromosome(TABLE_2), 0.4), expected, rtol=1e-12)


@given(values=pendulums())
def test_groups_are_exactly_five_independent_numbers(values):
    # Relative derivatives of the logarithms of the groups, by central differences.
    nudged = (chromosome(values) * (1.0 + side * 1e-6 * np.eye(len(SYMBOLS))) for side in (1, -1))
    jacobian = np.subtract(*(np.log(groups_of(points, values["L"])) for points in nudged)) / 2e-6
    assert np.linalg.matrix_rank(jacobian, tol=1e-4) == len(GROUPS) == 5


def test_groups_of_many_chromosomes_are_the_groups_of_each_and_coefficients_have_length_and_gravity_too():
    many = np.array([[chromosome(TABLE_2), chromosome(TABLE_5)]] * 3)
    assert groups_of(many, 0.4).shape == (3, 2, 5)
    np.testing.assert_array_equal(groups_of(many, 0.4)[1, 1], groups_of(chromosome(TABLE_5), 0.4))
    coefficients = coefficients_of(groups_of(many, 0.4), 0.4, 9.81)
    assert coefficients.shape == (3, 2, len(COEFFICIENTS))
    np.testing.assert_array_equal(coefficients[1, 0], physical_coefficients(TABLE_2))
    np.testing.assert_array_equal(coefficients[1, 0], [*groups_of(chromosome(TABLE_2), 0.4), 0.4, 9.81])


NONE = [{"m1": np.nan}, {"L": 0.0}, {"L": -0.4}, {"J2": -0.01}, {"m1": -0.1}, {"c2": -0.001}, {"m2": 0.0, "J2": 0.0},
        {"m1": 0.0, "m2": 0.0, "m0": 0.0, "J1": 0.0}]  # fmt: skip


@pytest.mark.parametrize("change", NONE, ids=str)
def test_values_that_describe_no_mechanism_are_refused_and_named(change):
    (symbol, value), *_ = change.items()
    with pytest.raises(OptionError, match=f"no mechanism: .* {symbol} = {value:g}"):
        physical_coefficients(TABLE_2 | change)


def test_missing_values_are_named():
    with pytest.raises(OptionError, match="parameters m0, L are missing"):
        physical_coefficients({symbol: value for symbol, value in TABLE_2.items() if symbol not in ("m0", "L")})

"""Numbers as people read them."""

import math

import pytest

from cdp_ident.report.formatting import chance, interval, milliradians, odds, per_cent, unit, with_std


@pytest.mark.parametrize(
    ("value", "std", "text"),
    [
        (0.123456, 0.00234, "0.1235 ± 0.0023"),
        (1234.5, 67.0, "1234 ± 67"),
        (0.4, 0.0, "0.4"),
        (0.1, math.inf, "0.1 ± inf"),
        (0.0, 3e-13, "0 ± 3e-13"),
    ],
)
def test_a_value_is_as_long_as_its_deviation_allows(value, std, text):
    assert with_std(value, std) == text


def test_an_interval_is_two_deviations_to_either_side():
    assert interval(1.0, 0.1) == "0.80 to 1.20"
    assert interval(1.0, math.inf) == "-inf to inf"


def test_a_number_without_a_unit_has_none_and_one_that_is_not_finite_is_a_dash_or_infinite():
    assert (unit("1"), unit("1/s")) == ("", "1/s")
    assert [milliradians(error) for error in (0.0045678, math.inf)] == ["4.568", "inf"]
    assert [per_cent(share) for share in (97.123456, math.nan, -math.inf)] == ["97.12", "–", "–"]


@pytest.mark.parametrize(("probability", "said"), [(0.0, "< 0.1 %"), (0.875, "87.5 %"), (1.0, "> 99.9 %")])
def test_no_probability_is_0_or_1(probability, said):
    assert chance(probability) == said


@pytest.mark.parametrize(
    ("log10_odds", "said"),
    [(1.0, "10 : 1"), (-1.0, "0.1 : 1"), (494.1, "10^494 : 1"), (math.inf, "–"), (math.nan, "–")],
)
def test_large_odds_are_powers_of_ten(log10_odds, said):
    assert odds(log10_odds) == said

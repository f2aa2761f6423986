# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is known before any trial."""

import numpy as np
import pytest

from cdp_ident.errors import OptionError
from cdp_ident.fit.prior import Prior
from cdp_ident.model.parameters import NOMINAL, PARAMETERS, SYMBOLS


def of(values, symbol):
    return values[SYMBOLS.index(symbol)]


def test_without_anything_known_it_is_the_paper_s_rig():
    prior = Prior()
    assert np.array_equal(prior.centre, [NOMINAL[symbol] for symbol in SYMBOLS])
    assert (prior.length, prior.gravity) == (0.4, 9.81)
    assert np.array_equal(
        prior.box,
        [
            [p.nominal * p.lower_factor for p in PARAMETERS],
            [p.nominal * p.upper_factor for p in PARAMETERS],
        ],
    )
    assert not np.any(prior.is_known)


@pytest.mark.parametrize(
    ("given", "symbol", "limits"),
    [
        ({"nominal": {"m1": 0.2, "L": 0.3}}, "m1", [0.1, 0.4]),
        # Given limits take the place of the paper's.
        ({"lower": {"m1": 0.0}, "upper": {"m1": 0.5}}, "m1", [0.0, 0.5]),
        # It may be missing from the rig.
        ({"nominal": {"m0": 0.0}}, "m0", [0.0, 0.0]),
    ],
)
def test_the_box_is_about_nominal_values_or_as_it_is_given(given, symbol, limits):
    prior = Prior(**given)
    assert [of(limit, symbol) for limit in prior.box] == limits
    nominal = NOMINAL | given.get("nominal", {})
    assert (of(prior.centre, symbol), prior.length) == (nominal[symbol], nominal["L"])


def test_a_known_value_takes_the_place_of_the_nominal_one_and_is_surer():
    prior = Prior(nominal={"m1": 0.2}, known={"m1": 0.15, "l1": 0.21}, known_std={"l1": 0.0021 / 2})
    assert of(prior.centre, "m1") == 0.15
    assert of(prior.is_known, "m1")
    assert of(prior.relative_std, "m1") == pytest.approx(0.01)
    assert of(prior.relative_std, "l1") == pytest.approx(0.005)
    assert of(prior.relative_std, "m2") > 0.3


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"nominal": {"L": 40.0}}, "L is 40 m; expected 0.005 to 10 m: in another unit?"),
        ({"nominal": {"L": 400}}, "L is 400 m; expected"),
        ({"nominal": {"g": 981.0}}, "g is 981 m/s^2; expected 0.0981 to 98.1 m/s^2"),
        ({"nominal": {"m3": 1.0}}, "unknown parameter in nominal: 'm3'"),
        ({"known": {"L": 0.4}}, "unknown parameter in known: 'L'"),
        ({"nominal": {"m1": -0.1}}, "nominal.m1 is -0.1; it must be a positive number"),
        ({"nominal": {"m1": 0.0}}, "nominal.m1 is 0.0; it must be a positive number"),
        ({"upper": {"J1": np.nan}}, "upper.J1 is nan"),
        ({"known": {"m1": 0.1}, "known_std": {"m2": 0.1}}, "known_std.m2 is given, but known.m2 is not: give both"),
        ({"lower": {"m1": 0.5}}, "lower.m1 is 0.5, above upper.m1, 0.216: exchange them"),
    ],
)
def test_what_cannot_be_is_refused(options, message):
    with pytest.raises(OptionError) as caught:
        Prior(**options)
    assert message in str(caught.value)

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What trials determine, and what they cannot tell apart."""

import tempfile
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from cdp_ident.diagnosis.identifiability import Tradeoff, identifiability
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.fit.physical import is_determined
from cdp_ident.fit.prior import Prior
from cdp_ident.model.parameters import GROUPS, SYMBOLS, groups_of
from cdp_ident.pipeline.identify import identify
from reference.pendulum import TABLE_5
from scenarios.clean_bags import clean_trials
from scenarios.weighted import plain_and_weighted


@cache
def trial():
    with tempfile.TemporaryDirectory() as folder:
        return clean_trials(Path(folder), swing=8.0)[0]


@cache
def identified(**options):
    known = options.pop("known", ())
    prior = Prior(known={symbol: TABLE_5[symbol] for symbol in known})
    return identify([trial()], [], IdentifyOptions(prior=prior, **options))


def test_a_free_swing_shows_all_five_groups_and_no_physical_value():
    found = identified()
    result = identifiability(found)
    assert (result.undetermined, result.determined_physical, result.unseen_changes) == ((), (), ())
    assert "determine no physical value" in " ".join(result.words)
    # Combinations come with falling singular values and unit length; L, of which something is known, is among them.
    values = [direction.singular_value for direction in result.directions]
    assert values == sorted(values, reverse=True)
    assert len(values) == len(GROUPS) + 1
    for direction in result.directions:
        powers = np.array(list(direction.exponents.values()))
        assert np.sum(powers**2) == pytest.approx(1.0)
        # The singular value is the inverse of the uncertainty where residuals are white.
        gradient = powers / found.fit.values
        assert 0.5 < np.sqrt(gradient @ found.covariance @ gradient) * direction.singular_value < 2.0


def test_each_tradeoff_leaves_the_groups_as_they_are_and_together_they_are_all_there_is():
    found = identified()
    tradeoffs = identifiability(found).physical_changes_without_effect
    assert len(tradeoffs) == len(SYMBOLS) - len(GROUPS)
    before = groups_of(found.physical.values, 0.4)
    moves = []
    for tradeoff in tradeoffs:
        move = np.array([tradeoff.get(symbol, 0.0) for symbol in SYMBOLS])
        moves.append(move)
        after = groups_of(found.physical.values * np.exp(1e-4 * move), 0.4)
        assert np.allclose(after, before, rtol=1e-7)
    assert np.linalg.matrix_rank(moves) == len(moves)


def test_the_common_factor_is_named_first_and_m1_cannot_be_told_from_j1():
    first, *others = identifiability(identified()).physical_changes_without_effect
    assert set(first) == {"m1", "m2", "m0", "J1", "J2", "c1", "c2"}
    assert str(first).endswith("can all be multiplied by one factor without changing the motion")
    assert any(set(tradeoff) == {"m1", "J1", "l1"} for tradeoff in others)


def test_measuring_what_is_asked_for_makes_everything_determinable():
    asked = identifiability(identified()).to_measure
    assert asked == ("m1", "m2", "m0", "l1")
    result = identifiability(identified(known=asked))
    assert result.determined_physical == SYMBOLS
    assert (result.physical_changes_without_effect, result.to_measure) == ((), ())
    assert any("determine l2, J1, J2, c1 and c2" in sentence for sentence in result.words)


def test_a_measured_mass_fixes_the_scale():
    result = identifiability(identified(known=("m1",)))
    assert not any("m1" in tradeoff for tradeoff in result.physical_changes_without_effect)
    assert result.to_measure == ("m2", "m0", "l1")


def test_with_length_and_gravity_free_they_cannot_be_told_from_a1():
    result = identifiability(identified(length_std=np.inf, gravity_std=np.inf))
    (tradeoff,) = result.unseen_changes
    assert tradeoff == pytest.approx({"a1_over_A22": 1.0, "L": -1.0, "g": -1.0}, abs=1e-6)
    assert set(result.undetermined) == {"a1_over_A22", "L", "g"}


@pytest.mark.parametrize(("free", "word"), [("length_std", "strength of g"), ("gravity_std", "strength of L")])
def test_length_or_gravity_alone_is_determined_on_the_strength_of_the_other(free, word):
    result = identifiability(identified(**({"length_std": 0.0} | {free: np.inf})))
    assert (result.undetermined, result.unseen_changes) == ((), ())
    assert any(word in sentence for sentence in result.words)


@cache
def identified_with_a_weight(**options):
    return identify(plain_and_weighted(np.random.default_rng(2)), [], IdentifyOptions(**options))


def test_a_weight_determines_A22_and_takes_the_common_factor_away():  # noqa: N802 - a symbol
    result = identifiability(identified_with_a_weight())
    assert result.determined_physical == ("c1", "c2")
    assert result.to_measure == ("m1", "m2", "m0")
    assert len(result.physical_changes_without_effect) == len(SYMBOLS) - len(GROUPS) - 1
    assert not any("one factor" in str(tradeoff) for tradeoff in result.physical_changes_without_effect)
    (sentence,) = [words for words in result.words if words.startswith("A22 =")]
    assert "determined by the weight in two" in sentence


def test_a_weight_that_is_known_badly_does_not_determine_A22():  # noqa: N802 - a symbol
    found = identified_with_a_weight()
    result = identifiability(replace(found, inertia=replace(found.inertia, relative_std=0.3)))
    assert any(words.startswith("A22 is not determined by the weight in two") for words in result.words)


def test_with_a_weight_even_length_and_gravity_are_told_apart():
    result = identifiability(identified_with_a_weight(length_std=np.inf, gravity_std=np.inf))
    assert (result.undetermined, result.unseen_changes) == ((), ())


def test_a_friction_with_a_wide_interval_is_not_determined_and_no_part_of_a_tradeoff():
    found = identified()
    wide = found.covariance.copy()
    wide[3, 3] = (0.3 * found.fit.values[3]) ** 2
    result = identifiability(replace(found, covariance=wide))
    assert result.undetermined == ("c1_over_A22",)
    assert any(sentence.startswith("c1 / A22 is not determined") for sentence in result.words)
    assert not any("c1" in tradeoff for tradeoff in result.physical_changes_without_effect)


def test_of_an_impossible_mechanism_no_physical_value_is_spoken():
    found = identified()
    result = identifiability(replace(found, physical=replace(found.physical, possible=False)))
    assert result.physical_changes_without_effect == ()
    assert not any("physical value" in sentence for sentence in result.words)


@pytest.mark.parametrize(
    ("value", "std", "expected"), [(1.0, 0.25, True), (1.0, 0.26, False), (0.0, 0.0, False), (1.0, np.inf, False)]
)
def test_determined_means_an_interval_within_half_the_value(value, std, expected):
    assert is_determined(value, std) is expected


def test_a_tradeoff_says_how_much_of_each():
    assert str(Tradeoff.of(["a", "b", "c"], np.array([1.0, -2.0, 0.0]))) == (
        "a and b cannot be told apart: a -0.5 %, b +1 % together change nothing"
    )

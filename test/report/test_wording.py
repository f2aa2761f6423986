# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Numbers, names and findings of a report as people read them."""

import math

import numpy as np
import pytest

from cdp_ident.model.effects.catalogue import NAMED
from cdp_ident.model.parameters import groups_of
from cdp_ident.report.wording import (
    action_words,
    chance,
    determined_words,
    effect_title,
    effects_words,
    how_determined,
    interval,
    milliradians,
    noise_floor,
    nominal_groups,
    nominal_value,
    odds,
    over_inertia,
    per_cent,
    share_words,
    short_name,
    unit,
    validation_words,
    with_std,
)


def test_a_measured_value_stands_in_for_the_nominal_one(read_content):
    assert nominal_value(read_content, "m0") == 0.208
    read_content["run"]["options"]["known.m0"] = 0.3
    assert nominal_value(read_content, "m0") == 0.3
    assert how_determined(read_content, "m0") == "measured"
    table_2 = np.array([0.108, 0.108, 0.3, 0.2, 0.2, 0.00133, 0.00133, 0.00705, 0.00305])
    assert list(nominal_groups(read_content).values()) == pytest.approx(groups_of(table_2, 0.4))


def test_an_effect_in_doubt_is_mentioned_with_what_it_would_change(read_content):
    group = read_content["after"]["groups"]["c2_over_A22"]
    group.update(value=0.003, std=0.0004)
    changes = dict.fromkeys(read_content["after"]["groups"], 0.0)
    read_content["in_doubt"] = [
        {"effect": "coulomb_friction.outer", "weight": 0.5, "changes": {**changes, "c2_over_A22": -0.001}},
        {"effect": "gravity_tilt.base", "weight": 0.1, "changes": {**changes, "c2_over_A22": -0.0001}},
    ]
    added = determined_words(read_content)[len(read_content["identifiability"]["words"]) :]
    assert added == [
        "coulomb friction, outer, is neither shown nor excluded; it would change c2 / A22 by -33 %, and intervals "
        "allow for that"
    ]


def test_it_is_said_how_a_value_was_come_by(read_content):
    assert how_determined(read_content, "g") == "given"
    assert how_determined(read_content, "L") == "yes"
    assert how_determined(read_content, "m1") == "no: nearest to nominal"
    read_content["after"]["physical"]["m1"]["determined"] = True
    assert how_determined(read_content, "m1") == "yes"


@pytest.mark.parametrize(
    ("action", "words"),
    [
        ("dropped cogging_torque.inner.13 per turn", "dropped cogging torque, inner, 13 per turn"),
        (
            "exchanged air_drag.outer.rotation for air_drag.outer.strips",
            "exchanged air drag, outer, rotation for air drag, outer, strips",
        ),
        ("added gravity_tilt.base and encoder_offset.outer", "added gravity tilt, base and encoder offset, outer"),
        ("added inner zeros of each trial", "added inner zeros of each trial"),
    ],
)
def test_a_step_of_the_selection_is_in_words(action, words):
    assert action_words({"action": action}) == words


def test_an_effect_is_named_with_its_place(read_content):
    effect = read_content["effects"][0] | {"certainty": "named"}
    assert effect_title(effect) == "dry friction (outer joint)"
    assert effect_title(effect | {"name": "encoder_offset"}) == "dry friction (outer encoder)"
    assert effect_title(effect | {"joint": "base", "variant": "strips", "trial": "one"}) == (
        "dry friction (base, strips, in one)"
    )


@pytest.mark.parametrize(("looked_in", "said"), [(0.0, False), (1.0, True), (23.9, False)])
def test_it_is_said_where_effects_were_looked_for_in_a_part_only(read_content, looked_in, said):
    read_content["selection"]["looked_in_s"] = looked_in
    assert bool(share_words(read_content)) == said


def test_keys_are_written_as_fractions_and_words():
    assert short_name("A23_over_A22") == "A23/A22"
    assert short_name("coulomb_friction.outer.torque") == "coulomb friction, outer, torque"
    assert short_name("one_over_A22") == "1/A22"
    assert short_name("weight_error.outer.300.5 mm") == "weight error, outer, 300.5 mm"
    assert effects_words(["air_drag.outer", "joint_spring.outer"]) == "air drag, outer and joint spring, outer"
    assert effects_words([]) == "the same, from elsewhere"


def test_the_noise_of_both_encoders_is_their_mean_square(read_content):
    assert noise_floor(read_content | {"noise_rad": {"theta1": 3.0, "theta2": 4.0}}) == pytest.approx(np.sqrt(12.5))


def test_the_validation_is_in_words(read_content):
    fit, ahead, residuals = validation_words(read_content)
    percent = read_content["after"]["error"]["holdout"]["fit_theta2_percent"]
    assert f"-> {percent:.4g} %" in fit
    assert "within 1° for " in ahead
    assert f"-> ≥ {read_content['prediction']['horizon_s']:.3g} s" in ahead
    assert residuals == "residuals over held-out windows: white"


def test_residuals_that_are_not_white_are_told_with_how_much_they_are_correlated(read_content):
    found = read_content["residuals"]
    cart = {angle: found["before"][angle] for angle in ("theta1", "theta2")}
    found["after"] = found["before"] | {"cart": cart, "crosswise": found["before"]["crosswise"] | {"related": True}}
    *_, own, crosswise, cart = validation_words(read_content)
    most = max(map(abs, found["before"]["theta1"]["values"][1:]))
    assert f"{most:.2f} in theta1 (chance: " in own
    assert "each other" in crosswise
    assert "cart's acceleration" in cart


def test_what_has_no_prediction_and_no_fit_says_nothing_of_it(read_content):
    read_content["prediction"] = None
    read_content["before"]["error"]["holdout"]["fit_theta1_percent"] = np.inf
    words = list(validation_words(read_content))
    assert "theta1 – -> " in words[0]
    assert not any("predicts" in word for word in words)


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


@pytest.mark.parametrize("effect", NAMED, ids=lambda effect: effect.key)
def test_what_motion_shows_over_inertia_is_written_so_where_no_mass_is_known(effect):
    for strength in (p for p in effect.parameters if p.inertia_power == 1 and not p.shape):
        shown = {"value": 1.0, "std": 1.0, "unit": strength.unit, "as_fitted": {"value": 2.0, "std": 0.01}}
        assert over_inertia(shown).endswith("over A22")

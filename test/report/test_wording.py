# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Numbers, names and findings of a report as people read them."""

import math

import numpy as np
import pytest

from cdp_ident.model.effects.catalogue import NAMED
from cdp_ident.report.wording import (
    chance,
    effect_title,
    interval,
    milliradians,
    noise_floor,
    odds,
    over_inertia,
    per_cent,
    short_name,
    unit,
    with_std,
)


def test_an_effect_is_named_with_its_place(read_content):
    effect = read_content["effects"][0] | {"certainty": "named"}
    assert effect_title(effect) == "dry friction (outer joint)"
    assert effect_title(effect | {"name": "encoder_offset"}) == "dry friction (outer encoder)"
    assert effect_title(effect | {"joint": "base", "variant": "strips", "trial": "one"}) == (
        "dry friction (base, strips, in one)"
    )


def test_the_noise_of_both_encoders_is_their_mean_square(read_content):
    assert noise_floor(read_content | {"noise_rad": {"theta1": 3.0, "theta2": 4.0}}) == pytest.approx(np.sqrt(12.5))


@pytest.mark.parametrize(
    ("written", "numbers", "text"),
    [
        # as long as the deviation allows
        (with_std, (0.123456, 0.00234), "0.1235 ± 0.0023"),
        (with_std, (1234.5, 67.0), "1234 ± 67"),
        (with_std, (0.4, 0.0), "0.4"),
        (with_std, (0.1, math.inf), "0.1 ± inf"),
        (with_std, (0.0, 3e-13), "0 ± 3e-13"),
        # two deviations to either side
        (interval, (1.0, 0.1), "0.80 to 1.20"),
        (interval, (1.0, math.inf), "-inf to inf"),
        # what is not finite is a dash or infinite
        (milliradians, (0.0045678,), "4.568"),
        (milliradians, (math.inf,), "inf"),
        (per_cent, (97.123456,), "97.12"),
        (per_cent, (math.nan,), "–"),
        (per_cent, (-math.inf,), "–"),
        # no probability is 0 or 1, and large odds are powers of ten
        (chance, (0.0,), "< 0.1 %"),
        (chance, (0.875,), "87.5 %"),
        (chance, (1.0,), "> 99.9 %"),
        (odds, (1.0,), "10 : 1"),
        (odds, (-1.0,), "0.1 : 1"),
        (odds, (494.1,), "10^494 : 1"),
        (odds, (math.inf,), "–"),
        (odds, (math.nan,), "–"),
        # a number without a unit has none
        (unit, ("1",), ""),
        (unit, ("1/s",), "1/s"),
        # keys are fractions and words
        (short_name, ("A23_over_A22",), "A23/A22"),
        (short_name, ("coulomb_friction.outer.torque",), "coulomb friction, outer, torque"),
        (short_name, ("one_over_A22",), "1/A22"),
        (short_name, ("weight_error.outer.300.5 mm",), "weight error, outer, 300.5 mm"),
    ],
)
def test_numbers_and_keys_are_written_for_people(written, numbers, text):
    assert written(*numbers) == text


@pytest.mark.parametrize("effect", NAMED, ids=lambda effect: effect.key)
def test_what_motion_shows_over_inertia_is_written_so_where_no_mass_is_known(effect):
    for strength in (p for p in effect.parameters if p.inertia_power == 1 and not p.shape):
        shown = {"value": 1.0, "std": 1.0, "unit": strength.unit, "as_fitted": {"value": 2.0, "std": 0.01}}
        assert over_inertia(shown).endswith("over A22")

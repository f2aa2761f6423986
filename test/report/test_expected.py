# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What an earlier report lets expect, and what has changed since."""

from dataclasses import replace

import numpy as np

from cdp_ident.report.expected import compared, expected_effects
from cdp_ident.report.filling import filled
from cdp_ident.report.schema import REPORT
from cdp_ident.report.wording import expected_in_words


def test_the_effects_of_a_report_are_expected_with_the_values_that_motion_showed(content, outcome):
    (expected,) = expected_effects(content)
    assert expected.effect.key == "coulomb_friction.outer"
    place = outcome.trace.after.model.places(0)
    assert expected.values == outcome.trace.completed.fit.values[place]
    assert np.all(expected.std > 0)


def test_what_happened_once_and_what_has_no_name_is_not_expected_again(content):
    (effect,) = content["effects"]
    once, nameless = effect | {"name": "impulse"}, effect | {"name": "unknown_torque", "variant": "over_angle"}
    assert expected_effects(content | {"effects": [once, nameless]}) == ()


def test_each_is_said_to_be_confirmed_withdrawn_or_new(content, outcome):
    (known,) = expected_effects(content)
    off = replace(known, values=known.values + 3 * np.sqrt(2) * known.std)
    (confirmed,) = filled(REPORT["properties"]["expected"], compared([off], outcome.trace.effects))
    assert confirmed["state"] == "confirmed"
    assert round(confirmed["parameters"]["torque"]["deviations"], 3) == 3.0
    assert [section.values["state"] for section in compared([known], ())] == ["withdrawn"]
    assert [section.values["state"] for section in compared([], outcome.trace.effects)] == ["new"]
    words = list(expected_in_words({"expected": [confirmed]}))
    assert words[0].startswith("coulomb friction, outer is confirmed: torque 0.0")
    assert words[0].endswith("(3.0 std), torques over A22")

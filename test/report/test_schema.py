# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""One statement says what report.json holds: for who writes it, who reads it, and its documentation."""

from typing import get_args

from jsonschema import Draft202012Validator

from cdp_ident.diagnosis import prediction
from cdp_ident.model.effects.effect import Joint
from cdp_ident.model.weights import RODS
from cdp_ident.report.schema import REPORT, problem
from cdp_ident.tracing import found_effects
from cdp_ident.tracing.selection import Certainty


def test_the_schema_is_one():
    Draft202012Validator.check_schema(REPORT)


def test_what_is_wrong_is_one_short_line():
    assert len(problem({"x" * 10_000: "y" * 10_000})) < 500


def test_every_key_has_words():
    assert [key for key, value in REPORT["properties"].items() if not value["description"]] == []


def test_words_and_lengths_are_those_of_the_package():
    values = REPORT["properties"]
    effect = values["effects"]["items"]["properties"]
    curve = effect["curve"]["anyOf"][0]["properties"]
    weight = values["trials"]["items"]["properties"]["weights"]["items"]["properties"]
    assert effect["joint"]["enum"] == list(get_args(Joint))
    assert effect["certainty"]["enum"] == list(get_args(Certainty))
    assert weight["rod"]["enum"] == list(RODS)
    for of_curve in ("at", "torque", "std"):
        assert curve[of_curve]["minItems"] == curve[of_curve]["maxItems"] == found_effects.POINTS
    assert values["prediction"]["anyOf"][0]["properties"]["time_s"]["maxItems"] == prediction.POINTS

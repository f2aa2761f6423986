# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""One statement says what a report holds, and one is read only if it holds that."""

import copy
import json
import os
from typing import get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st
from jsonschema import Draft202012Validator

from cdp_ident.diagnosis import prediction
from cdp_ident.errors import ReportError
from cdp_ident.model.effects.effect import Joint
from cdp_ident.model.weights import RODS
from cdp_ident.output_folder import json_text
from cdp_ident.report.report_file import read_report
from cdp_ident.report.schema import REPORT, problem
from cdp_ident.tracing import found_effects
from cdp_ident.tracing.selection import Certainty


def paths(content, here=()):
    """Yield the way to everything in a report."""
    items = content.items() if isinstance(content, dict) else enumerate(content) if isinstance(content, list) else ()
    for key, inside in items:
        yield (*here, key)
        yield from paths(inside, (*here, key))


def changed(content, path, value):
    content = copy.deepcopy(content)
    *way, last = path
    place = content
    for key in way:
        place = place[key]
    place[last] = value
    return content


@pytest.fixture
def read_content(content):
    """The report as JSON has it."""
    return json.loads(json_text(content))


@pytest.fixture
def path(tmp_path):
    return tmp_path / "report.json"


def test_a_report_is_read_as_it_was_written(content, path):
    path.write_text(json_text(content))
    assert json_text(read_report(path)) == json_text(content)


def test_a_report_of_one_trial_has_no_repeatability(read_content, path):
    path.write_text(json.dumps(read_content | {"repeatability": None}))
    assert read_report(path)["repeatability"] is None


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "cannot be read"),
        ("{", "cannot be read"),
        ("[" * 100_000, "cannot be read"),
        ("\xff", "cannot be read"),
        ("[]", "is of the schema None"),
        ('{"schema": 3}', "is of the schema 3"),
        ('{"schema": "cdp_ident/report/0"}', "cdp_ident/report/0.*identify again"),
        ('{"schema": "cdp_ident/report/1"}', "'trials' is a required property"),
    ],
)
def test_what_is_no_report_of_this_schema_is_refused(path, text, words):
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(ReportError, match=words):
        read_report(path)


def test_a_missing_file_is_named(path):
    with pytest.raises(ReportError, match=r"there is no .*report\.json"):
        read_report(path)


@pytest.mark.parametrize(
    ("place", "value", "words"),
    [
        (
            ("after", "groups", "c1_over_A22", "value"),
            "1",
            r"after\.groups\.c1_over_A22\.value: '1' is not of type 'number'",
        ),
        (("after", "physical", "m1", "determined"), 1, "1 is not of type 'boolean'"),
        (("trials", 1, "bag"), None, r"trials\[1\]\.bag: None is not of type 'string'"),
        (("trials", 1, "role"), "judge", "'judge' is not one of"),
        (("effects", 0, "joint"), "elbow", "'elbow' is not one of"),
        (("effects", 0, "parameters"), [], "is not of type 'object'"),
        (("effects", 0, "name"), "/../../../../x", r"effects\[0\]\.name: '/../../../../x' does not match"),
        (("effects", 0, "parameters", "../x"), None, r"effects\[0\]\.parameters"),
        (("verdict",), "x" * 5000, "is too long"),
        (("warnings",), [{}] * 2000, "is a required property|is too long|expected at most"),
        (("noise_rad", "theta1"), 10**400, "maximum"),
        (("surprise",), 1, "were unexpected|was unexpected"),
        (("search", "history"), {}, "is not of type 'array'"),
        (("noise_rad", "theta1"), float("nan"), "NaN is no number in JSON"),
    ],
    ids=lambda value: str(value)[:40],
)
def test_what_is_of_the_wrong_kind_is_named(read_content, path, place, value, words):
    path.write_text(json.dumps(changed(read_content, place, value)))
    with pytest.raises(ReportError, match=words):
        read_report(path)


@given(data=st.data())
def test_no_change_of_a_report_ends_in_anything_but_a_refusal(data, content, tmp_path_factory):
    plain = json.loads(json_text(content))
    place = data.draw(st.sampled_from(list(paths(plain))))
    value = data.draw(st.sampled_from([None, True, -1, 1e300, "", "x", [], {}, [[]], {"": None}]))
    path = tmp_path_factory.mktemp("changed") / "report.json"
    path.write_text(json.dumps(changed(plain, place, value)))
    try:
        read_report(path)
    except ReportError as error:
        assert "\n" not in str(error)  # noqa: PT017 - any other outcome is as good


def test_texts_are_shown_without_what_commands_a_terminal(read_content, path):
    path.write_text(json.dumps(changed(read_content, ("trials", 0, "name"), "\x1b[2Jswing")))
    assert read_report(path)["trials"][0]["name"] == r"\x1b[2Jswing"


@pytest.mark.parametrize("name", ["pipe", "/dev/zero"])
def test_what_is_no_file_is_refused(tmp_path, name):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(ReportError, match="not a regular file"):
        read_report(tmp_path / name)


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

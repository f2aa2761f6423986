"""One schema states what report.json holds: for who writes it and who reads it."""

import json

from jsonschema import Draft202012Validator

from cdp_ident.report.folder import json_text
from cdp_ident.report.schema import REPORT, problem


def test_the_schema_is_one():
    Draft202012Validator.check_schema(REPORT)


def test_what_identify_writes_obeys_it(content):
    assert problem(json.loads(json_text(content))) == ""


def test_what_is_wrong_is_one_short_line():
    assert len(problem({"x" * 10_000: "y" * 10_000})) < 500

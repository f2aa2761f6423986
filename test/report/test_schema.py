"""One schema states what report.json holds: for who writes it, who reads it, and its documentation."""

import json
from pathlib import Path

from jsonschema import Draft202012Validator

from cdp_ident.report.folder import json_text
from cdp_ident.report.schema import REPORT, problem
from cdp_ident.report.schema_document import document, outline

DOCUMENT = Path(__file__).parents[2] / "docs/reference/report_schema.md"


def test_the_schema_is_one():
    Draft202012Validator.check_schema(REPORT)


def test_what_identify_writes_obeys_it(content):
    assert problem(json.loads(json_text(content))) == ""


def test_what_is_wrong_is_one_short_line():
    assert len(problem({"x" * 10_000: "y" * 10_000})) < 500


def test_everything_has_a_type_and_all_that_needs_words_has_them():
    rows = list(outline())
    assert all(kind for _, kind, _ in rows)
    assert [name for name, _, about in rows if not about and "." not in name and "[" not in name] == []


def test_the_document_says_the_same():
    command = "python -c 'from cdp_ident.report.schema_document import document; print(document(), end=\"\")'"
    assert DOCUMENT.read_text() == document(), f"{command} > docs/reference/report_schema.md"

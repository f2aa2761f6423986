"""The documentation of report.json is made from its schema."""

from pathlib import Path

from cdp_ident.report.schema_document import document, outline

DOCUMENT = Path(__file__).parents[2] / "docs/reference/report_schema.md"


def test_everything_has_a_type_and_all_that_needs_words_has_them():
    rows = list(outline())
    assert all(kind for _, kind, _ in rows)
    assert [name for name, _, about in rows if not about and "." not in name and "[" not in name] == []


def test_the_document_says_the_same():
    command = "python -c 'from cdp_ident.report.schema_document import document; print(document(), end=\"\")'"
    assert DOCUMENT.read_text() == document(), f"{command} > docs/reference/report_schema.md"

"""A document as Markdown."""

from cdp_ident.report.figures.description import Figure
from cdp_ident.report.markdown import markdown
from cdp_ident.report.parts import Chapter, Charts, Code, Document, Sentences, Table

FIGURE = Figure("one", "Errors", "How large.", "Small.", ())


def text_of(*parts, with_figures=False):
    return markdown(Document("", "a_b", "All is well.", [Chapter("x", "Chapter", parts)]), with_figures)


def test_a_table_has_its_title_above_and_its_note_below():
    text = text_of(Table("Sizes", ("what", "size"), [("rod", "1")], "In m."))
    assert text.split("\n\n")[2:] == [
        "## Chapter",
        "**Sizes**",
        "| what | size |\n| --- | --- |\n| rod | 1 |",
        "In m.\n",
    ]


def test_a_single_sentence_is_a_paragraph_and_several_are_a_list():
    assert "\n\nOne.\n" in text_of(Sentences(["One."]))
    assert "- One.\n- Two.\n" in text_of(Sentences(["One.", "Two."]))


def test_a_chapter_that_says_nothing_is_left_out():
    nothing = (Table("", ("a",), []), Sentences([]), Charts([FIGURE]))
    assert text_of(*nothing) == "# a\\_b\n\nAll is well.\n"
    assert "![Small.](figures/one.svg)" in text_of(*nothing, with_figures=True)


def test_text_stays_text_and_a_command_is_code():
    assert "\\*a\\* &lt;b>" in text_of(Sentences(["*a* <b>"]))
    assert "`run *a*`" in text_of(Sentences([Code("run *a*")]))

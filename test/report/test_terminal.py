"""A report as text."""

import io
import re

from rich.console import Console

from cdp_ident.report.formatting import with_std
from cdp_ident.report.terminal import print_report, summary


def text_of(content):
    stream = io.StringIO()
    print_report(Console(file=stream, width=150), content)
    return stream.getvalue()


def test_the_tables_hold_the_report_s_numbers(content):
    text = text_of(content)
    errors = content["stages"]
    for stage in errors.values():
        assert f"{1e3 * stage['holdout']['rmse_rad']:.4g}" in text
    assert with_std(content["after"]["physical"]["l2"]["value"], content["after"]["physical"]["l2"]["std"]) in text
    assert "no: nearest to nominal" in text
    assert "given" in text
    assert all(sentence[1:40] in text for sentence in content["identifiability"]["words"])
    assert "dry friction (outer joint)" in text


def test_a_report_read_from_its_file_gives_the_same_text(content, read_content):
    assert text_of(read_content) == text_of(content)


def test_warnings_are_printed(read_content):
    read_content["warnings"] = []
    assert "Warnings\nNone." in re.sub(" +\n", "\n", text_of(read_content))
    read_content["warnings"] = [{"name": "x", "about": [], "message": "the sky is falling"}]
    assert "the sky is falling" in text_of(read_content)


def test_what_a_bag_is_called_is_printed_as_it_is(read_content):
    read_content["trials"][0]["bag"] = "bags/[red]swing[/]"
    read_content["repeatability"]["trials"][0]["trial"] = "[bold]x"
    assert "[red]swing[/]" in text_of(read_content)
    assert "[bold]x" in text_of(read_content)


def test_the_summary_is_the_verdict_on_the_fitted_trials(content):
    assert content["verdict"] in summary(content)
    assert content["trials"][0]["name"] in summary(content)

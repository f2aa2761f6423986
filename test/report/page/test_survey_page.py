"""The page of a survey, opened from disk in a real browser."""

import pytest

from cdp_ident.configuration.settings import Settings
from cdp_ident.survey.contents import survey
from cdp_ident.survey.page import survey_html
from scenarios.fleet import finished

EVIL = "\"'><img src=x onerror=alert(1)></script><script>alert(2)</script>{{7*7}}$x$`<b>"


@pytest.mark.parametrize("viewport", [{"width": 1280, "height": 900}, {"width": 375, "height": 800}])
def test_a_survey_is_a_page_of_the_same_kind(visit, read_content, tmp_path, viewport):
    pieces = [finished(read_content, rig, day) for rig in ("rig1", f"rig2{EVIL}") for day in range(3)]
    pieces.append(finished(None, "rig3", 0, f"nothing{EVIL}"))
    (tmp_path / "survey.html").write_text(survey_html(survey(pieces, "day", Settings.of({}))))
    visited = visit(tmp_path / "survey.html", viewport=viewport)
    visited.draw_all()
    assert visited.complaints == []
    assert visited.page.evaluate("document.documentElement.scrollWidth") <= viewport["width"]
    assert visited.page.locator("img").count() == 0
    assert visited.page.locator("a[href$='/report.html']").count() == 6

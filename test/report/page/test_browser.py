# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The report, opened from disk in a real browser and used."""

import re
from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.configuration.settings import Settings
from cdp_ident.report.chapters import document_of
from cdp_ident.report.comparison import compare
from cdp_ident.report.curves import Curves
from cdp_ident.report.document import Chapter, Charts, Document
from cdp_ident.report.folder import PAGE
from cdp_ident.report.parameters import runs_compared
from cdp_ident.report.pictures import page_of
from cdp_ident.survey.contents import survey
from cdp_ident.survey.page import survey_html
from scenarios.fleet import finished

pytestmark = pytest.mark.waits

DESKTOP, PHONE = {"width": 1280, "height": 900}, {"width": 375, "height": 800}
SECTIONS = ("result", "motion", "paper", "effects", "parameters", "warnings", "repeat")
LENGTH, OUTER_LENGTH = 0.4, 0.4
NEAR = 1e-4
"""The page draws the fitted length [m]."""
EVIL = "\"'><img src=x onerror=alert(1)></script><script>alert(2)</script>{{7*7}}$x$`<b>"
WIDTHS = "[...document.querySelectorAll('.plot .main-svg')].map(s => s.clientWidth)"
FIXED = {"schema", "role", "joint", "unit", "method", "written_at", "certainty"}


def tips(theta):
    """Return where the outer rod ends (n, 2) [m], x and z, the cart being at 0."""
    along = np.stack([np.sin(theta), np.cos(theta)])
    return (LENGTH * along[..., 0] + OUTER_LENGTH * along[..., 1]).T


def drawn(group, model="before"):
    return f".stage.{model} .{group}"


def tip(page, *group):
    return [float(number) for number in page.get_attribute(drawn(*group), "data-tip").split(",")]


def scrub_to(page, index):
    page.evaluate(
        """index => {
          const scrub = document.getElementById('scrub');
          scrub.value = index;
          scrub.dispatchEvent(new Event('input'));
        }""",
        index,
    )


def ranges(plot):
    return plot.evaluate(
        "plot => Object.keys(plot._fullLayout).filter(k => /^xaxis/.test(k)).map(k => plot._fullLayout[k].range)"
    )


def assert_everything_is_there(visited, width):
    """Assert that a report is whole, fits a window so wide and needed no network."""
    assert [url for url in visited.requests if not url.startswith(("file:", "data:", "blob:"))] == []
    assert len([url for url in visited.requests if url.startswith("file:")]) == 1
    for section in SECTIONS:
        assert visited.page.locator(f"section#{section}").is_visible()
    assert visited.page.locator(".plot:not([data-drawn])").count() == 0
    assert visited.page.evaluate("document.documentElement.scrollWidth") <= width
    cut = visited.page.evaluate("""() => [...document.querySelectorAll('.plot')].flatMap((plot) => {
      const box = plot.getBoundingClientRect();
      const words = '.xtick text, .ytick text, .xtitle, .ytitle, .annotation-text';
      return [...plot.querySelectorAll(words)].filter((text) => {
        const inside = text.getBoundingClientRect();
        return inside.left < box.left - 1 || inside.right > box.right + 1 || inside.bottom > box.bottom + 1;
      }).map((text) => plot.dataset.figure + ': ' + text.textContent);
    })""")
    assert cut == []


def test_everything_is_drawn_without_complaint_and_without_network(opened, desktop):
    assert opened.at_first == ()
    assert_everything_is_there(desktop, 1280)


def test_everything_is_drawn_for_a_phone_in_the_dark_and_for_printing(visit):
    visited = visit(viewport=PHONE, color_scheme="dark")
    assert_everything_is_there(visited, PHONE["width"])
    assert visited.page.locator(".controls").is_visible()
    assert visited.page.inner_text("#play") == "Pause"  # it plays by itself
    before = visited.page.evaluate(WIDTHS)

    visited.page.emulate_media(media="print", color_scheme="dark")
    visited.page.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert not visited.page.locator(".controls").is_visible()
    assert visited.page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    assert PHONE["width"] < max(visited.page.evaluate(WIDTHS)) <= 660

    visited.page.emulate_media(media="screen", color_scheme="dark")
    visited.page.evaluate("dispatchEvent(new Event('afterprint'))")
    visited.page.wait_for_function(f"widths => String({WIDTHS}) === String(widths)", arg=before)
    assert_everything_is_there(visited, PHONE["width"])
    assert visited.complaints == []


def test_verdict_and_numbers_are_those_of_the_report(desktop, read_content):
    text = desktop.page.inner_text("body")
    assert read_content["verdict"] in text
    for model in ("before", "after"):
        assert f"{1e3 * read_content[model]['error']['holdout']['rmse_rad']:.3g}" in text
    assert "dry friction (outer joint)" in text
    assert all(warning["message"] in text for warning in read_content["warnings"])
    assert all(digest in text for files in read_content["run"]["bag_sha256"].values() for digest in files.values())


def test_the_pendulum_at_a_scrubbed_time_is_that_of_the_data(page, shown_curves):
    curve = shown_curves.trials[2]
    page.select_option("#factor", "1")
    page.select_option("#start", "run")
    for index in (0, 777, len(curve.time) - 1):
        scrub_to(page, index)
        assert float(page.get_attribute(".stage.before", "data-time")) == pytest.approx(curve.time[index], abs=1e-5)
        assert tip(page, "measured") == pytest.approx(tips(curve.measured[index : index + 1])[0], abs=NEAR)
        assert tip(page, "simulated") == pytest.approx(tips(curve.run_before[index : index + 1])[0], abs=NEAR)
    scrub_to(page, 777)
    assert tip(page, "simulated", "after") == pytest.approx(tips(curve.run_after[777:778])[0], abs=NEAR)
    page.select_option("#start", "windows")
    assert tip(page, "simulated", "after") == pytest.approx(tips(curve.after[777:778])[0], abs=NEAR)
    page.select_option("#trial", "1")
    scrub_to(page, 100)
    assert tip(page, "measured") == pytest.approx(tips(shown_curves.trials[1].measured[100:101])[0], abs=NEAR)


def test_what_is_drawn_is_where_the_data_says(page):
    scrub_to(page, 500)
    x, z = tip(page, "measured")
    end = re.findall(r"L(\S+),(\S+)", page.get_attribute(drawn("measured") + " path", "d"))[-1]
    assert [float(number) for number in end] == pytest.approx([100 * x, -100 * z], abs=0.01)


def test_a_difference_too_small_to_see_is_magnified(page, shown_curves):
    curve = shown_curves.trials[2]
    scrub_to(page, 1000)
    magnified = curve.measured[1000] + 100 * (curve.before[1000] - curve.measured[1000])
    assert tip(page, "simulated") == pytest.approx(tips(magnified[None])[0], abs=1e-3)


def test_playing_moves_it_and_pausing_holds_it(desktop, page):
    page.click("#play")
    desktop.until("Number(document.querySelector('.stage').dataset.time) > 0.3")
    page.click("#play")
    assert page.inner_text("#play") == "Play"
    held = page.get_attribute(".stage.before", "data-time")
    page.wait_for_timeout(150)
    assert page.get_attribute(".stage.before", "data-time") == held
    assert page.input_value("#scrub") != "0"


def test_the_keyboard_works_the_player(desktop, page):
    page.focus("#scrub")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("ArrowRight")
    assert page.input_value("#scrub") == "2"
    assert float(page.get_attribute(".stage.before", "data-time")) > 0
    assert "seconds" in page.get_attribute("#scrub", "aria-valuetext")
    page.keyboard.press(" ")
    desktop.until("Number(document.querySelector('.stage').dataset.time) > 0.2")
    page.keyboard.press(" ")
    assert page.inner_text("#play") == "Play"
    page.keyboard.press("Tab")
    assert page.evaluate("document.activeElement.id") == "play"
    assert page.evaluate("getComputedStyle(document.activeElement).outlineStyle") == "solid"
    page.keyboard.press("Enter")
    assert page.inner_text("#play") == "Pause"


def test_a_drag_zooms_all_panels_and_a_double_click_shows_all_again(desktop, page):
    plot = page.locator("[data-figure^=angles_1]")
    plot.scroll_into_view_if_needed()
    (whole,) = ranges(plot)  # one axis for all panels
    box = plot.locator(".nsewdrag").first.bounding_box()
    middle = box["y"] + box["height"] / 2
    page.mouse.move(box["x"] + 0.25 * box["width"], middle)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.5 * box["width"], middle, steps=5)
    page.mouse.up()
    (zoomed,) = ranges(plot)
    width = whole[1] - whole[0]
    assert zoomed == pytest.approx([whole[0] + 0.25 * width, whole[0] + 0.5 * width], abs=0.02 * width)
    desktop.until(
        "end => Math.abs(document.querySelector('[data-figure^=angles_1]')._fullLayout.xaxis.range[1] - end) < 0.1",
        whole[1],
        trying=plot.locator(".nsewdrag").first.dblclick,  # on a busy machine two clicks may be too far apart for one
        pause=500,
    )


def test_the_keyboard_zooms_a_chart(page):
    plot = page.locator("[data-figure=parameters]")
    plot.scroll_into_view_if_needed()
    before = ranges(plot)
    plot.focus()
    page.keyboard.press("+")
    after = ranges(plot)
    assert [np.ptp(r) for r in after] == pytest.approx([np.ptp(r) / 2 for r in before])
    page.keyboard.press("ArrowRight")
    assert ranges(plot)[0][0] > after[0][0]
    page.keyboard.press("0")
    assert ranges(plot) == [pytest.approx(r, rel=0.2) for r in before]


def test_a_name_above_a_chart_hides_its_curves(page):
    figure = page.locator("#figure-errors")
    bars = figure.locator(".bars .point").count()
    button = figure.get_by_role("button", name="before: the paper's model, fitted")
    button.click()
    assert button.get_attribute("aria-pressed") == "false"
    assert figure.locator(".bars .point").count() == bars - 2


def test_charts_follow_the_theme(desktop):
    plot = desktop.page.locator("[data-figure=errors]")

    def ink():
        return plot.locator(".ytick text").first.evaluate("text => getComputedStyle(text).fill")

    light = ink()
    desktop.page.emulate_media(color_scheme="dark")
    desktop.until(
        "old => getComputedStyle(document.querySelector('[data-figure=errors] .ytick text')).fill !== old", light
    )
    assert desktop.complaints == []


def test_everything_that_can_be_used_has_a_name_and_every_chart_a_text_in_its_place(page):
    unnamed = page.evaluate("""() => [
      ...document.querySelectorAll('button, select, input, a, [role=img], [role=region]')
    ].filter(
      (e) => !(e.getAttribute('aria-label') || e.textContent.trim() || (e.labels && e.labels.length))
    ).map((e) => e.outerHTML.slice(0, 80))""")
    assert unnamed == []
    assert all(len(label) > 20 for label in page.eval_on_selector_all(".plot", "plots => plots.map(p => p.ariaLabel)"))
    levels = page.eval_on_selector_all("h1, h2, h3", "all => all.map(h => Number(h.tagName[1]))")
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert max(np.diff(levels)) <= 2
    assert page.get_attribute("html", "lang") == "en"


def test_a_rig_that_lacks_nothing_has_a_page_too_and_all_of_it_is_printed(visit, read_content, shown_curves, tmp_path):
    """One trial, nothing added, nothing to warn of, and a run that diverged."""
    report = read_content | {"effects": [], "repeatability": None, "warnings": [], "trials": read_content["trials"][:1]}
    report["selection"]["steps"] = [report["selection"]["steps"][1]]
    report["before"]["error"]["holdout"]["sse_free_run"] = np.inf
    trial = replace(shown_curves.trials[0], run_before=np.full_like(shown_curves.trials[0].measured, np.nan))
    after = replace(shown_curves.after, effects=shown_curves.after.effects[:0])
    curves = Curves((trial,), shown_curves.before, after)
    (tmp_path / PAGE).write_text(page_of(document_of(report, curves), report, curves))
    visited = visit(tmp_path / PAGE)
    visited.page.evaluate("dispatchEvent(new Event('beforeprint'))")
    assert visited.page.locator(".plot:not([data-drawn])").count() == 0
    assert visited.complaints == []
    text = visited.page.inner_text("main")
    assert "None was added." in text
    visited.page.select_option("#start", "run")
    visited.page.click("#play")
    assert "before –, –" in visited.page.inner_text("#reading")  # the pendulum that no run follows
    assert not visited.page.locator(drawn("simulated")).is_visible()
    visited.page.select_option("#start", "windows")
    assert visited.page.locator(f"{drawn('simulated')} path").get_attribute("d").startswith("M")


def hostile(value, key=""):
    """Put markup into every text of a report that is not one of a few words, names included."""
    if isinstance(value, dict):
        names = key in ("bag_sha256", "versions")
        return {name + EVIL if names else name: hostile(inside, name) for name, inside in value.items()}
    if isinstance(value, list):
        return [hostile(inside, key) for inside in value]
    return value + EVIL if isinstance(value, str) and key not in FIXED else value


def test_text_from_bags_and_files_stays_text(visit, read_content, shown_curves, tmp_path):
    report = hostile(read_content)
    (tmp_path / PAGE).write_text(page_of(document_of(report, shown_curves), report, shown_curves))
    visited = visit(tmp_path / PAGE)
    visited.page.wait_for_timeout(200)
    assert visited.complaints == []
    assert visited.page.locator("img").count() == 0
    assert visited.page.locator("script").count() == 5  # data, plotly.js as text and run, the page's own two
    assert visited.page.inner_text("h1").count(EVIL) == 2
    assert f"swing_wide{EVIL}" in visited.page.inner_text("#figure-repeatability .legend")
    assert visited.page.locator("[data-figure=repeatability] img, .plot a").count() == 0


def comparison(read_content):
    runs = {"worn": read_content, f"oiled{EVIL}": hostile(read_content)}
    chapter = Chapter("result", "", [*compare(runs), Charts([runs_compared(runs)])])
    return page_of(Document("compared", f"worn, oiled{EVIL}", "", [chapter]))


def survey_of_rigs(read_content):
    pieces = [finished(read_content, rig, day) for rig in ("rig1", f"rig2{EVIL}") for day in range(3)]
    pieces.append(finished(None, "rig3", 0, f"nothing{EVIL}"))
    return survey_html(survey(pieces, "day", Settings.of({})))


@pytest.mark.parametrize(
    ("made", "selector", "count"),
    [
        (comparison, "[role=region][aria-label='Base parameters, all that a free swing depends on']", 1),
        (survey_of_rigs, "a[href$='/report.html']", 6),
    ],
)
def test_other_documents_are_pages_of_the_same_kind(visit, read_content, tmp_path, made, selector, count):
    (tmp_path / "other.html").write_text(made(read_content))
    for viewport in (DESKTOP, PHONE):
        visited = visit(tmp_path / "other.html", viewport=viewport)
        assert visited.complaints == []
        assert visited.page.evaluate("document.documentElement.scrollWidth") <= viewport["width"]
        assert visited.page.locator("img").count() == 0
        assert visited.page.locator(selector).count() == count


def test_even_a_script_that_got_in_would_not_run(desktop):
    desktop.page.evaluate(
        """() => {
          const script = document.createElement('script');
          script.textContent = 'window.ran = true';
          document.body.append(script);
        }"""
    )
    assert desktop.page.evaluate("window.ran") is None
    assert any("Content Security Policy" in complaint for complaint in desktop.complaints)

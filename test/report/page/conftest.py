# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A real browser, and the report in it."""

import shutil
import time

import pytest

from cdp_ident.report.folder import PAGE

ARGUMENTS = [
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-component-update",
    "--disable-sync", "--no-first-run",
]  # fmt: skip
DESKTOP = {"width": 1280, "height": 900}
PATIENCE = 60.0


@pytest.fixture(scope="session")
def browser():
    program = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if program is None:
        pytest.skip("there is no Chromium to look at the report with: apt-get install chromium")
    playwright = pytest.importorskip("playwright.sync_api", reason="there is no playwright to drive a browser with")
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=program, args=ARGUMENTS)
        yield browser
        browser.close()


class Visit:
    """A page that is looked at, and what went wrong on it."""

    def __init__(self, browser, path, viewport, **options):
        self.context = browser.new_context(viewport=viewport, **options)
        self.context.set_default_timeout(1e3 * PATIENCE)
        self.page = self.context.new_page()
        self.complaints, self.requests = [], []
        self.page.on("console", lambda message: self.complaints.append(message.text))
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("dialog", lambda dialog: (self.complaints.append(dialog.message), dialog.dismiss()))
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.goto(path.as_uri())  # which waits until it is loaded, charts and all

    def until(self, condition, argument=None, trying=lambda: None, pause=20):
        """Wait until a script returns something true, and try something every so many milliseconds until then.

        The page's own policy forbids what playwright would wait with.
        """
        deadline = time.monotonic() + PATIENCE
        while not self.page.evaluate(condition, argument):
            assert time.monotonic() < deadline, condition
            trying()
            self.page.wait_for_timeout(pause)

    def begin_anew(self):
        """Put everything that a reader can change, but for the ranges of charts, back to what it is at first."""
        self.page.emulate_media(media="screen", color_scheme="light")
        self.page.evaluate("""() => {
          const all = (selector) => [...document.querySelectorAll(selector)];
          const play = document.getElementById('play');
          if (play.textContent === 'Pause') play.click();
          all('#player option').forEach((option) => { option.selected = option.defaultSelected; });
          document.getElementById('trial').dispatchEvent(new Event('change', { bubbles: true }));
          all('.legend button[aria-pressed=false]').forEach((button) => button.click());
          document.activeElement.blur();
          scrollTo(0, 0);
        }""")
        self.complaints.clear()

    def close(self):
        self.context.close()


@pytest.fixture
def visit(browser, report_folder):
    visits = []

    def open_page(path=report_folder / PAGE, viewport=DESKTOP, **options):
        visits.append(Visit(browser, path, viewport, **options))
        return visits[-1]

    yield open_page
    for visited in visits:
        visited.close()


@pytest.fixture(scope="session")
def opened(browser, report_folder):
    """The report, opened and drawn once: a page takes a browser seconds. What went wrong then is kept."""
    visited = Visit(browser, report_folder / PAGE, DESKTOP)
    visited.at_first = tuple(visited.complaints)
    yield visited
    visited.close()


@pytest.fixture
def desktop(opened):
    """The report as it is when it has been opened; who zooms a chart leaves it as it was."""
    opened.begin_anew()
    return opened


@pytest.fixture
def page(desktop):
    return desktop.page

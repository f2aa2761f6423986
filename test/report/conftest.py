"""One finished identification that the tests of the report share."""

from pathlib import Path

import pytest

from cdp_ident.configuration.settings import Settings
from cdp_ident.report.contents import report
from cdp_ident.report.job import Job, load, run

BAGS = Path(__file__).parents[2] / "bags"


@pytest.fixture(scope="session")
def outcome():
    bags = (BAGS / "swing_wide", BAGS / "swing_folded")
    return run(load(Job(bags, (BAGS / "swing_check",), Settings.of({}))), lambda progress: None)


@pytest.fixture(scope="session")
def content(outcome):
    return report(outcome)

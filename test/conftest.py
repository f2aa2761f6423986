"""What tests stand on: DDS of their own on this machine, signals that arrive, and one finished identification."""

import fcntl
import gc
import os
import pickle
import signal
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import settings

from cdp_ident.configuration.settings import Settings
from cdp_ident.model.parameters import NOMINAL, physical_coefficients
from cdp_ident.model.simulation import simulate
from cdp_ident.pipeline.job import load, run
from cdp_ident.report.contents import report
from cdp_ident.report.curves import curves
from cdp_ident.report.curves_file import curves_npz
from cdp_ident.report.folder import CURVES, REPORT, json_text, write_files
from cdp_ident.report.outcome import Job, LoadedJob
from cdp_ident.report.pictures import draw_again
from cdp_ident.report.report_file import read_report
from scenarios.weighted import WEIGHT, dry_friction, plain_and_weighted

os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
# Processes that share the tests out must not hear each other's nodes.
_WORKER = int(os.environ.get("PYTEST_XDIST_WORKER", "gw0").removeprefix("gw"))
_DOMAIN = int(os.environ.get("ROS_DOMAIN_ID", os.getpid()))
os.environ["ROS_DOMAIN_ID"] = str((_DOMAIN - 1 + _WORKER) % 100 + 1)

# The first example of a property may have to compile the model; how long an example takes says nothing about it.
settings.register_profile("quick", deadline=None, max_examples=20)
settings.register_profile("campaign", deadline=None, max_examples=300)
settings.load_profile("quick")

_DEFAULT_HANDLERS = {
    signal.SIGINT: signal.default_int_handler,
    signal.SIGTERM: signal.SIG_DFL,
    signal.SIGHUP: signal.SIG_DFL,
}


@pytest.fixture(autouse=True)
def arriving_signals():
    """Let signals arrive, in the test and in the processes that it starts.

    A node leaves them ignored when it has run in this process, and so does a shell that starts the tests in the
    background.
    """
    for number, handler in _DEFAULT_HANDLERS.items():
        signal.signal(number, handler)


def pytest_sessionstart(session):
    """Compile the longest loop once, before several processes share the tests out and each compiles it."""
    if getattr(session.config.option, "numprocesses", None):
        simulate(physical_coefficients(NOMINAL), np.zeros(4), np.zeros(1))


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Leave what collecting makes out of the search for garbage: it stays, and each search would go through it."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


def pytest_collection_modifyitems(items):
    """Let what waits begin first: others compute beside it."""
    items.sort(key=lambda item: item.get_closest_marker("waits") is None)


BAGS = Path(__file__).parents[1] / "bags"


@pytest.fixture(scope="session")
def made_once(tmp_path_factory):
    """Return a function that returns what one of the processes that share the tests out has made for all."""
    folder = tmp_path_factory.getbasetemp()
    folder = folder.parent if "PYTEST_XDIST_WORKER" in os.environ else folder

    def take(name: str, make: Callable[[], Any]) -> Any:
        file = folder / f"{name}.pickle"
        with (folder / f"{name}.lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not file.exists():
                file.write_bytes(pickle.dumps(make()))
            return pickle.loads(file.read_bytes())

    return take


@pytest.fixture(scope="session")
def outcome(made_once):
    bags = (BAGS / "swing_wide", BAGS / "swing_folded")
    job = Job(bags, (BAGS / "swing_check",), Settings.of({}))
    return made_once("outcome", lambda: run(load(job), lambda progress: None))


@pytest.fixture(scope="session")
def outcome_alone(made_once):
    """One of a single bag, part of which is held out."""
    job = Job((BAGS / "swing_wide",), (), Settings.of({}))
    return made_once("outcome_alone", lambda: run(load(job), lambda progress: None))


@pytest.fixture(scope="session")
def weighted_outcome(made_once):
    """One of two trials with dry friction, the second of which has a weight."""
    return made_once("weighted_outcome", _weighted_outcome)


def _weighted_outcome():
    trials = plain_and_weighted(np.random.default_rng(5), torque=dry_friction)
    settings = Settings.of({f"trials.two.added.{WEIGHT.rod}": [WEIGHT.mass, WEIGHT.place]})
    job = Job((Path("one"), Path("two")), (), settings)
    return run(LoadedJob(job, tuple(trials), (), {}), lambda progress: None)


@pytest.fixture(scope="session")
def weighted_content(weighted_outcome, made_once):
    return made_once("weighted_content", lambda: report(weighted_outcome))


@pytest.fixture(scope="session")
def content(outcome, made_once):
    return made_once("content", lambda: report(outcome))


@pytest.fixture(scope="session")
def shown_curves(outcome, made_once):
    return made_once("curves", lambda: curves(outcome))


@pytest.fixture(scope="session")
def report_folder(content, shown_curves, made_once, tmp_path_factory):
    """A folder with that report, drawn; not to be written into."""

    def drawn():
        folder = tmp_path_factory.mktemp("report")
        write_files(folder, {REPORT: json_text(content), CURVES: curves_npz(shown_curves)})
        draw_again(folder, for_paper=True)
        return folder

    return made_once("report_folder", drawn)


@pytest.fixture
def read_content(report_folder):
    """The report as it is read from its file, to be changed at will."""
    return read_report(report_folder / REPORT)

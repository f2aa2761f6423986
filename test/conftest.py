# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What tests stand on: DDS of their own on this machine, signals that arrive, and one finished identification."""

import fcntl
import gc
import importlib
import os
import pickle
import signal

import pytest
from hypothesis import settings

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
    """Let what waits begin first, for others compute beside it; then what takes long, lest it be left to the end."""
    items.sort(key=lambda item: [item.get_closest_marker(marker) is None for marker in ("waits", "long")])


@pytest.fixture(scope="session")
def made_once(tmp_path_factory):
    """Return a function that returns what one of the processes that share the tests out has made for all."""
    folder = tmp_path_factory.getbasetemp()
    folder = folder.parent if "PYTEST_XDIST_WORKER" in os.environ else folder

    def take(name, make):
        file = folder / f"{name}.pickle"
        with (folder / f"{name}.lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not file.exists():
                file.write_bytes(pickle.dumps(make()))
            return pickle.loads(file.read_bytes())

    return take


@pytest.fixture(scope="session")
def finished():
    """The module that identifies and draws; imported here, for the process that shares the tests out needs it not."""
    return importlib.import_module("scenarios.finished")


@pytest.fixture(scope="session")
def outcome(finished, made_once):
    return made_once("outcome", finished.of_example_bags)


@pytest.fixture(scope="session")
def outcome_alone(finished, made_once):
    """One of a single bag, part of which is held out."""
    return made_once("outcome_alone", finished.of_one_bag)


@pytest.fixture(scope="session")
def weighted_outcome(finished, made_once):
    """One of two trials with dry friction, the second of which has a weight."""
    return made_once("weighted_outcome", finished.of_weighted_trials)


@pytest.fixture(scope="session")
def weighted_content(finished, weighted_outcome, made_once):
    return made_once("weighted_content", lambda: finished.content_of(weighted_outcome))


@pytest.fixture(scope="session")
def content(finished, outcome, made_once):
    return made_once("content", lambda: finished.content_of(outcome))


@pytest.fixture(scope="session")
def shown_curves(finished, outcome, made_once):
    return made_once("curves", lambda: finished.curves_of(outcome))


@pytest.fixture(scope="session")
def report_folder(finished, content, shown_curves, made_once, tmp_path_factory):
    """A folder with that report, drawn; not to be written into."""

    def drawn():
        folder = tmp_path_factory.mktemp("report")
        finished.write_report(folder, content, shown_curves)
        return folder

    return made_once("report_folder", drawn)


@pytest.fixture
def read_content(finished, report_folder):
    """The report as it is read from its file, to be changed at will."""
    return finished.report_in(report_folder)

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What `identify` leaves behind when something goes wrong, and what it makes of bags that come and go."""

import io
import os
import shutil
import signal

import pytest
import yaml
from rich.console import Console

from cdp_ident.configuration.settings import Settings
from cdp_ident.nodes.identify import main
from cdp_ident.pipeline import identifier as module
from cdp_ident.pipeline.identifier import Identifier, Request
from cdp_ident.pipeline.job import load, run
from cdp_ident.report.contents import report
from cdp_ident.report.folder import CURVES, FITTED, PAGE, REPORT
from cdp_ident.report.outcome import Job
from scenarios.clean_bags import write_clean_bags

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Clean bags, not to be written into."""
    folder = tmp_path_factory.mktemp("made")
    write_clean_bags(folder, swing=6.0)
    return folder


@pytest.fixture(scope="module")
def found(made):
    """What an identification of one of them came to."""
    return run(load(Job((made / "swing_wide",), (), Settings.of({}))), lambda progress: "enough")


@pytest.fixture
def identified(made, found, tmp_path, monkeypatch):
    """Return a function that lets `identify` come to that, into a folder; it returns the exit code."""

    def run(*options, meanwhile=lambda: None):
        monkeypatch.setattr(module, "run", lambda *_: (meanwhile(), found)[1])
        return main(["--bag", str(made / "swing_wide"), "--out", str(tmp_path / "out"), "--once", *options])

    return run


def test_what_cannot_be_written_is_printed_all_the_same(identified, tmp_path, capsys):
    (tmp_path / "out" / REPORT).mkdir(parents=True)
    assert identified("--force") == 2
    printed = capsys.readouterr()
    assert "Base parameters, all that a free swing depends on" in printed.out
    text = printed.out.partition(f"{FITTED}, which could not be written:\n")[2]
    values = yaml.safe_load(text)["/**"]["ros__parameters"]
    assert values["groups.c1_over_A22"] > 0
    assert "cannot be written: Is a directory" in printed.err
    assert printed.err.splitlines()[-1].startswith("identify: error: ")


def test_a_report_that_cannot_be_printed_or_drawn_is_written_all_the_same(identified, tmp_path, capsys, monkeypatch):
    def fail(*_arguments):
        raise ZeroDivisionError("float division by zero")

    monkeypatch.setattr(module, "print_document", fail)
    monkeypatch.setattr(module, "draw", fail)
    assert identified() == 0
    said = capsys.readouterr().out
    assert "the report cannot be printed: float division by zero" in said
    assert f"report {tmp_path / 'out'}` can draw them: float division by zero" in said
    assert {path.name for path in (tmp_path / "out").iterdir()} == {REPORT, FITTED, CURVES}


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_asked_to_end_when_the_search_is_over_it_writes_what_was_found(identified, tmp_path, monkeypatch, number):
    def interrupted(*arguments):
        signal.raise_signal(number)
        return report(*arguments)

    monkeypatch.setattr(module, "report", interrupted)
    assert identified() == 0
    assert {REPORT, FITTED, CURVES, PAGE} <= {path.name for path in (tmp_path / "out").iterdir()}


def test_of_two_that_write_into_one_folder_both_results_are_kept(identified, tmp_path, capsys, monkeypatch):
    out, drawn = tmp_path / "out", []

    def meanwhile():
        out.mkdir()
        (out / REPORT).write_text("of the other one")

    monkeypatch.setattr(module, "draw", lambda *of: drawn.append(of))
    assert identified("--figures", meanwhile=meanwhile) == 0
    assert (out / REPORT).read_text() == "of the other one"
    assert {path.name for path in (tmp_path / "out_2").iterdir()} == {REPORT, FITTED, CURVES}
    assert drawn == [(tmp_path / "out_2", True)]
    assert f"has written into {out} meanwhile: this one goes into {out}_2" in capsys.readouterr().out


@pytest.fixture
def watching(made, tmp_path):
    """An identifier that watches a folder with one bag, and where what it says is written."""
    said = io.StringIO()
    trials = tmp_path / "trials"
    request = Request((), (), tmp_path / "out", None, None, None, force=False, watch=trials)
    identifier = Identifier(request, Console(file=said), Console(file=io.StringIO()))

    def bring(bag, name):
        shutil.copytree(made / bag, trials / name)
        for file in (trials / name).iterdir():
            os.utime(file, (1000, 1000))
        return trials / name

    bring("swing_wide", "one")
    return identifier, bring, said


def names(loaded):
    return [trial.name for trial in loaded.fit]


def test_the_copy_of_a_watched_bag_is_left_out_and_the_next_trial_is_taken(watching):
    identifier, bring, said = watching
    assert names(identifier.load({})) == ["one"]
    bring("swing_wide", "copy")
    assert names(identifier.load({})) == ["one"]
    assert "copy is left out: " in said.getvalue()
    assert "are the same bag" in said.getvalue()
    bring("swing_folded", "two")
    assert names(identifier.load({})) == ["one", "two"]
    assert not identifier.has_new


def test_a_watched_bag_that_is_deleted_is_left_out_from_then_on(watching):
    identifier, bring, said = watching
    (bag,) = identifier.load({}).job.bags
    bring("swing_folded", "two")
    shutil.rmtree(bag)
    assert names(identifier.load({})) == ["two"]
    assert "one is left out from now on" in said.getvalue()


def test_a_watched_bag_that_was_left_out_is_tried_again_when_its_files_change(watching):
    identifier, bring, said = watching
    bag = bring("swing_folded", "two")
    (file,) = bag.glob("*.mcap")
    content = file.read_bytes()
    file.write_bytes(content[:100])
    os.utime(file, (1000, 1000))
    assert names(identifier.load({})) == ["one"]
    assert "two is left out: " in said.getvalue()
    assert not identifier.has_new
    file.write_bytes(content)
    os.utime(file, (2000, 2000))
    assert identifier.has_new
    assert names(identifier.load({})) == ["one", "two"]


def test_a_watched_trial_that_shows_a_weight_for_the_first_time_is_not_checked(watching, found, monkeypatch):
    identifier, bring, said = watching
    identifier.load({})
    monkeypatch.setattr(identifier, "_latest", found)
    bring("swing_folded", "two")
    weights = {"trials.two.added.outer": [0.05, 0.3], "trials.three.added.outer": [0.05, 0.3]}
    first, second = identifier.load(weights).fit
    assert (first.weights, second.weights[0].mass) == ((), 0.05)
    assert "two is not checked: it is the first one with its weight" in said.getvalue()

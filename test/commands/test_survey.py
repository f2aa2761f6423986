# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bags of several rigs and days, surveyed by real workers."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from cdp_ident.commands.survey import main
from cdp_ident.output_folder import alone_in
from cdp_ident.report.folder import REPORT
from cdp_ident.survey.run import RECORD
from scenarios.fleet import NOON, write_fleet

PATIENCE = 300.0


def read(out):
    return json.loads((out / "survey.json").read_text())


def started(*arguments):
    return subprocess.Popen(
        [sys.executable, "-m", "cdp_ident", "survey", *map(str, arguments)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def until_it_says(process, words):
    for line in process.stderr:
        if words in line:
            return
    raise AssertionError(f"it ended without saying {words!r}")


def estimates(folder):
    """Return everything of the reports below a folder that follows from the bags."""
    found = {}
    for path in sorted(folder.glob(f"pieces/*/{REPORT}")):
        report = json.loads(path.read_text())
        del report["run"], report["search"]["seconds"]
        found[path.parent.name] = report
    return found


@pytest.fixture(scope="module")
def fleet(tmp_path_factory):
    """Two days of one rig and one of another."""
    folder = tmp_path_factory.mktemp("fleet")
    write_fleet(folder / "trials", {"rig1": 2, "rig2": 1}, {})
    return folder


@pytest.fixture(scope="module")
def interrupted(fleet):
    """A survey of it that Ctrl-C ended after a piece; what it said at its end, and its exit code."""
    process = started(fleet / "trials", "--workers", "1", "--out", fleet / "out")
    until_it_says(process, "1 of 3: ")
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=PATIENCE)
    return said, process.returncode


@pytest.mark.campaign
def test_after_an_interruption_the_survey_goes_on_and_then_redoes_only_what_changed(fleet, interrupted, capsys):
    said, code = interrupted
    assert code == 130
    assert "of 3 pieces are kept; the same command goes on" in said
    assert said.splitlines()[-1] == "survey: interrupted"
    trials, out = fleet / "trials", fleet / "out"
    assert main([str(trials), "--workers", "2", "--out", str(out)]) == 0
    output = capsys.readouterr()
    assert "3 bags in 3 pieces, 0 of them kept" not in output.err
    assert "Parameters and effects, since their last change" in output.out
    assert [(rig["name"], len(rig["pieces"])) for rig in read(out)["rigs"]] == [
        ("/rig1/driver", 2),
        ("/rig2/driver", 1),
    ]
    for rig in read(out)["rigs"]:
        for piece in rig["pieces"]:
            names = {path.name for path in (out / piece["folder"]).iterdir()}
            assert names == {"report.json", "report.html", "report.md", "fitted.yaml", "curves.npz", RECORD}

    before = {path: path.stat().st_mtime_ns for path in out.glob(f"pieces/*/{REPORT}")}
    bag = trials / "rig2" / "trial_0"
    shutil.rmtree(bag)
    write_fleet(trials.parent / "again", {"rig2": 1}, {"rig2": 0})
    shutil.move(trials.parent / "again" / "rig2" / "trial_0", bag)
    assert main([str(trials), "--out", str(out)]) == 0
    assert "2 of them kept from before" in capsys.readouterr().err
    changed = [path.parent.name for path, time in before.items() if path.stat().st_mtime_ns != time]
    assert [name.startswith("rig2_driver_2024-05-31") for name in changed] == [True]


def test_what_holds_no_trial_is_told_and_the_code_says_so(fleet, tmp_path, capsys):
    """One of its bags, cut short and joined by one that cannot be read."""
    shutil.copytree(fleet / "trials" / "rig1" / "trial_0", tmp_path / "trials" / "short")
    (file,) = (tmp_path / "trials" / "short").glob("*.mcap")
    file.write_bytes(file.read_bytes()[:20_000])
    (tmp_path / "trials" / "none").mkdir()
    (tmp_path / "trials" / "none" / "none_0.mcap").write_bytes(b"")
    assert main([str(tmp_path / "trials"), "--out", str(tmp_path / "out")]) == 3
    output = capsys.readouterr()
    assert output.err.splitlines()[-1].startswith("survey: error: 1 of 1 pieces have no result; ")
    (piece,) = read(tmp_path / "out")["rigs"][0]["pieces"]
    assert piece["problem"]
    assert not piece["has_report"]
    assert "is empty" in read(tmp_path / "out")["left_out"][0]["reason"]
    assert (tmp_path / "out" / "survey.html").exists()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nowhere"], "nowhere cannot be read"),
        (["."], "there is no bag in"),
        ([], "required"),
        ([".", "--workers", "0"], "0 is not a number from 1 to 1000"),
        ([".", "--workers", "2", "--scheduler", "tcp://127.0.0.1:1"], "give one of the two"),
        ([".", "--config", "nowhere.yaml"], "cannot be read"),
    ],
)
def test_bad_input_is_one_line(arguments, words, tmp_path, monkeypatch, refused):
    monkeypatch.chdir(tmp_path)
    error = refused(main, arguments)
    assert error.startswith("survey: error: ")
    assert words in error


def test_a_second_survey_into_the_folder_of_one_that_runs_is_refused(fleet, tmp_path, capsys):
    place = tmp_path / "pieces"
    place.mkdir()
    with alone_in(place):
        assert main([str(fleet / "trials"), "--workers", "1", "--out", str(tmp_path)]) == 2
    assert f"another survey writes into {place}: " in capsys.readouterr().err
    assert not list(place.iterdir())


def test_without_distributed_a_scheduler_is_refused_in_one_line(fleet, tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "distributed", None)
    arguments = [str(fleet / "trials"), "--out", str(tmp_path), "--scheduler", "tcp://127.0.0.1:1"]
    assert main(arguments) == 2
    assert "pip install distributed" in capsys.readouterr().err.splitlines()[-1]


@pytest.mark.campaign
def test_one_worker_two_of_which_one_is_killed_and_a_cluster_give_the_same(tmp_path, capsys):
    """And it is right: the rig whose friction changed, and when."""
    distributed = pytest.importorskip("distributed")
    trials = tmp_path / "trials"
    write_fleet(trials, {"rig1": 4, "rig2": 4}, {"rig2": 2})
    assert main([str(trials), "--workers", "1", "--out", str(tmp_path / "one")]) == 0

    process = started(trials, "--workers", "2", "--out", tmp_path / "two")
    until_it_says(process, "1 of 8: ")
    os.kill(_worker_of(process.pid), signal.SIGKILL)
    _, said = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, said

    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, host="127.0.0.1"
    ) as local:
        process = started(trials, "--scheduler", local.scheduler_address, "--out", tmp_path / "cluster")
        until_it_says(process, "1 of 8: ")
        os.kill(next(iter(local.workers.values())).pid, signal.SIGKILL)
        _, said = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, said

    assert estimates(tmp_path / "one") == estimates(tmp_path / "two") == estimates(tmp_path / "cluster")
    found = read(tmp_path / "one")
    (change,) = found["changes"]
    assert (change["rig"], change["quantity"]) == ("/rig2/driver", "c2/A22 = c2 / A22")
    assert change["since_start"].startswith(time.strftime("%Y-%m-%d", time.localtime(NOON * 1e-9 + 2 * 86400)))
    assert change["after"]["value"] == pytest.approx(1.5 * change["before"]["value"], rel=0.01)
    (difference,) = found["differences"]
    assert (difference["rig"], difference["others"]) == ("/rig2/driver", ["/rig1/driver"])


def _worker_of(process):
    """Return the process of a worker of a survey."""
    children = Path(f"/proc/{process}/task/{process}/children").read_text().split()
    return next(int(child) for child in children if "spawn_main" in Path(f"/proc/{child}/cmdline").read_text())

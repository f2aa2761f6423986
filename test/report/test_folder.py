# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A report replaces an earlier one as a whole, or not at all."""

import os
from pathlib import Path

import pytest

from cdp_ident.errors import OptionError
from cdp_ident.output_folder import check_folder, write_files
from cdp_ident.report.folder import CURVES, FIGURES, FILES, FITTED, PAGE, REPORT, TEXT, state_of, write_result


def test_files_are_written_into_a_new_folder_and_beside_others(tmp_path):
    folder = tmp_path / "a" / "b"
    check_folder(folder, False, FILES)
    write_files(folder, {"notes.txt": "mine"})
    check_folder(folder, False, FILES)
    write_files(folder, {REPORT: "one", FITTED: "two"})
    there = {path.name: path.read_text() for path in folder.iterdir()}
    assert there == {"notes.txt": "mine", REPORT: "one", FITTED: "two"}


@pytest.mark.parametrize("name", [REPORT, FITTED, "link"])
def test_a_report_that_is_there_is_replaced_only_on_demand(tmp_path, name):
    if name == "link":
        (tmp_path / REPORT).symlink_to("nowhere")
    else:
        write_files(tmp_path, {name: "old"})
    with pytest.raises(OptionError, match="--force"):
        check_folder(tmp_path, False, FILES)
    check_folder(tmp_path, True, FILES)


OLD = dict.fromkeys((REPORT, FITTED, CURVES, PAGE, f"{FIGURES}/a.png", f"{FIGURES}/a.svg"), "old")
OLD[TEXT] = f"old ![a]({FIGURES}/a.svg)"


@pytest.mark.parametrize("killed_at", range(9))
def test_whenever_it_is_killed_there_is_one_report_and_nothing_of_another(tmp_path, monkeypatch, killed_at):
    write_files(tmp_path, OLD)
    changes = 0

    def until_killed(change):
        def counted(*arguments, **named):
            nonlocal changes
            changes += 1
            if changes > killed_at:
                os._exit(0)
            return change(*arguments, **named)

        return counted

    child = os.fork()
    if child == 0:
        for name in ("unlink", "replace", "rename"):
            monkeypatch.setattr(Path, name, until_killed(getattr(Path, name)))
        write_result(tmp_path, dict.fromkeys((REPORT, FITTED, CURVES), "new"), state_of(tmp_path))
        os._exit(0)
    os.waitpid(child, 0)
    there = {path.read_text()[:3] for path in tmp_path.rglob("*") if path.is_file() and path.name[0] != "."}
    report = (tmp_path / REPORT).read_text()
    assert report in {"old", "new"}
    if report == "new":
        assert there == {"new"}
    write_files(tmp_path, {"next": ""})
    assert not list(tmp_path.rglob(".*"))


def test_figures_that_the_report_does_not_link_to_stay(tmp_path):
    write_files(tmp_path, {**OLD, f"{FIGURES}/of_my_thesis.png": "mine"})
    write_result(tmp_path, {REPORT: "new"}, state_of(tmp_path))
    assert [path.name for path in (tmp_path / FIGURES).iterdir()] == ["of_my_thesis.png"]


def test_nothing_is_written_or_removed_through_a_link_in_the_figures_place(tmp_path):
    folder, elsewhere = tmp_path / "report", tmp_path / "elsewhere"
    write_files(folder, {REPORT: "old", TEXT: OLD[TEXT]})
    elsewhere.mkdir()
    (elsewhere / "a.svg").write_text("mine")
    (folder / FIGURES).symlink_to(elsewhere)
    with pytest.raises(OptionError, match="cannot be written: Not a directory"):
        write_files(folder, {f"{FIGURES}/a.svg": "new"})
    write_result(folder, {REPORT: "new"}, state_of(folder))
    assert (elsewhere / "a.svg").read_text() == "mine"


def test_a_report_that_another_process_wrote_meanwhile_stays_and_this_one_goes_beside_it(tmp_path):
    folder = tmp_path / "out"
    seen = state_of(folder)
    assert write_result(folder, {REPORT: "first"}, seen) == folder
    assert write_result(folder, {REPORT: "second"}, seen) == tmp_path / "out_2"
    assert write_result(folder, {REPORT: "third"}, seen) == tmp_path / "out_3"
    assert [(path / REPORT).read_text() for path in sorted(tmp_path.iterdir())] == ["first", "second", "third"]
    assert write_result(folder, {REPORT: "newer"}, state_of(folder)) == folder

"""A report replaces an earlier one as a whole, or not at all."""

import json
import math
import os

import pytest

from cdp_ident.errors import OptionError
from cdp_ident.report import folder as module
from cdp_ident.report.folder import FITTED, REPORT, check_folder, json_text, write_files


def test_files_are_written_into_a_new_folder(tmp_path):
    folder = tmp_path / "a" / "b"
    check_folder(folder, force=False)
    write_files(folder, {REPORT: "one", FITTED: "two"})
    assert {path.name: path.read_text() for path in folder.iterdir()} == {REPORT: "one", FITTED: "two"}


@pytest.mark.parametrize("name", [REPORT, FITTED])
def test_a_report_that_is_there_is_replaced_only_on_demand(tmp_path, name):
    write_files(tmp_path, {name: "old"})
    with pytest.raises(OptionError, match="--force"):
        check_folder(tmp_path, force=False)
    check_folder(tmp_path, force=True)


def test_other_files_do_not_stand_in_the_way(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    check_folder(tmp_path, force=False)
    write_files(tmp_path, {REPORT: "new"})
    assert (tmp_path / "notes.txt").read_text() == "mine"


@pytest.mark.parametrize("out", ["file", "file/below"])
def test_what_is_no_folder_is_refused(tmp_path, out):
    (tmp_path / "file").write_text("")
    with pytest.raises(OptionError, match="is not a folder"):
        check_folder(tmp_path / out, force=True)
    with pytest.raises(OptionError, match="cannot be written"):
        write_files(tmp_path / out, {REPORT: "new"})


@pytest.mark.skipif(os.getuid() == 0, reason="root may write everywhere")
def test_a_folder_without_permission_is_refused(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(OptionError, match="cannot be written to"):
        check_folder(tmp_path / "out", force=False)


def test_a_failure_half_way_leaves_the_old_report_and_nothing_else(tmp_path, monkeypatch):
    write_files(tmp_path, {REPORT: "old", FITTED: "old"})

    def full(_descriptor):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(module.os, "fsync", full)
    with pytest.raises(OptionError, match="No space left"):
        write_files(tmp_path, {REPORT: "new", FITTED: "new"})
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {REPORT: "old", FITTED: "old"}


def test_json_is_strict():
    content = {"a": [math.nan, (math.inf, 1.5)], "b": {"c": -math.inf, 3: True}, "d": "ü"}
    assert json.loads(json_text(content)) == {"a": [None, [None, 1.5]], "b": {"c": None, "3": True}, "d": "ü"}

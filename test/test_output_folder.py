# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Files are written into a folder as a whole, or not at all, and what cannot be written into is refused early."""

import json
import math
import os
import shutil
from types import SimpleNamespace

import pytest

from cdp_ident.errors import OptionError
from cdp_ident.output_folder import check_folder, json_text, write_files


def test_without_force_no_file_is_replaced_that_came_meanwhile(tmp_path):
    check_folder(tmp_path, force=False)
    write_files(tmp_path, {"b": "theirs"}, force=False)
    with pytest.raises(OptionError, match="--force"):
        write_files(tmp_path, {"a": "mine", "b": "mine"}, force=False)
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"b": "theirs"}


@pytest.mark.parametrize("out", ["file", "file/below", "dangling_link"])
def test_what_is_no_folder_is_refused_before_any_work(tmp_path, out):
    (tmp_path / "file").write_text("")
    (tmp_path / "dangling_link").symlink_to(tmp_path / "nowhere")
    with pytest.raises(OptionError, match="is not a folder"):
        check_folder(tmp_path / out, force=True)
    with pytest.raises(OptionError, match="cannot be written"):
        write_files(tmp_path / out, {"a": "new"})


@pytest.mark.skipif(os.getuid() == 0, reason="root may write everywhere")
def test_a_folder_without_permission_is_refused(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(OptionError, match="cannot be written to"):
        check_folder(tmp_path / "out", force=False)


def test_a_failure_half_way_leaves_the_old_report_and_nothing_else(tmp_path, monkeypatch):
    write_files(tmp_path, {"a": "old", "b": "old"})

    def full(_descriptor):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OptionError, match="No space left"):
        write_files(tmp_path, {"a": "new", "b": "new"})
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"a": "old", "b": "old"}


def test_json_is_strict():
    content = {"a": [math.nan, (math.inf, 1.5)], "b": {"c": -math.inf, 3: True}, "d": "ü"}
    assert json.loads(json_text(content)) == {"a": [None, [None, 1.5]], "b": {"c": None, "3": True}, "d": "ü"}


def test_a_disk_with_too_little_space_is_refused_before_any_work(tmp_path, monkeypatch):
    monkeypatch.setattr(shutil, "disk_usage", lambda _: SimpleNamespace(free=1_000_000))
    with pytest.raises(OptionError, match="only 1 MB are free"):
        check_folder(tmp_path, force=False)

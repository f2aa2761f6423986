# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Files take their places whole, whatever another put in the way, and only what is small enough is read."""

import secrets

import pytest

from cdp_ident.files import read_regular, remove_unfinished, write_whole


@pytest.fixture
def foreseen(tmp_path, monkeypatch):
    """The name under which the next file is written before it takes its place."""
    monkeypatch.setattr(secrets, "token_hex", lambda count: "0" * 2 * count)
    return tmp_path / f".cdp_ident-{'0' * 16}"


def test_a_link_in_the_way_of_what_is_unfinished_is_not_followed(tmp_path, foreseen):
    (tmp_path / "secret").write_text("mine")
    foreseen.symlink_to(tmp_path / "secret")
    with pytest.raises(FileExistsError):
        write_whole({tmp_path / "new": b"new"})
    assert (tmp_path / "secret").read_text() == "mine"
    assert not (tmp_path / "new").exists()


def test_a_link_in_its_place_is_replaced_and_not_followed(tmp_path):
    (tmp_path / "elsewhere").write_text("mine")
    (tmp_path / "new").symlink_to("elsewhere")
    write_whole({tmp_path / "new": b"new"})
    assert ((tmp_path / "new").read_text(), (tmp_path / "elsewhere").read_text()) == ("new", "mine")
    assert not (tmp_path / "new").is_symlink()


def test_a_file_may_be_read_by_who_may_read_others(tmp_path):
    write_whole({tmp_path / "new": b""})
    (tmp_path / "other").touch()
    assert (tmp_path / "new").stat().st_mode == (tmp_path / "other").stat().st_mode


def test_only_what_was_left_unfinished_is_removed(tmp_path, foreseen):
    mine = [tmp_path / name for name in (".thesis.unfinished", ".cdp_ident-notes", ".report.html.1.unfinished")]
    for path in (*mine, foreseen):
        path.touch()
    remove_unfinished(tmp_path)
    assert sorted(tmp_path.iterdir()) == sorted(mine)


def test_a_file_is_read_up_to_its_limit(tmp_path):
    (tmp_path / "file").write_bytes(b"12345")
    assert read_regular(tmp_path / "file", 5) == b"12345"
    with pytest.raises(OSError, match="larger than 4 bytes"):
        read_regular(tmp_path / "file", 4)

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bags in folders, and folders into which bags come one after the other."""

import os

import pytest

from cdp_ident.bag.folders import WatchedFolder, bags_below
from cdp_ident.errors import BagError, OptionError


def make(folder, *names):
    folder.mkdir(parents=True, exist_ok=True)
    for name in names:
        (folder / name).touch()


def test_bags_are_found_at_any_depth_and_once(tmp_path):
    make(tmp_path / "rig1" / "one", "one_0.mcap", "metadata.yaml")
    make(tmp_path / "rig1" / "split", "split_0.mcap", "split_1.mcap", "metadata.yaml")
    make(tmp_path / "rig2" / "old" / "two", "two_0.db3.zstd", "metadata.yaml")
    found = bags_below([tmp_path, tmp_path / "rig1", tmp_path / "rig1" / "one"])
    assert [bag.name for bag in found] == ["one", "split", "two"]


def test_recordings_without_metadata_are_bags_too(tmp_path):
    make(tmp_path / "killed", "killed_0.mcap")
    make(tmp_path / "loose", "a.mcap", "b.db3", "notes.txt")
    assert [bag.name for bag in bags_below([tmp_path])] == ["killed", "a.mcap", "b.db3"]
    assert bags_below([tmp_path / "loose" / "a.mcap"]) == [tmp_path / "loose" / "a.mcap"]


def test_a_folder_without_bags_is_refused(tmp_path):
    make(tmp_path / "empty", "metadata.yaml")
    with pytest.raises(BagError, match=r"there is no bag in .*empty"):
        bags_below([tmp_path / "empty"])
    with pytest.raises(BagError, match="nowhere cannot be read"):
        bags_below([tmp_path / "nowhere"])


def complete(bag, when):
    bag.mkdir(parents=True, exist_ok=True)
    for name in ("messages.mcap", "metadata.yaml"):
        (bag / name).write_text("")
        os.utime(bag / name, (when, when))


def test_a_bag_is_new_once_it_is_complete_and_until_it_is_taken_as_it_is(tmp_path):
    watched, one = WatchedFolder(tmp_path), tmp_path / "one"
    one.mkdir()
    (one / "messages.mcap").write_bytes(b"")
    assert watched.new() == []
    complete(one, 1000)
    assert watched.new() == [one]
    watched.take(one)
    assert watched.new() == []
    complete(one, 2000)
    assert watched.new() == [one]
    (one / "messages.mcap").unlink()
    (one / "metadata.yaml").unlink()
    assert watched.new() == []
    watched.take(one)


def test_bags_come_in_the_order_in_which_they_were_completed(tmp_path):
    complete(tmp_path / "a", 2000)
    complete(tmp_path / "b", 1000)
    assert WatchedFolder(tmp_path).new() == [tmp_path / "b", tmp_path / "a"]


def test_a_folder_that_is_not_there_yet_is_waited_for(tmp_path):
    watched = WatchedFolder(tmp_path / "later")
    assert watched.new() == []
    complete(tmp_path / "later/one", 1000)
    assert watched.new() == [tmp_path / "later/one"]


def test_a_file_in_its_place_is_refused(tmp_path):
    (tmp_path / "trials").write_text("")
    with pytest.raises(OptionError, match="trials is no folder"):
        WatchedFolder(tmp_path / "trials")


@pytest.mark.skipif(os.getuid() == 0, reason="root may read everywhere")
def test_a_folder_that_may_not_be_read_is_refused(tmp_path):
    tmp_path.chmod(0o300)
    with pytest.raises(OptionError, match="can be read"):
        WatchedFolder(tmp_path)


def test_a_bag_whose_metadata_comes_before_its_messages_is_waited_for(tmp_path):
    complete(tmp_path / "one", 1000)
    (tmp_path / "one/messages.mcap").unlink()
    watched = WatchedFolder(tmp_path)
    assert watched.new() == []
    complete(tmp_path / "one", 2000)
    assert watched.new() == [tmp_path / "one"]


def test_a_bag_whose_files_still_change_is_waited_for(tmp_path):
    complete(tmp_path / "one", 1000)
    with (tmp_path / "one/messages.mcap").open("ab") as stream:
        stream.write(b"more")
    assert WatchedFolder(tmp_path).new() == []
    complete(tmp_path / "one", 1000)
    assert WatchedFolder(tmp_path).new() == [tmp_path / "one"]

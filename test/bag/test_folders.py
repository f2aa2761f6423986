# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The bags below folders."""

import pytest

from cdp_ident.bag.folders import bags_below
from cdp_ident.errors import BagError


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

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is needed to repeat a run."""

import hashlib
import importlib.metadata
import re

import pytest

from cdp_ident.errors import BagError
from cdp_ident.report.provenance import bag_checksums, versions


def test_a_bag_s_files_with_messages_are_summed(tmp_path):
    (tmp_path / "b_0.mcap").write_bytes(b"one")
    (tmp_path / "b_1.mcap.zstd").write_bytes(b"two")
    (tmp_path / "metadata.yaml").write_bytes(b"changes when touched")
    sums = {name: hashlib.sha256(data).hexdigest() for name, data in (("b_0.mcap", b"one"), ("b_1.mcap.zstd", b"two"))}
    assert bag_checksums(tmp_path) == bag_checksums(tmp_path / "metadata.yaml") == sums
    assert bag_checksums(tmp_path / "b_0.mcap") == {"b_0.mcap": sums["b_0.mcap"]}


def test_a_missing_bag_is_refused(tmp_path):
    with pytest.raises(BagError, match="nowhere"):
        bag_checksums(tmp_path / "nowhere")


def test_versions_name_the_packages_that_numbers_depend_on():
    assert {"python", "cdp_ident", "numpy", "scipy", "numba"} <= set(versions())


def test_versions_are_told_as_far_as_they_are_known(monkeypatch):
    def nothing(name):
        raise importlib.metadata.PackageNotFoundError(name)

    monkeypatch.setattr(importlib.metadata, "version", nothing)
    assert re.fullmatch(r"\d+\.\d+\.\d+, from its source folder", versions()["cdp_ident"])
    assert versions()["mcap"] == "not installed as a package"

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is needed to repeat a run, beside its bags."""

import importlib.metadata
import re

from cdp_ident.report.provenance import versions


def test_versions_name_the_packages_that_numbers_depend_on():
    assert {"python", "cdp_ident", "numpy", "scipy", "numba"} <= set(versions())


def test_versions_are_told_as_far_as_they_are_known(monkeypatch):
    def nothing(name):
        raise importlib.metadata.PackageNotFoundError(name)

    monkeypatch.setattr(importlib.metadata, "version", nothing)
    assert re.fullmatch(r"\d+\.\d+\.\d+, from its source folder", versions()["cdp_ident"])
    assert versions()["mcap"] == "not installed as a package"

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Finds the bags below folders."""

import os
from collections.abc import Sequence
from pathlib import Path

from cdp_ident.bag.metadata import METADATA_FILE
from cdp_ident.bag.reader import is_storage_file
from cdp_ident.errors import BagError


def bags_below(folders: Sequence[Path]) -> list[Path]:
    """Return the bags in folders and everything below them, each once, in the order of their paths.

    A folder with `metadata.yaml` is a bag, one without it whose only recording is one file is too; of several files
    without metadata each is a bag. Links to folders are not followed below those that are given.

    Raises:
        BagError: a folder is not there or cannot be read, or there is no bag in it.
    """
    found: dict[Path, Path] = {}
    for folder in folders:
        here = [folder] if folder.is_file() else _below(folder)
        if not here:
            raise BagError(f"there is no bag in {folder}, nor below it: expected folders with .mcap or .db3 files")
        found |= {bag.resolve(): bag for bag in here}
    return [found[path] for path in sorted(found)]


def _below(folder: Path) -> list[Path]:
    def refuse(error: OSError) -> None:
        raise BagError(f"{error.filename} cannot be read: {error.strerror or error}") from error

    bags: list[Path] = []
    for place, folders, names in os.walk(folder, onerror=refuse):
        here = Path(place)
        files = [here / name for name in names if is_storage_file(name)]
        if METADATA_FILE in names and files:
            bags.append(here)
            folders.clear()
        else:
            bags += [here] if len(files) == 1 else files
    return bags

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bags in folders: those that are there, and those that are recorded one after the other."""

import os
import time
from collections.abc import Sequence
from pathlib import Path

from cdp_ident.bag.metadata import METADATA_FILE
from cdp_ident.bag.reader import is_storage_file, storage_files
from cdp_ident.errors import BagError, OptionError

_SETTLED_NS = 1_000_000_000
"""Files that were changed less than this ago [ns] may still be being copied."""

_Files = tuple[tuple[str, int, int], ...]
"""Name, size and time of change [ns] of each file of a bag."""


def bags_below(folders: Sequence[Path]) -> list[Path]:
    """Return the bags in folders and everything below them, each once, in the order of their paths.

    A folder with `metadata.yaml` is a bag, one without it whose only recording is one file is too; of several files
    without metadata each is a bag. Links to folders are not followed below those that are given.

    Raises BagError where a folder is not there or cannot be read, or there is no bag in it.
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


class WatchedFolder:
    """Tells which bags of a folder are complete and not taken yet."""

    def __init__(self, folder: Path) -> None:
        """Watch a folder; one that is not there yet is waited for. Raises OptionError where it is none to be read."""
        if folder.exists() and not (folder.is_dir() and os.access(folder, os.R_OK | os.X_OK)):
            raise OptionError(f"{folder} is no folder that can be read: --watch takes the one that is recorded into")
        self.folder = folder
        self._taken: dict[Path, _Files] = {}

    def new(self) -> list[Path]:
        """Return the complete bags that have not been taken as they are, the one completed first before the others.

        A bag is complete once it has its metadata, which whoever records writes last, and its files no longer change.
        """
        found = [
            (max(changed for _, _, changed in files), bag)
            for bag in {path.parent for path in self.folder.glob(f"*/{METADATA_FILE}")}
            if (files := _files(bag)) and self._taken.get(bag) != files
        ]
        now = time.time_ns()
        return [bag for changed, bag in sorted(found) if abs(now - changed) >= _SETTLED_NS]

    def take(self, bag: Path) -> None:
        """Do not return a bag any more, until its files change."""
        self._taken[bag] = _files(bag)


def _files(bag: Path) -> _Files:
    """Return what tells whether a bag has changed; nothing where it has no messages, or is not there any more."""
    try:
        files = [*storage_files(bag), bag / METADATA_FILE]
        return tuple((file.name, (status := file.stat()).st_size, status.st_mtime_ns) for file in files)
    except (OSError, BagError):
        return ()

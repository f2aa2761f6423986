# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The folder that a recorder's bags go to."""

from collections.abc import Iterator
from datetime import datetime
from pathlib import Path

from cdp_ident.bag.writer import BagWriter, Salvaged, complete_bag, is_incomplete
from cdp_ident.errors import BagError, RigError
from cdp_ident.files import free_space
from cdp_ident.outside_text import shown

_LONGEST_NAME = 200
"""Bytes; file systems take 255, and the time and endings follow."""
_LEAST_FREE = 50_000_000
"""Least free space on the disk [bytes]: ten minutes at 1 kHz need more."""


class BagFolder:
    """Makes bags in a folder, each in a folder of its own."""

    def __init__(self, path: Path, name: str) -> None:
        """Take a folder `path` for bags; their names are `name` and the time. Raises `RigError` where that is none."""
        if not _is_name(name):
            raise RigError(f"{shown(name)!r} is no name for bags: expected a name without folders")
        self.path = path.absolute()
        self._name = name

    def check(self) -> bool:
        """Make the folder if it is missing; return whether it was. Raises `RigError` where nothing can be written."""
        folder = self.path
        try:
            missing = not folder.exists()
            folder.mkdir(parents=True, exist_ok=True)
            free = free_space(folder)
        except OSError as error:
            raise RigError(f"nothing can be recorded in {folder}: {error.strerror or error}") from error
        if free < _LEAST_FREE:
            raise RigError(f"nothing can be recorded in {folder}: only {free / 1e6:.0f} MB are free on its disk")
        return missing

    def new_bag(self, now_ns: int) -> BagWriter:
        """Begin a bag at a time [ns since the epoch], whichever other recorders begin theirs in the same second.

        Raises `BagError` where it cannot be made.
        """
        when = datetime.fromtimestamp(now_ns * 1e-9).astimezone().strftime("%Y%m%d_%H%M%S")
        name = f"{self._name}_{when}"
        folder, number = self.path / name, 1
        while True:
            try:
                return BagWriter(folder)
            except BagError as error:
                if not isinstance(error.__cause__, FileExistsError):
                    raise
            number += 1
            folder = self.path / f"{name}_{number}"

    def complete_unfinished(self) -> Iterator[Salvaged | BagError]:
        """Complete the bags that a recorder left unfinished; yield each, or why it is left as it is."""
        try:
            folders = sorted(path for path in self.path.iterdir() if path.is_dir())
        except OSError as error:
            yield BagError(f"{self.path} cannot be read: {error.strerror or error}")
            return
        for folder in folders:
            try:
                if is_incomplete(folder) and (salvaged := complete_bag(folder)):
                    yield salvaged
            except BagError as error:
                yield error


def _is_name(name: str) -> bool:
    """Return whether a text can begin the names of folders and does not lead to another folder."""
    return name.isprintable() and 0 < len(name.encode()) <= _LONGEST_NAME and name[0] != "." and Path(name).name == name

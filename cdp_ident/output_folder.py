# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Folders that results are written into: refused before any work, and written whole, by one process at a time."""

import fcntl
import json
import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from typing import Any

from cdp_ident.errors import OptionError
from cdp_ident.files import free_space, remove_unfinished, write_whole

_LEAST_FREE = 20_000_000
"""With less space on the disk [bytes] nothing is begun: a report with its pictures takes a third of that."""


def check_folder(folder: Path, force: bool, files: Sequence[str] = ()) -> None:
    """Refuse a folder that files cannot be written into, before any work is done.

    Raises:
        OptionError: it holds one of them and `force` is not given, or it cannot be written to.
    """
    if not force:
        _refuse_to_replace(folder, files)
    existing = next(path for path in (folder, *folder.absolute().parents) if path.exists() or path.is_symlink())
    if not existing.is_dir():
        raise OptionError(f"{existing} is not a folder: give another --out")
    try:
        free = free_space(existing)
    except OSError as error:
        raise OptionError(f"{existing} cannot be written to ({error.strerror}): give another --out") from error
    if free < _LEAST_FREE:
        raise OptionError(f"only {free / 1e6:.0f} MB are free on the disk of {existing}: give another --out")


def _refuse_to_replace(folder: Path, files: Iterable[str]) -> None:
    """Raise OptionError where a folder holds one of the files, be it a link that leads nowhere."""
    if there := [name for name in files if os.path.lexists(folder / name)]:
        raise OptionError(f"{folder} holds {' and '.join(there)} already: give another --out, or --force to replace")


@contextmanager
def alone_in(folder: Path, wait: bool = True) -> Iterator[None]:
    """Keep other processes from writing into a folder that is there; `wait` for the one that does.

    Raises OSError where it cannot be opened, BlockingIOError where another one writes into it and is not waited for.
    """
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        with suppress(OSError) if wait else nullcontext():  # file systems without locks
            fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
        yield
    finally:
        os.close(descriptor)


def write_files(
    folder: Path,
    contents: Mapping[str, str | bytes],
    instead_of: Sequence[str] = (),
    force: bool = True,
    below: Sequence[str] = (),
) -> None:
    """Write files into a folder and those below it; earlier ones are replaced when all new ones are complete.

    Args:
        folder: it is made where it is not there.
        contents: what to write, by the files' names in the folder. The first file takes its place at once, without
            a moment at which there is none.
        instead_of: files that go when all new ones are complete, before any takes its place.
        force: without it no file is replaced, be it one that another process wrote meanwhile.
        below: folders in it from which what a killed process left unfinished goes as well.

    Raises:
        OptionError: the folder or a file cannot be written, or is there without `force`.
    """
    with writing(folder, contents):
        if not force:
            _refuse_to_replace(folder, contents)
        replace_files(folder, contents, instead_of, below)


@contextmanager
def writing(folder: Path, contents: Mapping[str, str | bytes]) -> Iterator[None]:
    """Make the folders of files, and write into them alone."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with alone_in(folder):
            for path in {(folder / name).parent for name in contents} - {folder}:
                path.mkdir(exist_ok=True)
                os.close(os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW))
            yield
    except OSError as error:
        raise OptionError(f"{folder} cannot be written: {error.strerror or error}; give another --out") from error


def replace_files(
    folder: Path, contents: Mapping[str, str | bytes], instead_of: Sequence[str], below: Sequence[str]
) -> None:
    """Do what `write_files` does, while `writing` into the folder."""

    def remove() -> None:
        for name in instead_of:
            if name not in list(contents)[:1]:
                (folder / name).unlink(missing_ok=True)

    for path in (folder, *(folder / name for name in below)):
        if path.is_dir() and not path.is_symlink():
            remove_unfinished(path)
    files = {name: content.encode() if isinstance(content, str) else content for name, content in contents.items()}
    write_whole({folder / name: content for name, content in files.items()}, remove)


def json_text(content: Any) -> str:
    """Return strict JSON: what is not a finite number becomes null."""
    return json.dumps(finite(content), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def finite(content: Any) -> Any:
    """Return plain values with null in the place of what is not a finite number."""
    if isinstance(content, Mapping):
        return {str(key): finite(value) for key, value in content.items()}
    if isinstance(content, list | tuple):
        return [finite(value) for value in content]
    if isinstance(content, float) and not math.isfinite(content):
        return None
    return content

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The folder that a report is written into."""

import fcntl
import json
import math
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from typing import Any

from cdp_ident.errors import OptionError
from cdp_ident.files import free_space, read_regular, remove_unfinished, write_whole

REPORT, FITTED, CURVES = "report.json", "fitted.yaml", "curves.npz"
PAGE, TEXT, FIGURES = "report.html", "report.md", "figures"
COMPARISON_PAGE, COMPARISON_TEXT = "compare.html", "compare.md"
FILES = (REPORT, FITTED, CURVES, PAGE, TEXT, FIGURES)
"""Those of a report; in the last one, a folder, there are the figures that `report.md` links to."""
PICTURES = (".png", ".svg")
"""Endings of the files that a figure is drawn as."""
State = tuple[int, int] | None
"""Which `report.json` is in a folder; None where there is none."""
_LINK = re.compile(rf"\]\({FIGURES}/([^/)]+)\.svg\)")
_LARGEST_TEXT = 1 << 24
_LEAST_FREE = 20_000_000
"""With less space on the disk [bytes] nothing is begun: a report with its pictures takes a third of that."""


def check_folder(folder: Path, force: bool, files: Sequence[str] = FILES) -> None:
    """Refuse a folder that files cannot be written into, before any work is done; those of a report, if none are named.

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


def state_of(folder: Path) -> State:
    """Return which `report.json` is in a folder."""
    with suppress(OSError):
        file = (folder / REPORT).lstat()
        return file.st_ino, file.st_mtime_ns
    return None


def write_result(folder: Path, contents: Mapping[str, str | bytes], seen: State) -> Path:
    """Write the files of a result, `report.json` first among them; whatever was made of another one goes.

    Whenever this process is killed there is one whole `report.json`, and nothing beside it that is not of it.
    Where another process wrote a report into the folder that was not `seen` there before, that one stays and this one
    goes into a new folder beside it. Returns where it is.

    Raises:
        OptionError: the folder or a file cannot be written.
    """
    place, number = folder, 1
    while True:
        with _writing(place, contents):
            if state_of(place) == seen:
                _replace(place, contents, (*FILES[:-1], *drawn_with(place)))
                return place
        number, seen = number + 1, None
        place = folder.parent / f"{folder.name}_{number}"


def write_files(
    folder: Path, contents: Mapping[str, str | bytes], instead_of: Sequence[str] = (), force: bool = True
) -> None:
    """Write files into a folder and those below it; earlier ones are replaced when all new ones are complete.

    Args:
        folder: it is made where it is not there.
        contents: what to write, by the files' names in the folder. The first file takes its place at once, without
            a moment at which there is none.
        instead_of: files that go when all new ones are complete, before any takes its place.
        force: without it no file is replaced, be it one that another process wrote meanwhile.

    Raises:
        OptionError: the folder or a file cannot be written, or is there without `force`.
    """
    with _writing(folder, contents):
        if not force:
            _refuse_to_replace(folder, contents)
        _replace(folder, contents, instead_of)


@contextmanager
def _writing(folder: Path, contents: Mapping[str, str | bytes]) -> Iterator[None]:
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


def _replace(folder: Path, contents: Mapping[str, str | bytes], instead_of: Sequence[str]) -> None:
    def remove() -> None:
        for name in instead_of:
            if name not in list(contents)[:1]:
                (folder / name).unlink(missing_ok=True)

    for path in (folder, folder / FIGURES):
        if path.is_dir() and not path.is_symlink():
            remove_unfinished(path)
    files = {name: content.encode() if isinstance(content, str) else content for name, content in contents.items()}
    write_whole({folder / name: content for name, content in files.items()}, remove)


def drawn_with(folder: Path) -> list[str]:
    """Return the files in FIGURES that were drawn with the `report.md` of a folder, which links to each."""
    if (folder / FIGURES).is_symlink():
        return []
    try:
        text = read_regular(folder / TEXT, _LARGEST_TEXT).decode(errors="replace")
    except OSError:
        return []
    return [f"{FIGURES}/{name}{ending}" for name in _LINK.findall(text) for ending in PICTURES]


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

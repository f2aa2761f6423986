"""The folder that a report is written into."""

import json
import math
import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from cdp_ident.errors import OptionError
from cdp_ident.free_space import free_space

REPORT, FITTED, CURVES = "report.json", "fitted.yaml", "curves.npz"
PAGE, TEXT, FIGURES = "report.html", "report.md", "figures"
COMPARISON_PAGE, COMPARISON_TEXT = "compare.html", "compare.md"
FILES = (REPORT, FITTED, CURVES, PAGE, TEXT, FIGURES)
PICTURES = (".png", ".svg")
"""Endings of the files in FIGURES that belong to a report."""
_UNFINISHED = ".unfinished"
_LEAST_FREE = 20_000_000
"""With less space on the disk [bytes] nothing is begun: a report with its pictures takes a third of that."""


def check_folder(folder: Path, force: bool, files: Sequence[str] = FILES) -> None:
    """Refuse a folder that files cannot be written into, before any work is done; those of a report, if none are named.

    Raises:
        OptionError: it holds one of them and `force` is not given, or it cannot be written to.
    """
    there = [name for name in files if (folder / name).exists()]
    if there and not force:
        raise OptionError(f"{folder} holds {' and '.join(there)} already: give another --out, or --force to replace")
    existing = next(path for path in (folder, *folder.absolute().parents) if path.exists() or path.is_symlink())
    if not existing.is_dir():
        raise OptionError(f"{existing} is not a folder: give another --out")
    try:
        free = free_space(existing)
    except OSError as error:
        raise OptionError(f"{existing} cannot be written to ({error.strerror}): give another --out") from error
    if free < _LEAST_FREE:
        raise OptionError(f"only {free / 1e6:.0f} MB are free on the disk of {existing}: give another --out")


def clean_folder(folder: Path) -> None:
    """Remove what a process that was killed while it wrote into a folder left there."""
    for path in (*folder.glob(f".*{_UNFINISHED}"), *(folder / FIGURES).glob(f".*{_UNFINISHED}")):
        process = path.name.removesuffix(_UNFINISHED).rpartition(".")[2]
        if not (process.isdecimal() and _runs(int(process))):
            with suppress(OSError):
                path.unlink()


def _runs(process: int) -> bool:
    try:
        os.kill(process, 0)
    except PermissionError:
        return True
    except (OSError, OverflowError):
        return False
    return True


def write_result(folder: Path, contents: Mapping[str, str | bytes]) -> None:
    """Write the files of a result, `report.json` first among them; whatever was made of another one goes.

    Whenever this process is killed there is one whole `report.json`, and nothing beside it that is not of it.

    Raises:
        OptionError: the folder or a file cannot be written.
    """
    write_files(folder, contents, instead_of=FILES)


def write_files(folder: Path, contents: Mapping[str, str | bytes], instead_of: Sequence[str] = ()) -> None:
    """Write files into a folder and those below it; earlier ones are replaced when all new ones are complete.

    Args:
        folder: it is made where it is not there.
        contents: what to write, by the files' names in the folder. The first file takes its place at once, without
            a moment at which there is none.
        instead_of: files and folders that go when all new ones are complete, before any takes its place.

    Raises:
        OptionError: the folder or a file cannot be written.
    """
    unfinished = {
        name: (folder / name).with_name(f".{Path(name).name}.{os.getpid()}{_UNFINISHED}") for name in contents
    }
    try:
        for path in {folder, *(path.parent for path in unfinished.values())}:
            path.mkdir(parents=True, exist_ok=True)
        try:
            for name, content in contents.items():
                with unfinished[name].open("wb") as stream:
                    stream.write(content.encode() if isinstance(content, str) else content)
                    stream.flush()
                    os.fsync(stream.fileno())
            for name in instead_of:
                if name not in list(contents)[:1]:
                    _remove(folder / name)
            for name, path in unfinished.items():
                path.replace(folder / name)
        finally:
            for path in unfinished.values():
                path.unlink(missing_ok=True)
    except OSError as error:
        raise OptionError(f"{folder} cannot be written: {error.strerror or error}; give another --out") from error


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        for picture in path.iterdir():
            if picture.suffix in PICTURES:
                picture.unlink()
    else:
        path.unlink(missing_ok=True)


def json_text(content: Any) -> str:
    """Return strict JSON: what is not a finite number becomes null."""
    return json.dumps(_finite(content), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _finite(content: Any) -> Any:
    if isinstance(content, Mapping):
        return {str(key): _finite(value) for key, value in content.items()}
    if isinstance(content, list | tuple):
        return [_finite(value) for value in content]
    if isinstance(content, float) and not math.isfinite(content):
        return None
    return content

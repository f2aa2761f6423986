"""The folder that a report is written into."""

import json
import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from cdp_ident.errors import OptionError

REPORT, FITTED, CURVES = "report.json", "fitted.yaml", "curves.npz"
PAGE, TEXT, FIGURES = "report.html", "report.md", "figures"
COMPARISON_PAGE, COMPARISON_TEXT = "compare.html", "compare.md"
FILES = (REPORT, FITTED, CURVES, PAGE, TEXT, FIGURES)


def check_folder(folder: Path, force: bool, files: Sequence[str] = FILES) -> None:
    """Refuse a folder that files cannot be written into, before any work is done; those of a report, if none are named.

    Raises:
        OptionError: it holds one of them and `force` is not given, or it cannot be written to.
    """
    there = [name for name in files if (folder / name).exists()]
    if there and not force:
        raise OptionError(f"{folder} holds {' and '.join(there)} already: give another --out, or --force to replace")
    existing = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    if not existing.is_dir():
        raise OptionError(f"{existing} is not a folder: give another --out")
    if not os.access(existing, os.W_OK | os.X_OK):
        raise OptionError(f"{existing} cannot be written to: give another --out")


def write_files(folder: Path, contents: Mapping[str, str | bytes]) -> None:
    """Write files into a folder and those below it; earlier ones are replaced when all new ones are complete.

    Raises:
        OptionError: the folder or a file cannot be written.
    """
    unfinished = {name: (folder / name).with_name(f".{Path(name).name}.{os.getpid()}.unfinished") for name in contents}
    try:
        for path in {folder, *(path.parent for path in unfinished.values())}:
            path.mkdir(parents=True, exist_ok=True)
        try:
            for name, content in contents.items():
                with unfinished[name].open("wb") as stream:
                    stream.write(content.encode() if isinstance(content, str) else content)
                    stream.flush()
                    os.fsync(stream.fileno())
            for name, path in unfinished.items():
                path.replace(folder / name)
        finally:
            for path in unfinished.values():
                path.unlink(missing_ok=True)
    except OSError as error:
        raise OptionError(f"{folder} cannot be written: {error.strerror or error}; give another --out") from error


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

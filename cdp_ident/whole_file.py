# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Files that take their places when they are complete."""

import os
import re
import secrets
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path

_UNFINISHED = re.compile(r"\.cdp_ident-[0-9a-f]{16}")


def beside(path: Path) -> Path:
    """Return a name in a file's folder that nothing has, and that nobody can foresee."""
    return path.with_name(f".cdp_ident-{secrets.token_hex(8)}")


def write_whole(files: Mapping[Path, bytes], before: Callable[[], None] = lambda: None) -> None:
    """Write files, each into a folder that is there; they take their places when all are complete and on the disk.

    A link in a file's place is replaced, not followed. `before` is called when all are complete. Raises OSError.
    """
    unfinished = {path: beside(path) for path in files}
    try:
        for path, content in files.items():
            with unfinished[path].open("xb") as stream:
                stream.write(content)
                stream.flush()
                os.fsync(stream.fileno())
        before()
        for path in files:
            unfinished[path].replace(path)
    finally:
        for path in unfinished.values():
            path.unlink(missing_ok=True)


def remove_unfinished(folder: Path) -> None:
    """Remove what a killed process left `beside` the files of a folder, into which nobody else may be writing.

    Raises OSError.
    """
    for path in folder.iterdir():
        if not _UNFINISHED.fullmatch(path.name):
            continue
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)

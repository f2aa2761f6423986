# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Files that others made, opened only where they are regular files, and our own, which take their places complete."""

import errno
import os
import re
import secrets
import shutil
import stat
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import BinaryIO

_UNFINISHED = re.compile(r"\.cdp_ident-[0-9a-f]{16}")


def open_regular(path: Path) -> BinaryIO:
    """Open a regular file for reading.

    Raises OSError where there is none, or where it is a pipe, a socket or a device: those may have no end, and even
    opening one may wait for ever.
    """
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC)
    except ValueError as error:  # a path with a zero byte in it
        raise OSError(errno.EINVAL, str(error), str(path)) from error
    if not stat.S_ISREG(os.fstat(descriptor).st_mode):
        os.close(descriptor)
        raise OSError(errno.EINVAL, "it is not a regular file", str(path))
    return os.fdopen(descriptor, "rb")


def read_regular(path: Path, most: int) -> bytes:
    """Return the contents of a regular file of at most so many bytes. Raises OSError where that is not possible."""
    with open_regular(path) as stream:
        # All of the memory that is asked for is taken at first.
        content = stream.read(min(most, os.fstat(stream.fileno()).st_size) + 1)
    if len(content) > most:
        raise OSError(errno.EFBIG, f"it is larger than {most} bytes", str(path))
    return content


def free_space(folder: Path) -> int:
    """Return the free space on a folder's disk [bytes]. Raises OSError where nothing can be written to the folder."""
    with tempfile.TemporaryFile(dir=folder):
        pass
    return shutil.disk_usage(folder).free


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
    for path in [path for path in folder.iterdir() if _UNFINISHED.fullmatch(path.name)]:
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)

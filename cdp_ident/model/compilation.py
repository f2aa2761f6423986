"""How the model's inner loops are compiled, and where the compiled code is kept.

Compiling takes seconds, so numba keeps the result on disk. It looks only at the file of the function it was asked for
when it decides whether a kept result is still good, while our loops are made of functions from several files. Therefore
the folder for the results is named by a checksum of all files of this subpackage, which holds everything that is
compiled: a change to any of them starts an empty folder, and folders unused for a month are removed. Where nothing can
be kept (a full disk, a home that is read-only or none at all) or a kept result is damaged, the code is compiled each
time.
"""

import functools
import hashlib
import os
import re
import shutil
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import numba.core.config
from numba.extending import register_jitable

Compilable = Callable[..., Any]

_MODEL = Path(__file__).parent
_UNUSED_FOR = 30 * 86400.0
"""A folder that no process has used for so long is removed [s]."""


def _cache_folder() -> str | None:
    """Return the folder for compiled code; None where there is none that is the user's own."""
    digest = hashlib.sha256()
    for path in sorted(_MODEL.rglob("*.py")):
        digest.update(path.read_bytes())
    try:
        user_cache = os.environ.get("XDG_CACHE_HOME") or Path("~/.cache").expanduser()
        folder = Path(numba.core.config.CACHE_DIR or Path(user_cache) / "cdp_ident") / digest.hexdigest()[:16]
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
        folder.touch()
        _remove_unused(folder)
    except (OSError, RuntimeError):  # RuntimeError: there is no home
        return None
    return str(folder)


def _remove_unused(folder: Path) -> None:
    """Remove the folders of other versions beside this one that were not used for long."""
    for other in folder.parent.iterdir():
        is_one = re.fullmatch("[0-9a-f]{16}", other.name) and other.is_dir() and not other.is_symlink()
        if is_one and other.stat().st_mtime < time.time() - _UNUSED_FOR:
            shutil.rmtree(other, ignore_errors=True)


_CACHE_FOLDER = _cache_folder()
# Floating point as C compilers do it: no exception for a division by zero, sums in any order. Without these two LLVM
# does not vectorise the loops over lanes, which then take six times as long (docs/explanation/performance.md).
_FLOATING_POINT = {"error_model": "numpy", "fastmath": True}


# Loops alone are called from Python. What they are made of is compiled once for each kind of arguments, literal numbers
# among them being numbers (numba would compile a function anew for -1, for 0 and for a variable), without the code that
# would take Python's objects apart for each.
_PART = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}


def inlined(function: Compilable) -> Compilable:
    """Let a function become a part of each compiled loop that calls it."""
    return register_jitable(forceinline=True, **_PART, **_FLOATING_POINT)(function)


def part(function: Compilable) -> Compilable:
    """Let compiled loops call a function."""
    return register_jitable(**_PART, **_FLOATING_POINT)(function)


def compiled(function: Compilable) -> Compilable:
    """Compile an inner loop; it runs without Python's global lock and is kept on disk."""
    options = {"nogil": True, **_FLOATING_POINT}
    if _CACHE_FOLDER is None:
        return numba.njit(function, **options)
    configured = numba.core.config.CACHE_DIR
    numba.core.config.CACHE_DIR = _CACHE_FOLDER
    try:
        loop = numba.njit(function, cache=True, **options)
    except (OSError, RuntimeError):  # numba's word for a folder that cannot be written to
        return numba.njit(function, **options)
    finally:
        numba.core.config.CACHE_DIR = configured
    cache = loop._cache  # numba has no public way to go on without one
    cache.load_overload = _or_none(cache.load_overload)
    cache.save_overload = _or_none(cache.save_overload)
    return loop


def _or_none(function: Compilable) -> Compilable:
    """Return a function that gives None where the given one fails: a kept result may be damaged, or the disk full."""

    @functools.wraps(function)
    def tolerant(*arguments: Any, **named: Any) -> Any:
        try:
            return function(*arguments, **named)
        except Exception:  # noqa: BLE001 - unpickling and loading a damaged file raises anything
            return None

    return tolerant

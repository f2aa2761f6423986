# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How the model's inner loops are compiled, and where the compiled code is kept.

Compiling takes seconds, so the result is kept on disk. By itself numba looks at the place and the time of the file of
the function it was asked for when it decides whether a kept result is still good, while our loops are made of functions
from several files. Therefore the folder for the results is named by a checksum of all files that hold what is
compiled: a change to any of them starts an empty folder, copies of the package share one, and folders unused
for a month are removed. Where nothing can be kept (a full disk, a home that is read-only or none at all)
or a kept result is damaged, the code is compiled each time.
"""

import contextlib
import fcntl
import hashlib
import os
import re
import shutil
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, BinaryIO

# To colour its messages, numba would replace the process's standard streams where colorama is installed.
os.environ.setdefault("NUMBA_DISABLE_ERROR_MESSAGE_HIGHLIGHTING", "1")
import numba
import numba.core.config
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.ccallback import CFunc
from numba.core.sigutils import normalize_signature
from numba.extending import register_jitable

from cdp_ident.files import write_whole

Compilable = Callable[..., Any]

_PACKAGE = Path(__file__).parents[1]
_COMPILED = ("machine/*.py", "model/**/*.py", "likelihood/sweeps.py")
"""Where what is compiled stands."""
_UNUSED_FOR = 30 * 86400.0
"""A folder that no process has used for so long is removed [s]."""


def _cache_folder() -> str | None:
    """Return the folder for compiled code; None where there is none that is the user's own."""
    digest = hashlib.sha256()
    for path in sorted(path for names in _COMPILED for path in _PACKAGE.glob(names)):
        if path.name != "laws.py":  # which is made of the others
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
# would take Python's objects apart for each, and without counting references to arrays, atomically, at every branch and
# view (so they can allocate none).
_PART = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, "_nrt": False}


def inlined(function: Compilable) -> Compilable:
    """Let a function become a part of each compiled loop that calls it."""
    return register_jitable(forceinline=True, **_PART, **_FLOATING_POINT)(function)


def inlined_with_arrays(function: Compilable) -> Compilable:
    """Let a function that makes arrays become a part of each compiled loop that calls it."""
    return register_jitable(forceinline=True, **_FLOATING_POINT)(function)


def part(function: Compilable) -> Compilable:
    """Let compiled loops call a function."""
    return register_jitable(**_PART, **_FLOATING_POINT)(function)


def compiled(function: Compilable) -> Compilable:
    """Compile an inner loop; it runs without Python's global lock and is kept on disk."""
    loop = numba.njit(function, nogil=True, **_FLOATING_POINT)
    if _CACHE_FOLDER is not None:
        loop._cache = _Kept(function)  # as numba's own cache=True does
    return loop


_LAWS: list[Any] = []
"""Keeps what addresses point to alive."""


def compiled_law(function: Compilable, signature: Any) -> Any:
    """Compile a function of a signature, so that loops call it by its address; it is kept on disk, too."""
    law = CFunc(function, normalize_signature(signature), {}, dict(_FLOATING_POINT))
    if _CACHE_FOLDER is None:
        law.compile()
        return law
    law._cache = _Kept(function)
    try:
        law.compile()
    finally:
        law._cache.unlock()
    return law


def compiled_at(function: Compilable, signature: Any) -> int:
    """Return the address of a part of loops that is compiled by itself, and called by it."""
    _LAWS.append(compiled_law(function, signature))
    return int(_LAWS[-1].address)


def kept(name: str, make: Callable[[], bytes]) -> bytes:
    """Return what is kept beside compiled code under a name, made where it is not there yet, damaged or cannot be kept.

    In its file a last line follows with the checksum of what is before it.
    """
    if _CACHE_FOLDER is None:
        return make()
    file = Path(_CACHE_FOLDER) / name
    with contextlib.suppress(OSError):
        content, _, checksum = file.read_bytes().rpartition(_BEFORE_CHECKSUM)
        if checksum.decode("ascii", "replace").strip() == hashlib.sha256(content).hexdigest():
            return content
    content = make()
    with contextlib.suppress(OSError):
        write_whole({file: content + _BEFORE_CHECKSUM + f"{hashlib.sha256(content).hexdigest()}\n".encode()})
    return content


_BEFORE_CHECKSUM = b"\n# sha256 "


def is_to_be_kept(loop: Compilable) -> bool:
    """Return whether a compiled loop's code can be kept on disk, and is not there yet."""
    kept = getattr(loop, "_cache", None)
    return isinstance(kept, _Kept) and not any(Path(kept.cache_path).glob(f"{kept._impl.filename_base}.*.nbc"))


class _InFolder:
    """Where numba keeps code: in our folder, whose name stands for the sources wherever they lie.

    Numba's own locators tell places and times of files apart, so that a checkout, its installed copy and one more would
    each compile the same again.
    """

    def __init__(self, function: Compilable, file: str):
        self._py_file = file  # that numba names in warnings
        self._line = function.__code__.co_firstlineno

    @classmethod
    def from_function(cls, function: Compilable, file: str) -> "_InFolder":
        return cls(function, file)

    def get_cache_path(self) -> str:
        return str(_CACHE_FOLDER)

    def ensure_cache_path(self) -> None:
        Path(self.get_cache_path()).mkdir(parents=True, exist_ok=True)

    def get_source_stamp(self) -> str:
        return ""

    def get_disambiguator(self) -> str:
        return str(self._line)


class _Contents(CompileResultCacheImpl):  # type: ignore[misc]  # numba has no types
    _locator_classes = (_InFolder,)


class _Kept(FunctionCache):  # type: ignore[misc]
    """Compiled code on disk; compiled again where what is kept is damaged, and not kept where the disk is full.

    Of several processes that lack the same code one compiles it; the others wait and load what it kept.
    """

    _impl_class = _Contents
    _lock: BinaryIO | None = None

    def load_overload(self, *arguments: Any) -> Any:
        kept = self._loaded(*arguments)
        if kept is None:
            with contextlib.suppress(OSError):  # no file or no lock can be had: each compiles for itself
                self._impl.locator.ensure_cache_path()
                self._lock = (Path(self.cache_path) / f"{self._impl.filename_base}.lock").open("wb")
                fcntl.flock(self._lock, fcntl.LOCK_EX)
            kept = self._loaded(*arguments)
            if kept is not None:
                self.unlock()
        return kept

    def _index_key(self, signature: Any, codegen: Any) -> Any:
        # By itself numba adds the pickle of what a function closes over. That is in our sources, too, which the folder
        # stands for; but its pickle is another one in each program, so that each would compile the same again.
        return signature, codegen.magic_tuple(), self._py_func.__code__.co_code

    def save_overload(self, *arguments: Any) -> None:
        with contextlib.suppress(Exception):
            super().save_overload(*arguments)
        self.unlock()

    def _loaded(self, *arguments: Any) -> Any:
        try:
            return super().load_overload(*arguments)
        except Exception:  # noqa: BLE001 - unpickling and loading a damaged file raises anything
            return None

    def unlock(self) -> None:
        """Let other processes go on, which wait for what this one compiles."""
        if self._lock is not None:
            self._lock.close()
            self._lock = None

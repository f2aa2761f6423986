# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Compiles the reference's inner loops with numba, in strict floating point, once, and keeps the result on disk.

numba looks only at the file of the function it was asked for when it decides whether a kept result is still good,
while these loops call functions of several files. So the folder is named after the contents of all of them.
"""

import fcntl
import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any, BinaryIO

import numba
import numba.core.config
from numba.core.caching import FunctionCache

Compilable = Callable[..., Any]

_HERE = Path(__file__).parent


def _folder() -> str:
    digest = hashlib.sha256()
    for path in sorted(_HERE.glob("*.py")):
        source = path.read_bytes()
        if b"reference.compilation" in source or path == Path(__file__):
            digest.update(source)
    return str(_HERE / "__pycache__" / digest.hexdigest()[:16])


_FOLDER = _folder()


class _Kept(FunctionCache):  # type: ignore[misc]  # numba has no types
    """Where numba keeps a function's code: of processes that lack the same one compiles it, and the others wait."""

    _lock: BinaryIO

    def load_overload(self, signature: Any, context: Any) -> Any:
        found = super().load_overload(signature, context)
        if found is None:
            self._impl.locator.ensure_cache_path()
            self._lock = (Path(self.cache_path) / f"{self._py_func.__qualname__}.lock").open("wb")
            fcntl.flock(self._lock, fcntl.LOCK_EX)
            found = super().load_overload(signature, context)
            if found is not None:
                self._lock.close()
        return found

    def save_overload(self, signature: Any, result: Any) -> None:
        super().save_overload(signature, result)
        self._lock.close()


def compiled(function: Compilable) -> Compilable:
    """Compile a function for compiled callers and for Python."""
    configured = numba.core.config.CACHE_DIR
    numba.core.config.CACHE_DIR = _FOLDER
    try:
        loop = numba.njit(function, error_model="numpy")
        loop._cache = _Kept(function)
        return loop
    finally:
        numba.core.config.CACHE_DIR = configured

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Compiles the reference's inner loops with numba, in strict floating point, and keeps the result on disk.

numba looks only at the file of the function it was asked for when it decides whether a kept result is still good,
while these loops call functions of several files. So the folder is named after the contents of all of them.
"""

import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
import numba.core.config

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


def compiled(function: Compilable) -> Compilable:
    """Compile a function for compiled callers and for Python."""
    configured = numba.core.config.CACHE_DIR
    numba.core.config.CACHE_DIR = _FOLDER
    try:
        return numba.njit(function, cache=True, error_model="numpy")
    finally:
        numba.core.config.CACHE_DIR = configured

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How the model's inner loops are compiled, and where the compiled code is kept.

Compiling takes seconds, so the result is kept on disk. By itself numba looks at the place and the time of the file of
the function it was asked for, and at what that closes over, when it decides whether a kept result is still good, while
our loops are made of functions from several files. Therefore the folder for the results is named by a checksum of all
files that hold what is compiled: a change to any of them starts an empty folder, copies of the package share one, and
folders unused for a month are removed. Where nothing can be kept (a full disk, a home that is read-only or none at all)
or a kept result is damaged, the code is compiled each time.

Some of it is called by its address, and compiled by itself: laws, of which loops know nothing when they are compiled,
and the larger parts of loops, which the compiler would otherwise go through again and again with all that calls them.
"""

import contextlib
import fcntl
import functools
import hashlib
import os
import pickle
import re
import shutil
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, BinaryIO

# To colour its messages, numba would replace the process's standard streams where colorama is installed.
os.environ.setdefault("NUMBA_DISABLE_ERROR_MESSAGE_HIGHLIGHTING", "1")
import llvmlite
import llvmlite.binding as llvm
import numba
import numba.core.config
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.caching import NullCache
from numba.core.ccallback import CFunc
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps
from numba.core.sigutils import normalize_signature
from numba.extending import intrinsic, register_jitable

from cdp_ident.files import write_whole

Compilable = Callable[..., Any]

_PACKAGE = Path(__file__).parents[1]
_COMPILED = ("machine/*.py", "model/*.py", "model/formulas/*.py", "model/effects/curves.py", "likelihood/sweeps.py")
"""Where what is compiled stands; laws, which loops know nothing of, are kept by their formulas (`Addresses`)."""
_UNUSED_FOR = 30 * 86400.0
"""A folder that no process has used for so long is removed [s]."""


def _cache_folder() -> str | None:
    """Return the folder for compiled code; None where there is none that is the user's own."""
    digest = hashlib.sha256()
    for path in sorted(path for names in _COMPILED for path in _PACKAGE.glob(names)):
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


_ALIVE: list[Any] = []
"""What has machine code: it lives as long as the process, as somebody may still have the address of a function."""


def compiled_at(function: Compilable, signature: Any) -> int:
    """Return the address of a function that is compiled by itself, for loops to call; it is kept on disk, too."""
    code = CFunc(function, normalize_signature(signature), {}, dict(_FLOATING_POINT))
    if _CACHE_FOLDER is not None:
        code._cache = _Kept(function)
    code.compile()
    _ALIVE.append(code)
    return int(code.address)


class Addresses:
    """The functions of a module of LLVM's language, as machine code."""

    def __init__(self, stands_for: str, make: Callable[[], ir.Module]) -> None:
        """Compile a module, or load what was kept of it; a text stands for what is in it, beside our sources."""
        target = _target()
        made_for = f"{stands_for}{llvmlite.__version__}{target.triple}{llvm.get_host_cpu_name()}{_features()}"
        name = f"{hashlib.sha256(made_for.encode()).hexdigest()[:16]}.o"
        code = kept(name, lambda: _object_code(make()))
        self._engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), target)
        self._engine.add_object_file(llvm.ObjectFileRef.from_data(code))
        self._engine.finalize_object()
        _ALIVE.append(self._engine)

    def of(self, name: str) -> int:
        """Return the address of a function."""
        return int(self._engine.get_function_address(name))


@functools.cache
def _target() -> llvm.TargetMachine:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.Target.from_default_triple().create_target_machine(
        cpu=llvm.get_host_cpu_name(), features=_features(), opt=3, jit=True
    )


def _features() -> str:
    return str(llvm.get_host_cpu_features().flatten())


def _object_code(module: ir.Module) -> bytes:
    made = llvm.parse_assembly(str(module))
    made.verify()
    if hasattr(llvm, "create_pass_builder"):
        builder = llvm.create_pass_builder(_target(), llvm.create_pipeline_tuning_options(speed_level=2))
        builder.getModulePassManager().run(made, builder)
    else:  # llvmlite of Ubuntu 24.04
        options = llvm.create_pass_manager_builder()
        options.opt_level = 2
        passes = llvm.create_module_pass_manager()
        options.populate(passes)
        passes.run(made)
    return bytes(_target().emit_object(made))


_BEFORE_CHECKSUM = b"\n# sha256 "


def kept(name: str, make: Callable[[], bytes]) -> bytes:
    """Return what is kept beside compiled code under a name; where it is not, or cannot be, it is made."""
    content = _read(name)
    if content is None:
        content = make()
        _write(name, content)
    return content


def _read(name: str) -> bytes | None:
    """Return what is kept under a name; None where it is not there, or its last line is not the checksum of it."""
    if _CACHE_FOLDER is not None:
        with contextlib.suppress(OSError):
            content, _, checksum = (Path(_CACHE_FOLDER) / name).read_bytes().rpartition(_BEFORE_CHECKSUM)
            if checksum.decode("ascii", "replace").strip() == hashlib.sha256(content).hexdigest():
                return content
    return None


def _write(name: str, content: bytes) -> None:
    if _CACHE_FOLDER is not None:
        checksum = f"{hashlib.sha256(content).hexdigest()}\n".encode()
        with contextlib.suppress(OSError):
            write_whole({Path(_CACHE_FOLDER) / name: content + _BEFORE_CHECKSUM + checksum})


def is_to_be_kept(loop: Compilable) -> bool:
    """Return whether a compiled loop's code can be kept on disk, and is not there yet."""
    kept = getattr(loop, "_cache", None)
    return isinstance(kept, _Kept) and not any(Path(str(_CACHE_FOLDER)).glob(f"{kept.name}-*.nbc"))


class _Kept(NullCache):  # type: ignore[misc]  # numba has no types
    """Where numba keeps a function's code, for each signature: in our folder, which stands for all that it is made of.

    Of several processes that lack the same code one compiles it; the others wait and load what it kept.
    """

    _lock: BinaryIO | None = None

    def __init__(self, function: Compilable) -> None:
        self._code = function.__code__
        self.name = re.sub(r"\W", "_", f"{function.__module__}.{function.__qualname__}")

    def load_overload(self, signature: Any, context: Any) -> Any:
        context.refresh()
        found = self._loaded(signature, context)
        if found is None and _CACHE_FOLDER is not None:
            with contextlib.suppress(OSError):  # no file or no lock can be had: each compiles for itself
                Path(_CACHE_FOLDER).mkdir(parents=True, exist_ok=True)
                self._lock = (Path(_CACHE_FOLDER) / f"{self.name}.lock").open("wb")
                fcntl.flock(self._lock, fcntl.LOCK_EX)
            found = self._loaded(signature, context)
            if found is not None:
                self._unlock()
        return found

    def save_overload(self, signature: Any, result: Any) -> None:
        if not result.library.has_dynamic_globals:
            _write(self._file(signature, result.codegen), dumps(result._reduce()))
        self._unlock()

    def _loaded(self, signature: Any, context: Any) -> Any:
        code = _read(self._file(signature, context.codegen()))
        return None if code is None else CompileResult._rebuild(context, *pickle.loads(code))

    def _file(self, signature: Any, codegen: Any) -> str:
        made_of = (
            str(signature), codegen.magic_tuple(), self._code.co_code, self._code.co_firstlineno,
            numba.__version__, sys.version,
        )  # fmt: skip
        return f"{self.name}-{hashlib.sha256(repr(made_of).encode()).hexdigest()[:16]}.nbc"

    def _unlock(self) -> None:
        """Let other processes go on, which wait for what this one compiles."""
        if self._lock is not None:
            self._lock.close()
            self._lock = None


NUMBERS = types.CPointer(types.float64)
INDICES = types.CPointer(types.int64)
OF_LAW = types.void(NUMBERS, NUMBERS, NUMBERS, NUMBERS)
"""Signature of a compiled law: its inputs, its parameters, the sums of all laws, its rows."""


@intrinsic
def place(typing_context: Any, array: Any, index: Any) -> Any:
    """Return where in memory an element of a contiguous array is, counted along all its dimensions."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        return builder.bitcast(builder.gep(data, [arguments[1]]), context.get_value_type(signature.return_type))

    return types.CPointer(array.dtype)(array, index), generate


@intrinsic
def further(typing_context: Any, pointer: Any, index: Any) -> Any:
    """Return the place so many elements behind another one."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.gep(arguments[0], [arguments[1]])

    return pointer(pointer, index), generate


def _called(returned: types.Type) -> Callable[..., Any]:
    @intrinsic
    def call(typing_context: Any, address: Any, arguments: Any) -> Any:
        """Call what is at an address with some arguments, given in a tuple: places, whole numbers and numbers."""

        def generate(context: Any, builder: Any, signature: Any, given: Any) -> Any:
            values = cgutils.unpack_tuple(builder, given[1])
            result = ir.VoidType() if returned is types.void else context.get_value_type(returned)
            called = ir.FunctionType(result, [value.type for value in values]).as_pointer()
            value = builder.call(builder.inttoptr(given[0], called), values)
            return context.get_dummy_value() if returned is types.void else value

        return returned(address, arguments), generate

    return call


call, call_for_number = _called(types.void), _called(types.float64)

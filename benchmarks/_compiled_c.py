# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""`pendulum.c`, compiled here and now for this very processor."""

import ctypes
import functools
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import numpy.typing as npt

from cdp_ident.model.time_grid import TimeGrid

Array = npt.NDArray[np.float64]

COMPILER = "gcc"
OPTIONS = ("-O3", "-march=native", "-ffast-math", "-fopenmp-simd")
"""Without -ffast-math, which is what the package's own loops are compiled with, gcc leaves the lanes unvectorised."""
LANES = 16
WINDOWS = 8
DIRECTIONS = 11
"""As in the source."""
_SOURCE = Path(__file__).with_name("pendulum.c")


def is_there() -> bool:
    """Return whether there is a C compiler."""
    return shutil.which(COMPILER) is not None


@functools.cache
def _library() -> ctypes.CDLL:
    with tempfile.TemporaryDirectory() as folder:
        compiled, library = Path(folder) / "pendulum.o", Path(folder) / "pendulum.so"
        # Linked with -ffast-math, the library would make the whole process take subnormal numbers for zero.
        for command in (
            [COMPILER, *OPTIONS, "-fPIC", "-c", str(_SOURCE), "-o", str(compiled)],
            [COMPILER, "-shared", str(compiled), "-o", str(library), "-lm"],
        ):
            subprocess.run(command, check=True, capture_output=True, text=True)
        return ctypes.CDLL(str(library))  # it stays loaded when its file is gone


def population(coefficients: Array, start: Array, step: float, measured: Array) -> Array:
    """Return the squared errors (members,) of pendulums side by side in lanes.

    Args:
        coefficients: (members, 7), the members a multiple of `LANES`.
        start: (4,) state at time 0.
        step: of the integrator [s].
        measured: (steps + 1, 2) angles at the steps [rad].
    """
    blocks = len(coefficients) // LANES
    lanes = np.ascontiguousarray(coefficients.reshape(blocks, LANES, -1).transpose(0, 2, 1))
    return _errors("population", lanes, blocks, blocks * LANES, start, step, measured)


def one_by_one(coefficients: Array, start: Array, step: float, measured: Array) -> Array:
    """Return the same, from a plain loop over the members."""
    return _errors("one_by_one", coefficients, len(coefficients), len(coefficients), start, step, measured)


def _errors(
    function: str, coefficients: Array, count: int, members: int, start: Array, step: float, measured: Array
) -> Array:
    errors = np.empty(members)
    getattr(_library(), function)(
        _pointer(coefficients), ctypes.c_int(count), _pointer(start), ctypes.c_int(len(measured) - 1),
        ctypes.c_double(step), _pointer(measured), _pointer(errors),
    )  # fmt: skip
    return errors


def windows(coefficients: Array, starts: Array, grid: TimeGrid) -> tuple[Array, Array]:
    """Return the angles (8, samples, 2) [rad] from eight starts (8, 4), and their derivatives (8, samples, 2, 11)."""
    samples, first_sample = len(grid.place), grid.first_sample
    within = grid.place - np.repeat(np.arange(grid.steps), np.diff(first_sample))
    angles, derivatives = np.empty((WINDOWS, samples, 2)), np.empty((WINDOWS, samples, 2, DIRECTIONS))
    _library().windows(
        _pointer(coefficients), _pointer(starts), ctypes.c_int(grid.steps), ctypes.c_double(grid.step),
        _pointer(first_sample), _pointer(within), ctypes.c_int(samples), _pointer(angles),
        _pointer(derivatives),
    )  # fmt: skip
    return angles, derivatives


def _pointer(array: npt.NDArray[np.float64] | npt.NDArray[np.int64]) -> ctypes.c_void_p:
    assert array.flags.c_contiguous
    return ctypes.c_void_p(array.ctypes.data)

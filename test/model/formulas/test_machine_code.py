# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Machine code of laws computes what their Python code does, and is made anew where what was kept of it is damaged."""

import ctypes
import inspect

import numpy as np
import pytest

from cdp_ident.machine import compilation
from cdp_ident.model.formulas.compiled import _CATALOGUE as LAWS
from cdp_ident.model.formulas.language import INPUTS, PARAMETERS
from cdp_ident.model.formulas.machine_code import laws_in

FUNCTIONS = [
    name for name, function in inspect.getmembers(LAWS, inspect.isfunction)
    if list(inspect.signature(function).parameters)[:2] == ["z", "p"]
]  # fmt: skip
EVERYTHING = """
from math import *

def everything(z, p, sums, rows):
    a = z[0]
    rows[0] = sin(a) + cos(a) + tan(a) + atan(a) + tanh(a) + exp(a) + log(a) + sqrt(a) + abs(-a) + pi
    rows[1] = (1.0 if a > 1.0 else 0.0) - (1.0 if a < 1.0 else 0.0)
    rows[2] = (1.0 if a >= z[0] else 0.0)
    rows[3] = a**2.5 - a/3.0 - (a*a*a)
    rows[4] += -a
    sums[0] += p[0]
"""


def call(address, *arrays):
    numbers = ctypes.POINTER(ctypes.c_double)
    ctypes.CFUNCTYPE(None, *[numbers] * 4)(address)(*(array.ctypes.data_as(numbers) for array in arrays))


def both(function, address, z, p):
    """Return what Python and what machine code leave in sums and rows."""
    found = []
    for run in (function, lambda *arrays: call(address, *arrays)):
        sums, rows = np.full(3 * PARAMETERS, 0.5), np.full(6 * (PARAMETERS + 4), 0.25)
        run(z, p, sums, rows)
        found.append(np.concatenate([sums, rows]))
    return found


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_law_of_the_catalogue_is_the_same_in_machine_code(name):
    rng = np.random.default_rng(1)
    for _ in range(3):
        z, p = rng.normal(size=len(INPUTS)), rng.uniform(0.1, 1.0, 4)
        in_python, in_machine_code = both(getattr(LAWS, name), laws_in(LAWS.text).of(name), z, p)
        np.testing.assert_allclose(in_machine_code, in_python, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("at", [0.3, 1.0, 2.0])
def test_every_word_of_laws_code_is_known(tmp_path, monkeypatch, at):
    monkeypatch.setattr(compilation, "_CACHE_FOLDER", str(tmp_path))
    scope = {}
    exec(EVERYTHING, scope)
    found = both(scope["everything"], laws_in(EVERYTHING).of("everything"), np.array([at]), np.array([2.0]))
    np.testing.assert_allclose(found[1], found[0], rtol=1e-12)


LAW = "def doubled(z, p, sums, rows):\n    rows[0] = 2.0*p[0]\n"


@pytest.mark.parametrize(
    "damage", [lambda code: b"", lambda code: code[:-20] + b"x" * 20, lambda code: code[: len(code) // 2]],
    ids=["empty", "changed", "cut off"],
)  # fmt: skip
def test_damaged_machine_code_is_made_anew(tmp_path, monkeypatch, damage):
    monkeypatch.setattr(compilation, "_CACHE_FOLDER", str(tmp_path))

    def doubled():
        laws, rows = laws_in(LAW), np.zeros(1)
        call(laws.of("doubled"), rows, np.array([3.0]), rows, rows)
        return rows[0]

    assert doubled() == 6.0
    (file,) = tmp_path.glob("*.o")
    whole = file.read_bytes()
    file.write_bytes(damage(whole))
    assert [doubled(), doubled()] == [6.0, 6.0]
    assert file.read_bytes() == whole

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Compiled code is fast, is kept only as long as it is good, and does the same wherever it was compiled."""

import ast
import os
import platform
import re
import runpy
import shutil
import subprocess
import sys
import time
from pathlib import Path

import llvmlite.binding as llvm
import numba
import numpy as np
import pytest

from cdp_ident.machine import compilation
from cdp_ident.model import population, runge_kutta
from cdp_ident.model.rates import sine_and_cosine

PACKAGE = Path(compilation.__file__).parents[1]
reads_assembly = pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="reads assembly of x86_64")


@pytest.fixture(scope="module")
def loop_over_lanes():
    """The loop over lanes, compiled afresh."""
    kernel = population._squared_errors
    real, reals, table, indices = numba.float64, numba.float64[::1], numba.float64[:, ::1], numba.int64[::1]
    options = {name: value for name, value in kernel.targetoptions.items() if name != "nopython"}
    return numba.njit((table, reals, table, real, indices, table, table, reals), **options)(kernel.py_func)


def counted(assembly):
    """Return how many operations are on several numbers, and how many on one; and how many divide several."""
    found = re.findall(r"^\s+v?(div|mul|add|sub|fn?m(?:add|sub)\d*)(pd|sd)\b", assembly, re.MULTILINE)
    widths = [width for _, width in found]
    return widths.count("pd"), widths.count("sd"), found.count(("div", "pd"))


def run(program, *arguments, env=os.environ, **more):
    """Return what a program prints, as another process."""
    command = [sys.executable, "-c", program, *arguments]
    environment = env | {"PYTHONPATH": os.pathsep.join(sys.path)} | {name: str(value) for name, value in more.items()}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True, timeout=300)
    assert done.stderr == ""
    return done.stdout


@reads_assembly
@pytest.mark.parametrize("states", [4, 6])
def test_derivatives_are_moved_several_with_one_instruction(states):
    module = llvm.parse_assembly(str(runge_kutta._module(states)))
    packed, scalar, _ = counted(compilation._target().emit_assembly(module))
    # Two rods' slopes at each of four stages, of all numbers of the state.
    assert packed > 4 * 2 * states
    assert packed > 5 * scalar


@reads_assembly
def test_the_loop_over_lanes_moves_several_members_with_one_instruction(loop_over_lanes):
    (assembly,) = loop_over_lanes.inspect_asm().values()
    packed, scalar, divisions = counted(assembly)
    # Each of the four stages of a step divides once; a scalar copy of the loop remains for arrays that overlap.
    assert divisions >= 4, f"not vectorised: {packed} packed and {scalar} scalar operations"
    assert packed > 0.6 * scalar


def test_the_loop_over_lanes_brings_no_code_that_formats_messages(loop_over_lanes):
    (code,) = loop_over_lanes.inspect_llvm().values()
    assert "unicode" not in code


@pytest.mark.parametrize(
    ("left_behind", "files"),
    [
        (True, ["model/rates.py", "model/effects/curves.py", "machine/compilation.py", "likelihood/sweeps.py"]),
        (False, ["errors.py", "fit/noise.py", "model/effects/friction.py"]),
    ],
)
def test_kept_code_is_left_behind_when_any_compiled_file_changes_and_no_other_one(
    tmp_path, monkeypatch, left_behind, files
):
    copy = tmp_path / "cdp_ident"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(compilation, "_PACKAGE", copy)
    for file in files:
        before = compilation._cache_folder()
        assert compilation._cache_folder() == before
        with (copy / file).open("a") as source:
            source.write("# changed\n")
        assert (compilation._cache_folder() != before) == left_behind, file


def test_kept_code_is_where_the_user_keeps_caches_and_nowhere_without_a_home(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(numba.core.config, "CACHE_DIR", "")
    assert Path(compilation._cache_folder()).parent == tmp_path / "cdp_ident"
    monkeypatch.setenv("XDG_CACHE_HOME", "")
    monkeypatch.setenv("HOME", "/proc/nowhere")
    assert compilation._cache_folder() is None


def test_folders_of_other_versions_that_were_not_used_for_long_go(monkeypatch, tmp_path):
    monkeypatch.setattr(numba.core.config, "CACHE_DIR", str(tmp_path))
    names = {"0123456789abcdef": 40, "fedcba9876543210": 20, "something else": 40}
    for name, days in names.items():
        (tmp_path / name).mkdir()
        os.utime(tmp_path / name, (time.time() - 86400 * days,) * 2)
    own = Path(compilation._cache_folder()).name
    assert {path.name for path in tmp_path.iterdir()} == {own, "fedcba9876543210", "something else"}


def test_copies_of_the_package_share_compiled_code(monkeypatch, tmp_path):
    monkeypatch.setattr(compilation, "_CACHE_FOLDER", str(tmp_path / "kept"))
    hits = []
    for place, age in (("checkout", 100), ("installed", 0)):
        (tmp_path / place).mkdir()
        file = tmp_path / place / "copied.py"
        file.write_text("def doubled(angle):\n    return 2.0 * angle\n")
        os.utime(file, (time.time() - age,) * 2)
        loop = compilation.compiled(runpy.run_path(str(file))["doubled"])
        assert loop(0.5) == 1.0
        hits.append(sum(loop.stats.cache_hits.values()))
    assert hits == [0, 1]


LOOP_THAT_CLOSES_OVER_ANOTHER = """
import sys
from cdp_ident.machine.compilation import compiled

@compiled
def doubled(angle):
    return 2.0 * angle

def loop_of(step, name):
    def loop(angle):
        return step(angle) + 1.0
    loop.__name__ = loop.__qualname__ = name
    return compiled(loop)

first, second = loop_of(doubled, "first"), loop_of(doubled, "second")
if sys.argv[1:]:
    first(0.5)
second(0.5)
print(sum(second.stats.cache_hits.values()))
"""


def test_a_loop_that_closes_over_another_is_found_again_whatever_else_a_program_compiles(tmp_path):
    found = [run(LOOP_THAT_CLOSES_OVER_ANOTHER, *first, NUMBA_CACHE_DIR=tmp_path) for first in ([], ["another first"])]
    assert found == ["0\n", "1\n"]


def test_of_processes_that_lack_the_same_code_one_compiles_it(tmp_path):
    """Several nodes are started at once, and tests on several cores."""
    asked = "from cdp_ident.likelihood.sweeps import filter_rows; from numpy import array, zeros; "
    asked += "filter_rows(zeros((1, 2, 6)), zeros((1, 2)), zeros((1, 2)), zeros((1, 2), dtype=bool), array([0, 1]), "
    asked += "zeros(2), zeros(2), zeros((1, 6, 6)), zeros((1, 6))); print(len(filter_rows.stats.cache_misses))"
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    processes = [
        subprocess.Popen([sys.executable, "-c", asked], env=environment, stdout=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    assert sorted(process.communicate(timeout=300)[0].strip() for process in processes) == ["0", "1"]


MOTION_WITH_EACH_EFFECT = """
import sys
import numpy as np
from cdp_ident.model.acting import ActingEffects
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.formulas.compiled import compiled_law
from cdp_ident.model.motions import simulate
from cdp_ident.model.parameters import NOMINAL, physical_coefficients

if sys.argv[1] == "each law first, backwards":
    for effect in reversed(CATALOGUE):
        compiled_law(effect)
start, times = np.array([1.0, -2.0, 3.0, -4.0]), np.arange(50) / 200.0
for effect in CATALOGUE:
    acting = ActingEffects.of([(effect, [parameter.typical for parameter in effect.parameters])], 0.4)
    print(*simulate(physical_coefficients(NOMINAL), start, times, effects=acting)[-1].tolist())
"""


@pytest.mark.campaign
def test_kept_code_goes_together_with_code_compiled_since(tmp_path):
    def motions(order):
        lines = run(MOTION_WITH_EACH_EFFECT, order, NUMBA_CACHE_DIR=tmp_path).splitlines()
        # The last state of each: a base that moves has more numbers than the others.
        return np.array([[float(number) for number in line.split()[:4]] for line in lines])

    compiled_and_kept = motions("at once")
    assert len(np.unique(compiled_and_kept, axis=0)) > 20  # else there is nothing to mix up
    assert motions("each law first, backwards") == pytest.approx(compiled_and_kept, rel=1e-9)


NO_CACHE = """
import resource, sys
if sys.argv[1:]:
    resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))  # every file is full before its first byte
import ctypes
from cdp_ident.machine.compilation import compiled
from cdp_ident.model.rates import sine_and_cosine
from cdp_ident.model.formulas.compiled import laws_in
numbers = (ctypes.c_double * 1)(3.0)
laws = laws_in("def doubled(z, p, sums, rows):\\n    rows[0] = 2.0*p[0]\\n")
ctypes.CFUNCTYPE(None, *[ctypes.POINTER(ctypes.c_double)] * 4)(laws.of("doubled"))(*[numbers] * 4)
print(compiled(lambda angle: sine_and_cosine(angle)[0])(0.5), numbers[0])
"""


@pytest.mark.parametrize(
    ("arguments", "changed"),
    [([], {"XDG_CACHE_HOME": "/proc/nowhere"}), (["full"], {})],
    ids=["read-only", "full"],
)
def test_without_a_place_for_compiled_code_and_laws_all_is_made_all_the_same_and_nothing_left(
    arguments, changed, tmp_path
):
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    env = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    printed = run(NO_CACHE, *arguments, env=env, **{"XDG_CACHE_HOME": tmp_path, "TMPDIR": temporary} | changed)
    assert printed == f"{np.sin(0.5)} 6.0\n"
    assert not list(temporary.iterdir())


def test_a_damaged_cache_is_compiled_anew(tmp_path, monkeypatch):
    monkeypatch.setattr(compilation, "_CACHE_FOLDER", str(tmp_path))

    def loop():
        return compilation.compiled(lambda angle: sine_and_cosine(angle)[0])

    loop()(0.5)
    kept = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert kept
    for path in kept:
        path.write_bytes(path.read_bytes()[:-20] + b"x" * 20)
    assert loop()(0.5) == pytest.approx(np.sin(0.5))


def test_no_two_compiled_functions_have_the_same_name():
    """The linker knows kept code by its name, and would take one of two for the other."""
    kinds = {"part", "inlined", "inlined_with_arrays", "compiled"}
    names = [
        function.name
        for path in sorted(path for files in compilation._COMPILED for path in PACKAGE.glob(files))
        for function in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(function, ast.FunctionDef)
        and kinds & {getattr(decorator, "id", "") for decorator in function.decorator_list}
    ]
    assert len(names) > 40
    assert [name for name in names if names.count(name) > 1] == []

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Executables are started by name, Ctrl-C ends them in one line from the beginning, and freed memory is kept."""

import os
import platform
import signal
import subprocess
import sys

import pytest

from cdp_ident import start
from cdp_ident.executables import EXECUTABLES

SLOW = """
import sys
from cdp_ident.executables import EXECUTABLES
from cdp_ident.start import start
sys.path.insert(0, sys.argv[1])
EXECUTABLES["slow"] = "slow_to_load"
sys.exit(start("slow"))
"""


def test_there_is_a_console_script_for_each_executable():
    assert all(callable(getattr(start, name)) for name in EXECUTABLES)


@pytest.mark.parametrize(
    ("number", "code", "said"),
    [(signal.SIGINT, 130, "slow: interrupted\n"), (signal.SIGTERM, -signal.SIGTERM, "")],
)
def test_a_signal_while_modules_are_loaded_ends_quietly(tmp_path, number, code, said):
    done = start_slow(
        tmp_path,
        f"import os\ntry:\n    os.kill(os.getpid(), {int(number)})\nexcept BaseException:\n    raise ImportError\n",
    )
    assert (done.returncode, done.stderr) == (code, said)


def start_slow(folder, module):
    """Start an executable whose module has this text."""
    (folder / "slow_to_load.py").write_text(module)
    return subprocess.run(
        [sys.executable, "-c", SLOW, str(folder)],
        check=False,
        capture_output=True,
        text=True,
        env=os.environ,
        timeout=300,
    )


def test_garbage_of_a_running_executable_is_found_though_none_is_looked_for_while_it_is_loaded(tmp_path):
    module = "import gc\nloading = gc.isenabled()\ndef main():\n    print(loading, gc.isenabled())\n    return 0\n"
    done = start_slow(tmp_path, module)
    assert (done.returncode, done.stdout) == (0, "False True\n")


OF_NO_USE = ["scipy.signal", "scipy.stats", "scipy.integrate", "matplotlib", "plotly"]
"""What takes long to load, and is loaded where it is needed if at all."""
OF_A_RIG = {"driver": "scipy", "recorder": "scipy", "emulator": "scipy.linalg"}
"""Where samples wait; numba looks whether there is a scipy."""


def test_nothing_that_takes_long_to_load_is_loaded_before_it_is_needed():
    others = [name for name in EXECUTABLES if name not in OF_A_RIG]
    script = "import sys\n"
    for name in (*OF_A_RIG, *others):
        script += f"import {EXECUTABLES[name]}\n"
        script += f"print('{name}', *(n for n in {[*OF_NO_USE, OF_A_RIG.get(name)]} if n in sys.modules))\n"
    said = subprocess.run([sys.executable, "-c", script], check=True, capture_output=True, text=True).stdout
    assert said.split() == [*OF_A_RIG, *others]


NUMERICS = ("numpy", "numba", "scipy", "rich", "jsonschema", "rclpy")
AT_ONCE = ["identify", "compare", "compare_searches", "import_csv", "linearize", "report", "suggest", "survey"]


def test_the_help_of_what_is_no_node_of_a_rig_waits_for_nothing_that_takes_long_to_load():
    script = "import importlib, sys\n"
    for name in AT_ONCE:
        script += f"try: importlib.import_module('{EXECUTABLES[name]}').main(['--help'])\nexcept SystemExit: pass\n"
        script += f"print('{name}', *(n for n in {NUMERICS} if n in sys.modules), file=sys.stderr)\n"
    said = subprocess.run([sys.executable, "-c", script], check=True, capture_output=True, text=True).stderr
    assert said.split() == AT_ONCE


COUNTED = """
import resource
import threading
import numpy as np
import cdp_ident.start

def touch(rounds):
    for _ in range(rounds):
        arrays = [np.empty(30_000) for _ in range(20)]
        for array in arrays:
            array.fill(1.0)
        del array, arrays

def pages(rounds):
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    touch(rounds)
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before

def count():
    print(pages(1), pages(100))

thread = threading.Thread(target=count)
thread.start()
thread.join()
"""


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="other C libraries cannot be told so")
def test_arrays_get_the_pages_of_those_before_them():
    command = [sys.executable, "-c", COUNTED]
    done = subprocess.run(command, check=True, capture_output=True, text=True, timeout=300)
    first, later = (int(count) for count in done.stdout.split())
    # Twenty arrays of 240 kB have some thousand pages of 4 kB.
    assert first > 500
    assert later < 2 * first

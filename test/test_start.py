"""Executables are started by name, and Ctrl-C ends them in one line from the beginning."""

import os
import signal
import subprocess
import sys

import pytest

from cdp_ident import start
from cdp_ident.executables import EXECUTABLES

INTERRUPTED = """
import os, signal, sys
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
    (tmp_path / "slow_to_load.py").write_text(
        f"import os\ntry:\n    os.kill(os.getpid(), {int(number)})\nexcept BaseException:\n    raise ImportError\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", INTERRUPTED, str(tmp_path)],
        check=False,
        capture_output=True,
        text=True,
        env=os.environ,
        timeout=300,
    )
    assert (done.returncode, done.stderr) == (code, said)

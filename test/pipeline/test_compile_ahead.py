# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The first run compiles the longest loop beside its first steps; later ones load it."""

import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from cdp_ident.machine import compilation
from cdp_ident.machine.compilation import compiled, is_to_be_kept
from cdp_ident.pipeline.compile_ahead import _compile, compile_ahead

BAG = Path(__file__).parents[2] / "bags/swing_wide"

USED = f"""
from pathlib import Path
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.likelihood import sweeps
from cdp_ident.machine import compilation
from cdp_ident.model import linear, population, steps
from cdp_ident.pipeline.identify import identify
from cdp_ident.tracing.trace import trace
from cdp_ident.trial.load import load_trial
found = identify([load_trial(Path({str(BAG)!r}))], [], IdentifyOptions())
trace(found)
loops = (
    steps.compute, steps.fill_each_rate, population._squared_errors, sweeps.backwards, sweeps.forwards,
)
linear.linearize(found.fit.model.coefficients(found.fit.values), (0.0, 0.0))
print(*(sum(loop.stats.cache_misses.values()) for loop in loops), sum(not law.cache_hits for law in compilation._LAWS))
"""


def test_code_is_to_be_kept_until_it_is(monkeypatch, tmp_path):
    monkeypatch.setattr("cdp_ident.machine.compilation._CACHE_FOLDER", str(tmp_path))
    loop = compiled(lambda angle: 2.0 * angle)
    assert is_to_be_kept(loop)
    loop(0.5)
    assert not is_to_be_kept(loop)
    monkeypatch.setattr("cdp_ident.machine.compilation._CACHE_FOLDER", None)
    assert not is_to_be_kept(compiled(lambda angle: 3.0 * angle))


def test_what_is_kept_is_not_compiled_again(monkeypatch):
    monkeypatch.setattr("cdp_ident.pipeline.compile_ahead.is_to_be_kept", lambda loop: False)
    before = threading.active_count()
    compile_ahead()
    assert threading.active_count() == before


def test_a_program_loads_everything_that_another_one_compiled():
    def files():
        assert compilation._CACHE_FOLDER is not None
        return {path.name: path.stat().st_mtime_ns for path in Path(compilation._CACHE_FOLDER).glob("*.nbc")}

    _compile(backwards=False)
    kept = files()
    assert len(kept) > 10
    subprocess.run([sys.executable, "-m", "cdp_ident.pipeline.compile_ahead"], check=True)
    assert files() == kept


@pytest.mark.campaign
def test_what_is_compiled_ahead_is_what_an_identification_uses(tmp_path):
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    subprocess.run([sys.executable, "-m", "cdp_ident.pipeline.compile_ahead"], env=environment, check=True)
    used = subprocess.run([sys.executable, "-c", USED], env=environment, check=True, capture_output=True, text=True)
    assert used.stdout == "0 0 0 0 0 0\n"

"""The first run compiles the longest loop beside its first steps; later ones load it."""

import os
import subprocess
import sys
import threading

import pytest

from cdp_ident.model.compilation import compiled, is_to_be_kept
from cdp_ident.model.compile_ahead import compile_ahead

USED = """
import numpy as np
from cdp_ident.model import trajectory as t
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.effects.constants import effect_constants
from cdp_ident.model.parameters import NOMINAL, physical_coefficients
from cdp_ident.model.time_grid import TimeGrid
from cdp_ident.model.torques import Torques
(effect,) = (e for e in CATALOGUE if e.key == "coulomb_friction.outer")
c, grid = physical_coefficients(NOMINAL), TimeGrid.over(np.arange(5) / 200.0)
torques = Torques.of([(effect, [0.01])], effect_constants(c, 0.4, 0.4), [(0, 0)])
t.trajectory_with_derivatives(c, np.array([1.0, 2.0, 0.0, 0.0]), grid, np.zeros(2 * grid.steps + 1), torques)
t.accelerations_at(c, np.zeros((3, 4)), np.zeros(3), torques)
print(*(sum(loop.stats.cache_misses.values()) for loop in (t._trajectory, t._accelerations_at)))
"""


def test_code_is_to_be_kept_until_it_is(monkeypatch, tmp_path):
    monkeypatch.setattr("cdp_ident.model.compilation._CACHE_FOLDER", str(tmp_path))
    loop = compiled(lambda angle: 2.0 * angle)
    assert is_to_be_kept(loop)
    loop(0.5)
    assert not is_to_be_kept(loop)
    monkeypatch.setattr("cdp_ident.model.compilation._CACHE_FOLDER", None)
    assert not is_to_be_kept(compiled(lambda angle: 3.0 * angle))


def test_what_is_kept_is_not_compiled_again(monkeypatch):
    monkeypatch.setattr("cdp_ident.model.compile_ahead.is_to_be_kept", lambda loop: False)
    before = threading.active_count()
    compile_ahead()
    assert threading.active_count() == before


@pytest.mark.campaign
def test_what_is_compiled_ahead_is_what_a_fit_uses(tmp_path):
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    subprocess.run([sys.executable, "-m", "cdp_ident.model.compile_ahead"], env=environment, check=True)
    used = subprocess.run([sys.executable, "-c", USED], env=environment, check=True, capture_output=True, text=True)
    assert used.stdout == "0 0\n"

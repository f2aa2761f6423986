# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Compile the loops before they are used: when the package is built, or else beside the first steps of a first run.

Compiled code is kept, so that this matters once for each user and version. Run, this module compiles all loops that are
not kept yet; a second process, called with `backwards`, does half of them.
"""

import contextlib
import subprocess
import sys
import threading
from collections.abc import Callable

import numpy as np

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Mechanism
from cdp_ident.likelihood.maxima import most_likely
from cdp_ident.likelihood.swing import Swing
from cdp_ident.likelihood.whole_swing import Recorded
from cdp_ident.machine.compilation import is_to_be_kept
from cdp_ident.machine.parallel import core_count
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.formulas.compiled import compiled_law
from cdp_ident.model.motions import InitialValueProblem, accelerations_at, jacobians_at, motions, simulate
from cdp_ident.model.parameters import GROUPS, NOMINAL, physical_coefficients
from cdp_ident.model.population import Population, Segment
from cdp_ident.model.steps import compute
from cdp_ident.model.time_grid import TimeGrid
from cdp_ident.trial.trial import Trial


def compile_ahead() -> None:
    """Begin to compile what no earlier run has kept; whoever needs it before it is done waits for it."""
    if core_count() > 1 and is_to_be_kept(compute):
        threading.Thread(target=_compile_apart, name="compile ahead", daemon=True).start()


def _compile_apart() -> None:
    # Where that fails, the loop is compiled where it is needed.
    nowhere = subprocess.DEVNULL
    command = [sys.executable, "-m", __spec__.name]
    subprocess.run(command, stdin=nowhere, stdout=nowhere, stderr=nowhere, check=False)


def _compile(backwards: bool) -> None:
    """Use every loop once, the longest first: a first run that goes on meanwhile needs the others before it.

    Backwards, it is for a second core: of two processes that lack the same code one compiles it (`compilation`).
    """
    coefficients, at_rest, times = physical_coefficients(NOMINAL), np.zeros(4), np.array([0.0, 0.01])
    grid = TimeGrid.over(times)
    plain = InitialValueProblem(coefficients, at_rest, grid)
    uses: list[Callable[[], object]] = [
        lambda: motions([plain]),
        lambda: Population([Segment(at_rest, times, np.zeros((2, 2)))]).squared_errors(coefficients[None]),
        lambda: [compiled_law(effect) for effect in CATALOGUE],
        _find_whole_swing,
        lambda: accelerations_at(coefficients, at_rest[None], np.zeros(1)),
        lambda: jacobians_at(coefficients, at_rest[None]),
    ]
    for use in reversed(uses) if backwards else uses:
        use()


def _find_whole_swing() -> None:
    model = MotionModel(Mechanism(NOMINAL["L"], NOMINAL["g"], NOMINAL["L"], 1.0))
    coefficients, times = physical_coefficients(NOMINAL), np.arange(0.0, 0.4, 0.01, dtype=np.float64)
    angles = simulate(coefficients, np.array([1.0, 1.0, 0.0, 0.0]), times)[:, :2]
    swings = Swing.of(Trial("", times, angles), 0, 0.005, 0.1)
    recorded = Recorded(tuple(swings), np.full(2, 1e-3), np.zeros(2), 0.2)
    states = [swing.states(model) for swing in swings]
    with contextlib.suppress(IdentificationError):
        most_likely(model, coefficients[: len(GROUPS)], lambda spacing: (recorded, states))


if __name__ == "__main__":
    _compile(backwards="backwards" in sys.argv[1:])

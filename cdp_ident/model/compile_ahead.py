"""Compile the longest loop in a process of its own, beside the steps that come before its first use.

It matters at the first run alone: from then on the compiled code is kept. The process is this module, run.
"""

import subprocess
import sys
import threading

import numpy as np

from cdp_ident.model import trajectory
from cdp_ident.model.compilation import is_to_be_kept
from cdp_ident.model.parallel import core_count
from cdp_ident.model.parameters import NOMINAL, physical_coefficients
from cdp_ident.model.time_grid import TimeGrid


def compile_ahead() -> None:
    """Begin to compile what no earlier run has kept; whoever needs it before it is done waits for it."""
    if core_count() > 1 and is_to_be_kept(trajectory._trajectory):
        threading.Thread(target=_compile_apart, name="compile ahead", daemon=True).start()


def _compile_apart() -> None:
    # Where that fails, the loop is compiled where it is needed.
    nowhere = subprocess.DEVNULL
    command = [sys.executable, "-m", __spec__.name]
    subprocess.run(command, stdin=nowhere, stdout=nowhere, stderr=nowhere, check=False)


def _compile() -> None:
    coefficients, at_rest, grid = physical_coefficients(NOMINAL), np.zeros(4), TimeGrid.over(np.array([0.0, 0.01]))
    trajectory.trajectory(coefficients, at_rest, grid, np.zeros(2 * grid.steps + 1))
    trajectory.accelerations_at(coefficients, at_rest[None], np.zeros(1))  # of the same parts


if __name__ == "__main__":
    _compile()

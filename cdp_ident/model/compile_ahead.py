"""Compile the loops before they are used: when the package is built, or else beside the first steps of a first run.

Compiled code is kept, so that this matters once for each user and version. Run, this module compiles all loops that are
not kept yet; a second process, called with `backwards`, does half of them.
"""

import subprocess
import sys
import threading
from collections.abc import Callable

import numpy as np

from cdp_ident.model import lane_loop, trajectory
from cdp_ident.model.compilation import is_to_be_kept
from cdp_ident.model.effects.constants import effect_constants
from cdp_ident.model.effects.encoders import ENCODERS
from cdp_ident.model.effects.friction import FRICTION
from cdp_ident.model.effects.play import follow
from cdp_ident.model.effects.readings import added_by
from cdp_ident.model.error_growth import steps_until
from cdp_ident.model.initial_value_problem import InitialValueProblem
from cdp_ident.model.lane_rows import LANES
from cdp_ident.model.linear import linearize
from cdp_ident.model.parallel import core_count
from cdp_ident.model.parameters import NOMINAL, physical_coefficients
from cdp_ident.model.population import Population, Segment
from cdp_ident.model.time_grid import TimeGrid
from cdp_ident.model.torques import Torques
from cdp_ident.model.trajectories import trajectories
from cdp_ident.model.unknowns import ChainRule
from cdp_ident.model.weighted_rows import WeightedRows


def compile_ahead() -> None:
    """Begin to compile what no earlier run has kept; whoever needs it before it is done waits for it."""
    if core_count() > 1 and is_to_be_kept(lane_loop.in_lanes_with_torques):
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
    u = np.zeros(2 * grid.steps + 1)
    constants = effect_constants(coefficients, NOMINAL["L"], NOMINAL["L"])
    torques = Torques.of([(FRICTION[0], [p.typical for p in FRICTION[0].parameters])], constants)
    rubbing = InitialValueProblem(coefficients, at_rest, grid, u, torques)
    plain = InitialValueProblem(coefficients, at_rest, grid, u)
    none, angles = np.empty(0, dtype=np.int64), np.zeros((2, 2))
    first, growth = np.zeros(1, dtype=np.int64), (np.zeros(1, dtype=np.int64), np.ones(4), np.ones(2), 1)
    chain_rule, whitening = ChainRule(first, none, none, np.empty(0)), np.zeros((2, 2, 2))
    uses: list[Callable[[], object]] = [
        lambda: trajectories([rubbing] * LANES),
        lambda: trajectory.trajectory(coefficients, at_rest, grid, u),
        lambda: trajectories([plain] * LANES),
        lambda: trajectory.accelerations_at(coefficients, at_rest[None], np.zeros(1)),
        lambda: Population([Segment(at_rest, times, angles)]).squared_errors(coefficients[None]),
        lambda: steps_until(np.zeros((2, 4)), coefficients, 0.01, *growth),
        lambda: linearize(coefficients, (np.pi, np.pi)),
        lambda: WeightedRows.of(
            angles, angles, chain_rule.by_unknowns(np.zeros((2, 2, 1)), 1), first, whitening, np.array([0, 2]), np.inf
        ),
        lambda: follow(times, 0.0),
        lambda: added_by(ENCODERS[0], [0.0], times, times),
    ]
    for use in reversed(uses) if backwards else uses:
        use()


if __name__ == "__main__":
    _compile(backwards="backwards" in sys.argv[1:])

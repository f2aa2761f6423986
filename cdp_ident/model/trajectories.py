"""The motions of several windows with their derivatives, side by side in lanes where there are enough of them."""

from collections.abc import Sequence
from itertools import accumulate, groupby, pairwise
from typing import Literal

import numpy as np
import numpy.typing as npt

from cdp_ident.model.dynamics import CURVE
from cdp_ident.model.equations import RODS_STATES
from cdp_ident.model.initial_value_problem import EndToEnd, InitialValueProblem
from cdp_ident.model.lane_loop import in_lanes_alone, in_lanes_with_torques
from cdp_ident.model.lane_rows import LANES, MOST_EFFECTS, MOST_PARAMETERS, MOTION, READING, STAGE, TANGENTS
from cdp_ident.model.parameters import COEFFICIENTS
from cdp_ident.model.tangents import STAGES
from cdp_ident.model.torques import Torques
from cdp_ident.model.trajectory import motions, motions_with_derivatives

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]
Derivatives = Literal["all", "start", "none"]
"""Which are wanted: by everything, by the initial state alone, or none."""


_FEWEST, _FEWEST_WITH_TORQUES = 3, 4
"""So many windows are faster side by side than one after the other, for all lanes take their time."""


def trajectories(
    problems: Sequence[InitialValueProblem], derivatives: Derivatives = "all"
) -> list[tuple[Array, Array]]:
    """Return of each problem the states (n, states), and the derivatives of theta1 and theta2 (n, 2, directions).

    They are those of `trajectory_with_derivatives`, but for rounding; by the initial state only where "start" is asked
    for, and without any direction for "none". What else is simulated along does not change a bit of a window, unless
    that is alone or nearly so.
    """
    return [
        (states[first:end], by_directions[first:end])
        for states, by_directions, bounds in _simulated(problems, derivatives)
        for first, end in pairwise(bounds.tolist())
    ]


def end_to_end(
    problems: Sequence[InitialValueProblem], derivatives: Derivatives = "all"
) -> tuple[Array, Array, Indices]:
    """Return what `trajectories` does of problems with as many directions each, their samples end to end.

    The third array (problems + 1,) says where each one's samples begin, and the last one's end.
    """
    parts = _simulated(problems, derivatives)
    if len(parts) == 1:
        return parts[0]
    states, by_directions, bounds = zip(*parts, strict=True)
    ends = np.cumsum(np.concatenate([np.diff(of_part) for of_part in bounds]))
    return np.concatenate(states), np.concatenate(by_directions), np.array([0, *ends])


def _simulated(problems: Sequence[InitialValueProblem], derivatives: Derivatives) -> list[tuple[Array, Array, Indices]]:
    """Return the motions of all problems, of those end to end that are simulated together."""
    parts = []
    for _, neighbours in groupby(problems, key=lambda problem: problem.torques.layout):
        alike = list(neighbours)
        torques = alike[0].torques
        fewest = _FEWEST_WITH_TORQUES if len(torques.table) else _FEWEST
        if len(alike) < fewest or not _fits(torques, derivatives):
            parts.append(_one_by_one(alike, derivatives))
        else:
            parts.append(_side_by_side(alike, derivatives))
    return parts


def _fits(torques: Torques, derivatives: Derivatives) -> bool:
    """Return whether motions with such effects can be side by side: no curves, no states and not too many parameters.

    A curve has so many parameters that all directions of one motion are better side by side.
    """
    parameters = torques.directions if derivatives == "all" else 0
    few = len(torques.table) <= MOST_EFFECTS and parameters <= MOST_PARAMETERS
    return few and torques.states == RODS_STATES and not np.any(torques.table[:, 1] == CURVE)


def _one_by_one(problems: Sequence[InitialValueProblem], derivatives: Derivatives) -> tuple[Array, Array, Indices]:
    """Do the same one after the other, for problems whose effects are laid out alike."""
    if derivatives == "none":
        return motions(problems)
    return motions_with_derivatives(problems, by_start_only=derivatives == "start", of_angles_only=True)


def _side_by_side(problems: Sequence[InitialValueProblem], derivatives: Derivatives) -> tuple[Array, Array, Indices]:
    """Do the same in lanes, the longest ones first: whichever lane comes to an end takes the next one."""
    laid_out, torques = EndToEnd(problems), problems[0].torques
    of_all = RODS_STATES + len(COEFFICIENTS) + torques.directions
    directions = {"all": of_all, "start": RODS_STATES, "none": 0}[derivatives]
    samples = int(laid_out.grids[-1][-1])
    states, by_directions = np.empty((samples, RODS_STATES)), np.empty((samples, 2, directions))
    computed = np.empty(len(problems), dtype=np.int64)
    order = np.argsort([-problem.grid.steps for problem in problems], kind="stable")
    loop = in_lanes_with_torques if len(torques.table) else in_lanes_alone
    loop(
        order, laid_out.coefficients, laid_out.starts(RODS_STATES), laid_out.begins, *laid_out.grids,
        torques.table, np.array([problem.torques.values for problem in problems]),
        torques.lanes if derivatives == "all" else np.full_like(torques.lanes, -1),
        np.array([problem.torques.constants for problem in problems]), np.uint64(LANES), *_rows(), states,
        by_directions, computed,
    )  # fmt: skip
    laid_out.mark_uncomputed(states, by_directions, computed)
    return states, by_directions, laid_out.grids[-1]


def _rows() -> list[Array]:
    """Return the rows of a block, each at the beginning of a line of the processor's cache."""
    lengths = [LANES * rows for rows in (MOTION, STAGES * STAGE, TANGENTS, TANGENTS, READING)]
    room = np.zeros(sum(lengths) + LANES)
    first = -room.ctypes.data // room.itemsize % LANES
    return [room[first + end - length : first + end] for length, end in zip(lengths, accumulate(lengths), strict=True)]

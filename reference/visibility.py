# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How much an effect can be seen: what of it no other parameters and starts of the paper's model imitate."""

import math
from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from reference import sticking
from reference.effects import Effect
from reference.encoders import theta_of
from reference.mechanics import Rig
from reference.plant import Plant
from reference.readings import LEAD, Acting, shown

Array = npt.NDArray[np.float64]

WINDOW = 2.5 / math.sqrt(0.4)
"""Length of the windows over which effects are looked at, over the root of the inner rod's length, which the motion's
own time goes with: 2.5 s for the paper's rig [s / m^0.5]."""
_SAMPLES = 250
"""In a window."""
_FREE = ("l2", "J1", "J2", "c1", "c2")
"""Parameters that move the five numbers of the paper's model in every direction."""
_RELATIVE_STEP = 1e-4
_START_STEP = 1e-5


def visibility(
    values: Mapping[str, float], effects: Sequence[Effect], starts: Sequence[Array], durations: Sequence[float]
) -> tuple[Array, Array]:
    """Return by how much each effect moves theta1 and theta2 beyond imitation, for a unit of its strength [rad].

    Imitation is by the paper's parameters, by the start of each window, and by the other effects. It is the root mean
    square in the middle one of the windows, for some are so chaotic that anything moves them; of what happens once, in
    the window where it is most.

    The first (k,) are what is left where least squares over all windows imitate; strengths are drawn by these. The
    most chaotic windows decide there, and what imitates an effect in these may move all others by more than the effect
    does. So it is visible by no more than what it moves the middle window by where nothing but the windows' starts
    imitates it, which is an imitation, too: the smaller ones are the second (k,).

    Args:
        values: the rig's physical values.
        effects: (k,) that act together.
        starts: (4,) start of each trial.
        durations: of each trial [s].
    """
    tables: list[Array] = []
    owners: list[int] = []
    window = WINDOW * math.sqrt(values["L"])
    for trial, (start, duration) in enumerate(zip(starts, durations, strict=True)):
        begins = window * np.arange(max(1, int(duration / window)))
        path = sticking.path(Plant(Rig(values)), start, np.concatenate([[-LEAD], begins - LEAD + 1e-12]))
        for begin, state in zip(begins, path.states[1:], strict=True):
            times = float(begin) + window * np.arange(_SAMPLES) / _SAMPLES
            block = _beyond_starts(values, [_one(e, trial) for e in effects], state, times)
            owners += [len(tables)] * len(block)
            tables.append(block)
    table, owner = np.concatenate(tables), np.array(owners)
    drawn_by, visible = [], []
    for k, effect in enumerate(effects):
        column, others = table[:, len(_FREE) + k], np.delete(table, len(_FREE) + k, axis=1)
        others = others / np.maximum(np.linalg.norm(others, axis=0), 1e-300)
        left = column - others @ np.linalg.lstsq(others, column, rcond=1e-10)[0]
        of_all, alone = (_in_the_middle_window(moves, owner, effect) for moves in (left, column))
        drawn_by.append(of_all)
        visible.append(min(of_all, alone))
    return np.array(drawn_by), np.array(visible)


def _in_the_middle_window(moves: Array, owner: npt.NDArray[np.int64], effect: Effect) -> float:
    """Return the root mean square of moves (m,) in the middle one of the windows that own them, or in the worst one."""
    powers = np.bincount(owner, moves**2) / np.bincount(owner)
    return float(np.sqrt(np.median(powers) if effect.trial is None else powers.max()))


def _one(effect: Effect, trial: int) -> Effect | None:
    return effect if effect.trial in (None, trial) else None


def _beyond_starts(values: Mapping[str, float], effects: Sequence[Effect | None], state: Array, times: Array) -> Array:
    """Return a window's derivatives (m, 5 + k) by parameters and strengths, without what its start imitates."""

    def angles(by: Mapping[str, float], acting: Sequence[Acting], start: Array) -> Array:
        return theta_of(shown(Plant(Rig(by)), acting, start, times)).ravel()

    plain = angles(values, [], state)
    moved = [(angles(values, [], state + step) - plain) / _START_STEP for step in _START_STEP * np.eye(4)]
    basis, _ = np.linalg.qr(np.stack(moved, axis=1))
    columns = []
    for symbol in _FREE:
        other = {**values, symbol: values[symbol] * (1.0 + _RELATIVE_STEP)}
        columns.append((angles(other, [], state) - plain) / _RELATIVE_STEP)
    for effect in effects:
        if effect is None:
            columns.append(np.zeros_like(plain))
        else:
            columns.append((angles(values, [Acting(effect, effect.small)], state) - plain) / effect.small)
    block = np.stack(columns, axis=1)
    return np.asarray(block - basis @ (basis.T @ block))

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bags of a pendulum that the paper's model explains: nothing is hidden in them, and the encoders only count."""

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from cdp_ident.bag.joint_state import MESSAGE_TYPE, serialize_joint_state
from cdp_ident.bag.writer import BagWriter
from cdp_ident.model.parameters import physical_coefficients
from cdp_ident.rig.emulator.motion import Hold, LetGo, Motion, Wait
from cdp_ident.trial.load import load_trial
from cdp_ident.trial.trial import Trial
from reference.pendulum import TABLE_5, Array

NAMES = ("cart_joint", "inner_joint", "outer_joint")
STARTS = {"swing_wide": (2.2, 2.0), "swing_folded": (2.4, 4.5)}
"""Where the hand lets go: theta1, theta2 [rad] from upright. The rods swing wide but not over the top."""
_RATE = 200
_COUNT = math.tau / 8000
_FIRST_STAMP = 1_717_156_800_000_000_000


def write_clean_bags(folder: Path, values: Mapping[str, float] = TABLE_5, swing: float = 14.0) -> None:
    """Write the bags: each hangs for 1 s, is led up and held for 3 s, and swings freely for so long [s]."""
    for name, start in STARTS.items():
        write_clean_bag(folder / name, start, values, swing)


def write_clean_bag(
    folder: Path,
    start: tuple[float, float],
    values: Mapping[str, float] = TABLE_5,
    swing: float = 14.0,
    first_stamp: int = _FIRST_STAMP,
    custom_data: Mapping[str, str] | None = None,
) -> None:
    """Write one bag whose pendulum is let go at `start`, theta1 and theta2 [rad]; its first stamp is in ns."""
    with BagWriter(folder) as writer:
        for i, measured in enumerate(_positions(start, values, swing)):
            stamp = first_stamp + i * 1_000_000_000 // _RATE
            writer.write("/joint_states", MESSAGE_TYPE, stamp, serialize_joint_state(NAMES, measured, stamp))
        writer.close(custom_data or {})


def clean_trials(folder: Path, swing: float = 14.0) -> tuple[Trial, ...]:
    """Write the bags and return their trials, in which they swing freely for so long [s]."""
    write_clean_bags(folder, swing=swing)
    return tuple(load_trial(folder / name) for name in STARTS)


def _positions(start: tuple[float, float], values: Mapping[str, float], swing: float) -> Array:
    script = (Wait(1.0), Hold(*start, within=1.5), Wait(1.5), LetGo(), Wait(swing))
    cart, theta1, theta2 = (
        Motion(physical_coefficients(values), script, 1 / _RATE).advance(round((4.0 + swing) * _RATE)).T[:3]
    )
    joints = np.column_stack([theta1, theta2 - theta1])
    return np.column_stack([cart, np.round(joints / _COUNT) * _COUNT])

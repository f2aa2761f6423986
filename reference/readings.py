# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From a plant and the effects in it to what its encoders would show without noise."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from reference import rigid_bodies, sticking
from reference.effects import Effect
from reference.encoders import Turned, joint_angles
from reference.plant import Path, Plant

Array = npt.NDArray[np.float64]
Engine = Callable[[Plant, Array, Array], Path]

ENGINES: dict[str, Engine] = {"equations": sticking.path, "mujoco": rigid_bodies.path}
LEAD = 0.05
"""A motion begins so long before the first sample [s], for encoders that are late."""


@dataclass(frozen=True)
class Acting:
    """An effect of a certain strength."""

    effect: Effect
    strength: float


def shown(
    plant: Plant,
    acting: Sequence[Acting],
    start: Array,
    times: Array,
    engine: Engine = sticking.path,
) -> Array:
    """Return the joints' angles (n, 2) that the encoders show, from hanging and from straight [rad].

    Args:
        plant: the rig without the effects.
        acting: what acts, and how strongly.
        start: (4,) state `LEAD` before the first sample.
        times: (n,) of the samples in the trial [s].
        engine: what moves it.
    """
    delay = 0.0
    for effect, strength in ((a.effect, a.strength) for a in acting):
        if effect.in_plant is not None:
            plant = effect.in_plant(plant, strength)
        if effect.late:
            delay = strength
    moments = np.unique(np.concatenate([[times[0] - LEAD], times, times - delay]))
    whole = engine(plant, start, moments)
    path, late = (_at(whole, np.searchsorted(moments, t)) for t in (times, times - delay))
    joints = np.stack([joint_angles(path)[:, 0], joint_angles(late)[:, 1]], axis=1)
    turned = Turned(plant.rig.values, path, joints)
    readings = (a.effect.in_reading(a.strength) for a in acting if a.effect.in_reading is not None)
    return joints + sum((reading(turned) for reading in readings), np.zeros_like(joints))


def _at(path: Path, places: npt.NDArray[np.intp]) -> Path:
    return Path(path.times[places], path.states[places], path.accelerations[places], path.cart[places])

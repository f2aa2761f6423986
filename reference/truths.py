# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Hidden truths: trials of rigs with effects in them that nobody is told of, and the answers.

All of it follows from the kind and the seed: the rig and its size, starts, rate, encoders, noise, and how strong the
effects are. The same truth can be moved by the equations or by a rigid-body engine.
"""

import math
import zlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from reference.effects import Effect, Occasion, draw
from reference.encoders import theta_of
from reference.mechanics import Rig
from reference.plant import Plant
from reference.readings import ENGINES, Acting, shown
from reference.settings import Setting, draw_setting
from reference.visibility import visibility

Array = npt.NDArray[np.float64]

FIT_TRIALS = 2
"""Of the three trials, the first two are to be fitted; the last one is held out."""
VISIBLE = (0.4, 40.0)
"""What effects move the angles by beyond imitation, over the noise."""

_SAME = (
    frozenset({("gravity_tilt", "base"), ("encoder_offset", "inner")}),
    frozenset({("quadratic_friction", "inner"), ("air_drag", "inner")}),
    *(frozenset({("eddy_brake", joint), ("varying_viscosity", joint)}) for joint in ("inner", "outer")),
    frozenset({("bob_drag", "outer"), ("air_drag", "outer")}),
    frozenset({("heavy_cart", "base"), ("cart_on_spring", "base"), ("pivot_compliance", "base")}),
)
"""Names that are right for one another: the same motion, or the same cause described in more detail."""
_BEYOND = {
    "partial_rub": "unknown_torque",
    "rotor_inertia": "geared_rotor",
    "presliding_friction": "coulomb_friction",
    "drifting_friction": "coulomb_friction",
    "encoder_filter": "time_offset",
}
"""What the package has no name for, or one that may be missed, and what would be a right name all the same, if any."""


@dataclass(frozen=True)
class Measured:
    """A trial as a rig measured it."""

    name: str
    time: Array
    """(n,) since the first sample [s]."""
    theta: Array
    """(n, 2) theta1, theta2 [rad]."""


@dataclass(frozen=True)
class Hidden:
    """An effect as it is in one truth."""

    effect: Effect
    strength: float
    """In the effect's unit."""
    visible: float
    """What the paper's model and the truth's other effects cannot imitate of it, over the noise; see `visibility`."""

    @property
    def known(self) -> bool:
        """Whether the package has a name for it."""
        return self.effect.name not in _BEYOND

    @property
    def right(self) -> frozenset[tuple[str, str]]:
        """Names and joints, each of which is a right answer."""
        own = (self.effect.name, str(self.effect.joint))
        if not self.known:
            # An inner encoder that is late is an outer one that is early.
            joint = "outer" if own[0] == "encoder_filter" else own[1]
            return frozenset({own, (_BEYOND[own[0]], joint)})
        return next((same for same in _SAME if own in same), frozenset({own}))


@dataclass(frozen=True)
class Truth:
    """Trials, what a user would know beforehand, and what is to be found out."""

    kind: str
    seed: int
    engine: str
    trials: tuple[Measured, ...]
    """Three, of which the last is to be held out."""
    setting: Setting
    hidden: tuple[Hidden, ...]
    floor: float
    """Root mean square of the last trial's errors of both angles [rad]."""


def truth(
    kind: str, seed: int, engine: str = "equations", visible: float | None = None, setting: Setting | None = None
) -> Truth:
    """Return a hidden truth.

    Args:
        kind: see `kinds`.
        seed: of everything that is random.
        engine: what moves it: "equations" or "mujoco".
        visible: what each effect moves the angles by, over the noise; drawn where not given.
        setting: rig, encoders and starts; drawn where not given.

    Raises:
        ValueError: the engine has no element for something of this kind.
    """
    rng = np.random.default_rng([seed, zlib.crc32(kind.encode())])
    setting = setting or draw_setting(rng)
    occasion = Occasion(setting.values, [float(moments[-1]) for moments in setting.times[:FIT_TRIALS]], rng)
    present = [] if kind == "none" else [draw(part, occasion) for part in kind.split("+")]
    hidden = _of_strengths(setting, present, visible, rng)

    trials: list[Measured] = []
    floor = 0.0
    for index, (start, moments) in enumerate(zip(setting.starts, setting.times, strict=True)):
        acting = [Acting(h.effect, h.strength) for h in hidden if h.effect.trial in (None, index)]
        joints = shown(Plant(Rig(setting.values)), acting, start, moments, ENGINES[engine])
        theta = theta_of(setting.counter.count(joints, rng))
        floor = float(np.sqrt(np.mean((theta - theta_of(joints)) ** 2)))
        trials.append(Measured(f"{kind} {seed}.{index}", moments, theta))
    return Truth(kind, seed, engine, tuple(trials), setting, hidden, floor)


def _of_strengths(
    setting: Setting, present: Sequence[Effect], visible: float | None, rng: np.random.Generator
) -> tuple[Hidden, ...]:
    """Return the effects with their strengths: by what they are to move, or so that they stop a joint."""
    if not present:
        return ()
    # theta2 is the sum of both encoders' angles.
    noise = setting.counter.error * math.sqrt(1.5)
    durations = [float(moments[-1]) for moments in setting.times[:FIT_TRIALS]]
    units, visible_units = visibility(setting.values, present, setting.starts[:FIT_TRIALS], durations)
    hidden = []
    for effect, moved, seen in zip(present, units, visible_units, strict=True):
        drawn = float(np.exp(rng.uniform(*np.log(VISIBLE))))
        strength = min((drawn if visible is None else visible) * noise / moved, effect.largest)
        if effect.stopping is not None:
            strength = effect.stopping
        if effect.counted:
            strength = setting.counter.step * max(1, round(strength / setting.counter.step))
        direction = rng.choice([-1.0, 1.0]) if effect.signed else 1.0
        hidden.append(Hidden(effect, float(direction * strength), float(strength * seen / noise)))
    return tuple(hidden)

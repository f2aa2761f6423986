# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How large dry friction is.

It is set-valued: a joint that slips has a torque of this size against its motion; one that stands still has any torque
up to the static one, which is this size at rest.
"""

import math
from dataclasses import astuple, dataclass

import numpy as np
import numpy.typing as npt

from reference.compilation import compiled

Array = npt.NDArray[np.float64]

TORQUE, EXTRA, SPEED, LEVER, RUB, RUB_MIDDLE, RUB_HALF, RUB_EDGE, DRIFT = range(9)


@dataclass(frozen=True)
class DryFriction:
    """What determines the size of one joint's dry friction: the sum of the parts below."""

    torque: float = 0.0
    """Coulomb friction [N m]."""
    extra: float = 0.0
    """What is added at rest, and falls off as exp(-(rate / speed)^2) (Stribeck) [N m]."""
    speed: float = 1.0
    """Stribeck's speed [rad/s]."""
    lever: float = 0.0
    """Torque over the force that the bearing carries [m]."""
    rub: float = 0.0
    """What is added over a part of the turn [N m]."""
    rub_middle: float = 0.0
    """Middle of that part, as the joint's angle from hanging or from straight [rad]."""
    rub_half: float = 0.3
    """Half its width [rad]."""
    rub_edge: float = 0.05
    """Over how much of an angle it sets in (the width of a logistic curve) [rad]."""

    drift: float = 0.0
    """By how much Coulomb friction grows along a trial [N m/s]."""

    @property
    def any(self) -> bool:
        """Whether there is friction at all."""
        return self.torque > 0.0 or self.extra > 0.0 or self.lever > 0.0 or self.rub > 0.0

    @property
    def array(self) -> Array:
        """(9,) all of it, as compiled code takes it."""
        return np.array(astuple(self), dtype=float)


NO_FRICTION = DryFriction()


@compiled
def wrapped(angle: float) -> float:
    """Return an angle in -pi to pi [rad]."""
    return angle - 2.0 * math.pi * math.floor(angle / (2.0 * math.pi) + 0.5)


@compiled
def friction_size(friction: Array, time: float, angle: float, rate: float, load: float) -> float:
    """Return the size of a joint's dry friction [N m].

    Args:
        friction: see `DryFriction.array`.
        time: in the trial [s].
        angle: the joint's angle from hanging (inner) or from straight (outer) [rad].
        rate: its rate [rad/s]; 0 gives the static torque.
        load: the force that its bearing carries [N].
    """
    size = friction[TORQUE] + friction[DRIFT] * time + friction[LEVER] * load
    if friction[EXTRA] > 0.0:
        size += friction[EXTRA] * math.exp(-((rate / friction[SPEED]) ** 2))
    if friction[RUB] > 0.0:
        beyond = (abs(wrapped(angle - friction[RUB_MIDDLE])) - friction[RUB_HALF]) / friction[RUB_EDGE]
        size += friction[RUB] / (1.0 + math.exp(min(beyond, 500.0)))
    return size

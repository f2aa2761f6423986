# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is to be identified: a rig, what acts in it beyond the paper's model, and how it moves."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from reference.dry_friction import NO_FRICTION, DryFriction
from reference.mechanics import Rig
from reference.torques import Torque

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Plant:
    """A rig and what acts in its joints."""

    rig: Rig
    inner: DryFriction = NO_FRICTION
    """Dry friction of the inner joint."""
    outer: DryFriction = NO_FRICTION
    torques: tuple[Torque, ...] = ()
    """What else acts."""


@dataclass(frozen=True)
class Path:
    """A motion at given times."""

    times: Array
    """(n,) [s]"""
    states: Array
    """(n, 4) theta1, theta2 [rad], omega1, omega2 [rad/s]."""
    accelerations: Array
    """(n, 2) alpha1, alpha2 [rad/s^2]."""
    cart: Array
    """(n,) the cart's position [m]."""
    event_times: Array | None = None
    """(m,) when a joint stopped, broke away or turned round [s]; None where that was not looked at."""
    event_modes: npt.NDArray[np.int64] | None = None
    """(m, 2) what the inner and the outer joint do from then on: 0 stuck, 1 or -1 slipping that way."""

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A model's most likely values given whole swings, and what belongs to them.

States are estimated at nodes along each swing, and each node's follows from the one before: by the model, and by
impulses of *unknown torques* in both joints. Their standard deviations are estimated, joint by joint, as those of the
encoders' noise are. Where the model holds they vanish, and a swing is one motion, chaotic as it may be. Where it does
not, they say what it lacks, and the values are as uncertain as that makes them.

The evidence of a model is the likelihood with values and states integrated out over what is known of them beforehand
(`prior`); differences of its logarithm are odds between models.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from cdp_ident.arrays import Array, Mask
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.likelihood.noise import Noise
from cdp_ident.likelihood.prior import Known, known_before
from cdp_ident.likelihood.swing import Linearised, Swing

_LEAST_TORQUE = 1e-5
"""Unknown torques are at least so large that within a time unit their impulses change an angle by this share of the
encoders' noise: far less than matters, and enough to forget what rounding makes of a chaotic motion."""
LARGER = 1.2
"""Encoders' noise that is so many times what readings that follow one another show is not noise alone."""


def large_torque(encoders: Array, unit: float) -> float:
    """Return an unknown torque that hides all that a model says over a time unit, over A22 [1/s^1.5].

    Args:
        encoders: (2,) standard deviation of both encoders' noise [rad].
        unit: the rig's time unit [s].
    """
    return float(encoders.max()) / unit**1.5


@dataclass(frozen=True)
class Recorded:
    """What a rig's encoders showed, and what scales with the rig."""

    swings: tuple[Swing, ...]
    encoders: Array
    """(2,) standard deviation of both encoders' noise, roughly [rad]."""
    steps: Array
    """(2,) of both encoders [rad], 0 where none shows."""
    time_unit: float
    """Of the rig, sqrt(L / g) [s]."""

    @property
    def large_torque(self) -> float:
        """See `large_torque`."""
        return large_torque(self.encoders, self.time_unit)

    @property
    def least_torque(self) -> float:
        """The least that is taken into account, over A22 [1/s^1.5]."""
        return _LEAST_TORQUE * self.large_torque

    @property
    def trials(self) -> list[int]:
        """The numbers of the trials of which swings are."""
        return sorted({swing.trial for swing in self.swings})

    @property
    def nodes(self) -> int:
        """How many there are."""
        return sum(len(swing.times.begin) for swing in self.swings)


@dataclass(frozen=True)
class WholeSwings:
    """A model's most likely values given whole swings, and what belongs to them."""

    model: MotionModel
    values: Array
    """(unknowns,)"""
    covariance: Array
    """(unknowns, unknowns) of these; infinite where the swings do not determine one."""
    triangle: Array
    """(unknowns, unknowns) whose square is the information on these: the square root of the covariance's inverse."""
    recorded: Recorded
    noise: Noise
    """Of encoders and unknown torques, none of which is zero."""
    is_missing: Mask
    """(2,) whether each unknown torque is there: without it the swings are far less likely. They are those of the inner
    joint, or of a base that moves (`Noise.of_base`), and of the outer joint."""
    freedom: Array
    """(2,) how many of their impulses the readings decide."""
    impulses: tuple[Array, ...]
    """(nodes, 2, 2) of each swing: the impulses of unknown torques in both joints after each node, over A22 [1/s], and
    their standard deviations."""
    states: tuple[Array, ...]
    """(nodes, states) of each swing, and where its clock is uncertain by how much that is fast."""
    linear: tuple[Linearised, ...]
    """Each swing near these."""
    misfit: float
    """Minus twice the logarithm of the model's evidence, but for a constant that is the same for all models."""
    steps: int
    converged: bool
    """Whether nothing would change any more."""

    @cached_property
    def known(self) -> Known:
        """What is known of the values beforehand."""
        return known_before(self.model)

    @property
    def leaves_more(self) -> Mask:
        """(2,) whether more than an encoder's noise remains: missing torque, or what noise is larger for."""
        shown, expected = self.noise.encoders, self.recorded.encoders
        if self.noise.absolute:
            shown, expected = self.noise.angles(np.array([True, True])), np.sqrt(np.cumsum(expected**2))
        return np.asarray(self.joints_missing | (shown > LARGER * expected))

    def noise_of_angles(self, shown: Array) -> Array:
        """Return the noise (2,) of theta1 and theta2 [rad], with errors of time and what lasts for less than a node.

        Args:
            shown: (2,) what samples show of it from one to the next [rad].
        """
        swings = self.recorded.swings
        step = float(np.median(np.concatenate([np.diff(swing.time) for swing in swings])))
        lasts = -step / np.log(np.clip(self.noise.kept, 1e-9, 1.0 - 1e-9))
        angles = self.noise.angles(lasts < min(swing.spacing for swing in swings))
        squares = [np.mean(np.cumsum(linear.rates, axis=1) ** 2, axis=0) for linear in self.linear]
        late = self.noise.time * np.sqrt(np.max(squares, axis=0))
        return np.asarray(np.maximum(shown, np.hypot(late, angles)))

    def noise_level(self, shown: Array) -> float:
        """Return the root mean square of the noise of both angles [rad]; see `noise_of_angles`."""
        return float(np.sqrt(np.mean(self.noise_of_angles(shown) ** 2)))

    @property
    def base_moves(self) -> bool:
        """Whether the base moves."""
        return self.noise.of_base and bool(self.is_missing[0])

    @property
    def joints_missing(self) -> Mask:
        """(2,) whether a torque is missing in each joint; a base that moves brings torques to both."""
        return np.asarray(self.is_missing | self.base_moves)

    @property
    def torque(self) -> Array:
        """(2,) standard deviation of the torques that are missing, over A22 [1/s^1.5]; zero where none is."""
        return np.asarray(np.where(self.is_missing, self.noise.torque_with_tails, 0.0))

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The torque in each joint that a model lacks, along the motion: the smoothed unknown torque of the likelihood."""

from dataclasses import dataclass

import numpy as np

from cdp_ident.arrays import Array, Indices
from cdp_ident.likelihood.whole_swing import WholeSwings


@dataclass(frozen=True)
class JointMotion:
    """The motion of the joints along which torques are told; columns are the two `JOINTS`."""

    trial: Indices
    """(n,) which trial a value is of."""
    time: Array
    """(n,) its time in the trial [s]."""
    angle: Array
    """(n, 2) angle of each joint: the inner one from hanging, the outer one relative to the inner rod [rad]."""
    speed: Array
    """(n, 2) speed of each joint [rad/s]."""

    def over(self, what: str, joint: int) -> Array:
        """Return what a torque may depend on (n,): a joint's `speed` [rad/s], or `angle` within half a turn [rad]."""
        return self.speed[:, joint] if what == "speed" else (self.angle[:, joint] + np.pi) % (2.0 * np.pi) - np.pi


@dataclass(frozen=True)
class MissingTorque(JointMotion):
    """The missing torque in each joint along the motion."""

    torque: Array
    """(n, 2) over A22 [rad/s^2]."""
    std: Array
    """(n, 2) its standard deviation [rad/s^2]."""

    @classmethod
    def of(cls, found: WholeSwings) -> "MissingTorque":
        """Return the torque that a model lacks; zero in a joint where none is missing."""
        parts = []
        for swing, states, impulses in zip(found.recorded.swings, found.states, found.impulses, strict=True):
            torque, std = np.where(found.is_missing, impulses[:-1] / swing.spacing, 0.0).transpose(1, 0, 2)
            at = states[1:]  # what a torque did since the node before has its effect at once, at this one
            if found.base_moves:
                by_base = _torques_of_base(found, at)
                torque = by_base * torque[:, :1] + [0.0, 1.0] * torque
                std = np.hypot(by_base * std[:, :1], [0.0, 1.0] * std)
            parts.append(
                (
                    np.full(len(at), swing.trial),
                    swing.begin + swing.node_times[1:],
                    np.stack([at[:, 0] - np.pi, at[:, 1] - at[:, 0]], axis=1),
                    np.stack([at[:, 2], at[:, 3] - at[:, 2]], axis=1),
                    torque,
                    std,
                )
            )
        return cls(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _torques_of_base(found: WholeSwings, states: Array) -> Array:
    """Return the torques (n, 2) in both joints, over A22, by which a unit of a base's acceleration, over L, acts."""
    A23, _, a1, _, _, L, _ = found.model.coefficients(found.values)
    inner, outer = -a1 * L * np.cos(states[:, 0]), -A23 * np.cos(states[:, 1])
    return np.stack([inner + outer, outer], axis=1)

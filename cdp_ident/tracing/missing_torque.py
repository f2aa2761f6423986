# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Torques in each joint along the motion: what a model lacks, smoothed by the likelihood, and those of its effects."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cdp_ident.arrays import Array, Indices
from cdp_ident.likelihood.whole_swing import WholeSwings
from cdp_ident.model.layout import RODS_STATES
from cdp_ident.model.motions import accelerations_at


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


def torques_of_effects(found: WholeSwings) -> Array:
    """Return the torque (effects, n, 2) over A22 that each effect brings the joints; zero for effects of encoders."""
    torques = np.zeros((len(found.model.effects), sum(len(of) - 1 for of in found.states), 2))
    for index, active in enumerate(found.model.effects):
        if active.effect.moves:
            torques[index] = np.concatenate(list(_of_effect(found, index)))
    return torques


def _of_effect(found: WholeSwings, index: int) -> Iterator[Array]:
    """Yield for each swing the torque (nodes - 1, 2) over A22 that an effect brings the joints (inverse dynamics)."""
    others, remain = found.model.without_effect(index)
    bounds = np.cumsum([RODS_STATES, *(active.effect.states for active in found.model.effects)]).tolist()
    own = range(bounds[index], bounds[index + 1])
    for swing, of in zip(found.recorded.swings, found.states, strict=True):
        states, times, u = of[1:, : found.model.states], swing.begin + swing.node_times[1:], swing.u[1:]
        without = (others, found.values[remain], np.delete(states, own, axis=1))
        accelerations = []
        for model, values, of_model in (without, (found.model, found.values, states)):
            weighted = model.with_weights(values, swing.weights)
            coefficients = model.coefficients(weighted.values)
            acting = model.acting(weighted.values, swing.trial, weighted.carried)
            accelerations.append(accelerations_at(coefficients, np.ascontiguousarray(of_model), u, acting, times))
        A23, A33 = coefficients[:2]
        more, coupling = accelerations[1] - accelerations[0], A23 * np.cos(states[:, 0] - states[:, 1])
        on_inner = more[:, 0] + coupling * more[:, 1]
        on_outer = coupling * more[:, 0] + A33 * more[:, 1]
        # The outer joint's torque acts on the outer rod and, reversed, on the inner one.
        yield weighted.share * np.stack([on_inner + on_outer, on_outer], axis=1)

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A trial that could be recorded next: the whole swing that it would be, and what that would say of the values."""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cdp_ident.design.knowledge import NEW, Knowledge
from cdp_ident.errors import IdentificationError
from cdp_ident.likelihood.reduction import reduced
from cdp_ident.likelihood.swing import Swing
from cdp_ident.model.motions import InitialValueProblem, motions
from cdp_ident.model.time_grid import TimeGrid
from cdp_ident.model.weights import Weight
from cdp_ident.trial.trial import Trial

Array = npt.NDArray[np.float64]

_TURN = 2.0 * np.pi


@dataclass(frozen=True)
class CandidateTrial:
    """Both rods are held at rest, and let go."""

    theta1: float
    """Of the inner rod, from upright [rad]."""
    theta2: float
    """Of the outer rod, from upright [rad]."""
    weights: tuple[Weight, ...] = ()
    """Clamped to the rods; what they may be wrong by is among the unknowns of the knowledge that judges the trial."""

    @property
    def mirrored(self) -> "CandidateTrial":
        """The same on the other side of hanging."""
        return replace(self, theta1=_TURN - self.theta1, theta2=_TURN - self.theta2)


def swing_of(candidate: CandidateTrial, knowledge: Knowledge) -> tuple[Swing, Array]:
    """Return the swing that a trial would be, were the model true, and the states (nodes, states) at its nodes.

    Args:
        candidate: the trial.
        knowledge: gives the motion, and how the trial is recorded.

    Raises:
        IdentificationError: its motion cannot be computed.
    """
    sampling = knowledge.sampling
    samples = max(int(sampling.duration / sampling.interval), 2)
    time: Array = np.arange(samples, dtype=np.float64) * sampling.interval
    trial = Trial("next", time, _shown(_states(candidate, knowledge, time), sampling.steps), weights=candidate.weights)
    (swing,) = Swing.of(trial, NEW, sampling.step, sampling.spacing)
    return swing, _states(candidate, knowledge, swing.node_times)


def _states(candidate: CandidateTrial, knowledge: Knowledge, time: Array) -> Array:
    """Return the states (n, states) of a trial at times (n,) [s]."""
    model, values = knowledge.model, knowledge.values
    weighted = model.with_weights(values, candidate.weights)
    grid = TimeGrid.over(time, knowledge.sampling.step)
    start = model.initial_state(np.array([candidate.theta1, candidate.theta2, 0.0, 0.0]))
    acting = model.acting(weighted.values, NEW, weighted.carried).without_directions()
    still = np.zeros(2 * grid.steps + 1)
    problem = InitialValueProblem(model.coefficients(weighted.values), start, grid, still, acting)
    states = motions([problem], shown=False).states
    if not np.all(np.isfinite(states)):
        raise IdentificationError("the motion of a trial that is let go there cannot be computed")
    return states


def _shown(states: Array, steps: Array) -> Array:
    """Return the angles (n, 2) in states (n, states) as encoders of steps (2,) show them, from hanging on [rad]."""
    joints = np.column_stack([states[:, 0] - np.pi, states[:, 1] - states[:, 0]])
    counted = np.where(steps > 0.0, steps * np.round(joints / np.where(steps > 0.0, steps, 1.0)), joints)
    return np.asarray(np.pi + np.cumsum(counted, axis=1))


def information_of(candidate: CandidateTrial, knowledge: Knowledge) -> Array:
    """Return rows (k, unknowns) whose products are the information that a trial would hold on the values.

    Its states are eliminated, and what unknown torques could do; the arguments are those of `swing_of`.

    Raises:
        IdentificationError: its motion cannot be computed.
    """
    model, values = knowledge.model, knowledge.values
    swing, states = swing_of(candidate, knowledge)
    linear = swing.linearised(model, values, states)
    nothing = np.zeros((0, len(values) + 1))
    return reduced(model, nothing, [swing], [linear], [states], knowledge.noise).of_values[:, :-1]

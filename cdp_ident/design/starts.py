# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Starts that a hand can lead both rods to: the swing that each would be, what it would say, and which is the best."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.design.knowledge import NEW, Knowledge
from cdp_ident.errors import IdentificationError
from cdp_ident.likelihood.reduction import reduced
from cdp_ident.likelihood.swing import Swing
from cdp_ident.machine.parallel import parallel_map
from cdp_ident.model.motions import InitialValueProblem, motions
from cdp_ident.model.time_grid import TimeGrid
from cdp_ident.model.weights import Weight
from cdp_ident.trial.trial import Trial

HAND = 5.0
"""By which a hand may miss an angle that it leads a rod to [degrees]."""
_FEW = 3
"""Angles of which none is left out."""
_FINALISTS = 5
"""So many of the best starts are judged by what comes of them where the hand misses."""


@dataclass(frozen=True)
class CandidateTrial:
    """Both rods are held at rest, at angles from hanging [rad], positive towards +x, and let go."""

    inner: float
    outer: float
    weights: tuple[Weight, ...] = ()
    """Clamped to the rods; what they may be wrong by is among the unknowns of the knowledge that judges the trial."""

    @property
    def mirrored(self) -> "CandidateTrial":
        """The same on the other side of hanging."""
        return replace(self, inner=-self.inner, outer=-self.outer)


def swing_of(candidate: CandidateTrial, knowledge: Knowledge) -> tuple[Swing, Array]:
    """Return the swing that a trial would be, were the model true, and the states (nodes, states) at its nodes.

    Raises `IdentificationError` where its motion cannot be computed.
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
    start = model.initial_state(np.array([np.pi + candidate.inner, np.pi + candidate.outer, 0.0, 0.0]))
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

    Its states are eliminated, and what unknown torques could do. Raises `IdentificationError` where its motion cannot
    be computed.
    """
    model, values = knowledge.model, knowledge.values
    swing, states = swing_of(candidate, knowledge)
    linear = swing.linearised(model, values, states)
    nothing = np.zeros((0, len(values) + 1))
    return reduced(model, nothing, [swing], [linear], [states], knowledge.noise).of_values[:, :-1]


@dataclass(frozen=True)
class Grid:
    """Starts at which both rods are held, by their angles from hanging, positive towards +x."""

    inner: Array
    """(n,) of the inner rod [rad]."""
    outer: Array
    """(m,) of the outer rod [rad]."""

    @classmethod
    def of(cls, spacing: float, most_inner: float = 180.0, most_outer: float = 180.0) -> "Grid":
        """Lay a grid [degrees]; no rod is led further from hanging than is said."""
        return cls(_angles(spacing, most_inner), _angles(spacing, most_outer))

    @property
    def thinned(self) -> "Grid":
        """The grid with every second angle, hanging among them; with all, where they are few."""
        return Grid(_every_second(self.inner), _every_second(self.outer))

    def trials(self, weights: tuple[Weight, ...] = ()) -> list[CandidateTrial]:
        """Return the trials that begin at its places, by the inner rod's angle, then by the outer rod's."""
        places = product(self.inner.tolist(), self.outer.tolist())
        return [CandidateTrial(inner, outer, weights) for inner, outer in places]


def _angles(spacing: float, most: float) -> Array:
    count = int(most / spacing + 1e-9)
    # Half a turn to one side is half a turn to the other.
    return np.radians(spacing * np.arange(-count + (count * spacing >= 180.0), count + 1))


def _every_second(angles: Array) -> Array:
    hanging = int(np.argmin(np.abs(angles)))
    return angles[hanging % 2 :: 2] if len(angles) > _FEW else angles


@dataclass(frozen=True)
class Survey:
    """What a criterion makes of every start, and the one to take."""

    grid: Grid
    losses: Array
    """(inner, outer) at each start, smaller is better; infinite where the motion cannot be computed."""
    trial: CandidateTrial
    """That begins at the start to take."""
    expected: float
    """Its loss, as the median over what the hand may miss it by."""
    worst: float
    """The largest of these."""
    unloaded: "Survey | None" = None
    """The same without a weight, where it was asked for."""


def survey(loss: Callable[[CandidateTrial], float], grid: Grid, weights: tuple[Weight, ...] = ()) -> Survey:
    """Return which start has the smallest loss, also where the hand misses it by HAND; the rods have weights.

    A double pendulum is let go from nearby starts to quite different motions: what is best at a point and nowhere
    around it is no advice. Raises `IdentificationError` where no start has a loss that can be computed.
    """
    trials = grid.trials(weights)
    losses = np.array(list(parallel_map(loss, trials)))
    if not np.any(np.isfinite(losses)):
        raise IdentificationError("from no start can the fitted model's motion be computed: identify again")
    best = np.argsort(losses, kind="stable")[:_FINALISTS].tolist()
    misses = list(product(np.radians([-HAND, HAND]).tolist(), repeat=2))
    missed = [CandidateTrial(trials[k].inner + a, trials[k].outer + b, weights) for k in best for a, b in misses]
    around = np.column_stack([losses[best], np.reshape(list(parallel_map(loss, missed)), (len(best), -1))])
    expected, worst = np.median(around, axis=1), np.max(around, axis=1)
    k = min(range(len(best)), key=lambda k: (expected[k], worst[k], trials[best[k]].inner, trials[best[k]].outer))
    losses = losses.reshape(len(grid.inner), len(grid.outer))
    return Survey(grid, losses, trials[best[k]], float(expected[k]), float(worst[k]))

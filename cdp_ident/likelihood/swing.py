# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A swing between nodes: what the model says from the states at these, and its derivatives (multiple shooting)."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from cdp_ident.arrays import Array, Indices, Mask
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.likelihood.sweeps import share_rounding
from cdp_ident.model.layout import RODS_STATES
from cdp_ident.model.motions import motions_over
from cdp_ident.model.steps import Times
from cdp_ident.model.time_grid import interpolated
from cdp_ident.model.weights import Weight
from cdp_ident.trial.kinematics import SAME, local_motion
from cdp_ident.trial.trial import Trial

_REGULAR = 1.5
"""Readings that are further apart than so many usual steps do not follow one another."""
_READINGS = np.array([[1.0, 0.0], [-1.0, 1.0]])
"""What the inner and the outer encoder measure of theta1 and theta2."""


class Linearised(NamedTuple):
    """What a model says of a swing near the states at its nodes and the values of its unknowns; see `sweeps`."""

    transitions: Array
    """(nodes, states, d) derivatives of where the motion comes at the next node, by state and unknowns."""
    gaps: Array
    """(nodes, states) from the next node's state to there."""
    pushes: Array
    """(nodes, 2, 2) changes of the rods' speeds by impulses of torque over A22 in both joints."""
    by_base: Array
    """(nodes, 2) the same by a change of the base's velocity, over L."""
    slopes: Array
    """(samples, 2, d) derivatives of what the encoders show, by the state at the node before and the unknowns."""
    residuals: Array
    """(samples, 2) shown less measured [rad]."""
    columns: Indices
    """(d - states,) which unknown each direction is."""
    rates: Array
    """(samples, 2) of change of what the encoders show [rad/s]."""


@dataclass(frozen=True)
class Swing:
    """A stretch of a trial without interruption."""

    trial: int
    """Which trial it is of."""
    begin: float
    """Time of its first sample in the trial [s]."""
    readings: Array
    """(samples, 2) of the encoders of both joints [rad]."""
    counts: Array
    """(samples, 2) how much each counts; see `weights_of_readings`."""
    times: Times
    """When the motion from each node to the next one is computed and read, and what moves the cart and the joints."""
    weights: tuple[Weight, ...]
    """On the rods."""
    time: Array
    """(samples,) since the first one [s]."""
    time_std: float
    """Relative standard deviation of the trial's unit of time."""

    @classmethod
    def of(
        cls,
        trial: Trial,
        index: int,
        step: float,
        spacing: float,
        begin: float = 0.0,
        bounds: Sequence[tuple[int, int]] | None = None,
        encoder_steps: Sequence[float] | Array = (0.0, 0.0),
    ) -> list["Swing"]:
        """Lay nodes of a spacing [s] along a trial, between its interruptions.

        Args:
            trial: what is measured.
            index: which trial it is.
            step: of the integrator [s].
            spacing: of the nodes [s].
            begin: when the trial's time is zero, in the time that the model knows [s].
            bounds: first sample and end of each stretch that is taken; by default those between interruptions.
            encoder_steps: (2,) of the inner and the outer encoder [rad].
        """
        every = max(1, round(spacing / step))
        swings = []
        for first, last in trial.bounds if bounds is None else bounds:
            time, theta = trial.time[first:last] - trial.time[first], trial.theta[first:last]
            nodes = max(1, int(np.ceil(time[-1] / (every * step) - 1e-9)))
            node = np.minimum((time / (every * step) + 1e-9).astype(int), nodes - 1)
            samples_at = np.searchsorted(node, np.arange(nodes + 1))
            halves = every * step * np.arange(nodes)[:, None] + 0.5 * step * np.arange(2 * every + 1)
            at, moved, torques = halves.ravel(), trial.cart_acceleration, trial.torques
            start = begin + float(trial.time[first])
            times = Times(
                begin=np.asarray(start + every * step * np.arange(nodes)),
                step=np.full(nodes, step),
                steps_at=every * np.arange(nodes + 1, dtype=np.int64),
                samples_at=samples_at.astype(np.int64),
                place=time / step - every * node,
                u=np.zeros(len(at)) if moved is None else np.interp(at, time, moved[first:last]),
                drive=np.zeros((0, 2)) if torques is None else interpolated(at, time, torques[first:last]),
            )
            swings.append(
                cls(
                    trial=index,
                    begin=start,
                    readings=theta @ _READINGS.T,
                    counts=weights_of_readings(theta @ _READINGS.T, encoder_steps),
                    times=times,
                    weights=trial.weights,
                    time=time,
                    time_std=trial.clock.std if trial.clock else 0.0,
                )
            )
        return swings

    def start_deviations(self, model: MotionModel) -> Array:
        """Return the standard deviation of each number of the state at the first node, before anything is measured."""
        own = [state.start_std for active in model.effects for state in active.effect.law.states]
        return np.array([np.inf] * RODS_STATES + own + [self.time_std] * (self.time_std > 0.0))

    def states(self, model: MotionModel) -> Array:
        """Return states (nodes, states) to begin with, as the readings show them; what effects bring is zero.

        Where the trial's unit of time is uncertain, its relative error is one number more.
        """
        nodes = self.node_times
        angles, speeds = local_motion(self.time, np.cumsum(self.readings, axis=1), np.minimum(nodes, self.time[-1]))
        states = np.zeros((len(nodes), model.states + (self.time_std > 0.0)))
        states[:, :RODS_STATES] = np.concatenate([angles, speeds], axis=1)
        return states

    @cached_property
    def follows(self) -> Mask:
        """(samples, 2) whether each reading follows another one of its encoder as soon as usual, neither repeated."""
        steps, whole = np.diff(self.time), self.counts == 1.0
        follows = np.zeros(self.counts.shape, dtype=bool)
        follows[1:] = whole[1:] & whole[:-1] & (steps < _REGULAR * np.median(steps))[:, None]
        return follows

    @property
    def spacing(self) -> float:
        """Of the nodes [s]."""
        return float(self.times.step[0] * self.times.steps_at[1])

    @property
    def node_times(self) -> Array:
        """(nodes,) when they are, since the first sample [s]."""
        return np.asarray(self.spacing * np.arange(len(self.times.begin)))

    @property
    def samples_at(self) -> Indices:
        """(nodes + 1,) where the samples of each node begin."""
        return self.times.samples_at

    @property
    def u(self) -> Array:
        """(nodes,) the cart's acceleration at the nodes [m/s^2]."""
        return self.times.u[2 * self.times.steps_at[:-1] + np.arange(len(self.times.begin))]

    def linearised(self, model: MotionModel, values: Array, states: Array, wanted: Mask | None = None) -> Linearised:
        """Return what a model says of the swing near states and values.

        Args:
            model: gives the motion.
            values: (unknowns,)
            states: (nodes, states)
            wanted: (unknowns,) by which of these derivatives are wanted, the others being zero; by all by default.
        """
        weighted = model.with_weights(values, self.weights) if self.weights else None
        of_trial = weighted.values if weighted else values
        acting = model.acting(of_trial, self.trial, weighted.carried if weighted else 0.0)
        n, columns = model.states, model.columns_in(self.trial)
        if wanted is not None:
            acting, columns = acting.with_directions(wanted[columns]), columns[wanted[columns]]
        coefficients = model.coefficients(of_trial)
        found = motions_over(self.times, coefficients, np.ascontiguousarray(states[:, : model.states]), acting)
        by, ends_by = found.by, found.ends_by
        zeros = model.zero_places(self.trial)
        shown = found.readings
        if weighted:
            of_rig, columns = weighted.by_rig[columns], np.arange(len(values))
            by = np.concatenate([by[..., :n], by[..., n:] @ of_rig], axis=-1)
            ends_by = np.concatenate([ends_by[..., :n], ends_by[..., n:] @ of_rig], axis=-1)
        if zeros.stop > zeros.start:
            shown = shown + model.by_zeros @ values[zeros]
            by = np.concatenate([by, np.tile(model.by_zeros, (len(by), 1, 1))], axis=-1)
            ends_by = np.concatenate([ends_by, np.zeros((*ends_by.shape[:2], zeros.stop - zeros.start))], axis=-1)
            columns = np.append(columns, np.arange(zeros.start, zeros.stop))
            order = np.argsort(columns, kind="stable")
            columns, by = columns[order], np.concatenate([by[..., :n], by[..., n:][..., order]], axis=-1)
            ends_by = np.concatenate([ends_by[..., :n], ends_by[..., n:][..., order]], axis=-1)
        ends, rates = found.ends, np.gradient(shown, self.time, axis=0)
        if self.time_std > 0.0:
            # Measured against a clock that is fast by a share, a motion is where it would be that share of t later.
            later = rates * self.time[:, None]
            shown = shown + later * states[0, -1]
            by = np.insert(by, n, later, axis=-1)
            ends_by = np.insert(np.insert(ends_by, n, 0.0, axis=-1), n, 0.0, axis=1)
            ends_by[:, n, n] = 1.0
            ends = np.column_stack([ends, states[:, -1]])
        gaps = np.zeros_like(ends)
        gaps[:-1] = ends[:-1] - states[1:]
        pushes, by_base = (of / (weighted.share if weighted else 1.0) for of in _pushes(coefficients, found.ends))
        return Linearised(
            np.ascontiguousarray(ends_by), gaps, pushes, by_base, np.ascontiguousarray(by), shown - self.readings,
            columns, rates,
        )  # fmt: skip


def weights_of_readings(readings: Array, steps: Sequence[float] | Array) -> Array:
    """Return weights (n, 2) of both encoders' readings (n, 2), of steps (2,), that follow one another [rad].

    While a joint stays within a step its readings share one error of rounding, whether they repeat or go to and fro.
    All of these together count as one for each step that they show.
    """
    weights = np.empty(readings.shape)
    for of_encoder, reading, step in zip(weights.T, readings.T, steps, strict=True):
        share_rounding(np.ascontiguousarray(reading), max(step, SAME), of_encoder)
    return weights


def _pushes(coefficients: Array, states: Array) -> tuple[Array, Array]:
    """Return the changes (k, 2, 2) of the rods' speeds in states by impulses in both joints, over A22.

    And those (k, 2) by a change of the base's velocity, over L: it acts on the rods as -a1 cos(theta1) and -m2 l2
    cos(theta2).
    """
    A23, A33, a1, _, _, L, _ = coefficients
    coupling = A23 * np.cos(states[:, 0] - states[:, 1])
    one = np.ones_like(coupling)
    inverse = np.array([[A33 * one, -coupling], [-coupling, one]]) / (A33 - coupling**2)
    # A torque in the outer joint acts on both rods.
    by_torques = np.einsum("ijk,jt->kit", inverse, [[1.0, -1.0], [0.0, 1.0]])
    on_rods = -np.array([a1 * L * np.cos(states[:, 0]), A23 * np.cos(states[:, 1])])
    return np.ascontiguousarray(by_torques), np.einsum("ijk,jk->ki", inverse, on_rods)

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Steps of Gauss and Newton to the most likely values and states, and standard deviations that belong to them.

Steps on states and unknowns together end at the maximum of the joint density (Bell, SIAM J. Optim. 4, 1994). By Laplace
the likelihood of the standard deviations follows (Kristensen, Madsen and Jorgensen, Automatica 40, 2004). At its
maximum the squares of what is taken for noise or torques are what these let expect, less the degrees of freedom that
the estimates took (MacKay, Neural Comput. 4, 1992).
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.likelihood.noise import Noise
from cdp_ident.likelihood.prior import Known, known_before
from cdp_ident.likelihood.reduction import Reduced, most_likely_change, reduced
from cdp_ident.likelihood.sweeps import forwards
from cdp_ident.likelihood.swing import Linearised
from cdp_ident.likelihood.whole_swing import Recorded, WholeSwings

MOST_STEPS = 60
_ROUGHLY, CLOSE = 1.0, 0.03
"""Standard deviations are estimated once a step, or what is to be expected of the next one, changes no value by more
than the first share of its own, and steps end where none changes by more than the second."""
_LONGEST = 3.0
"""Largest change of a torque's logarithm in a step."""
_PATIENCE = 4
"""Where friction begins to hold a joint or lets go, steps may go to and fro: they are halved each time that so many
have not made the change smaller."""
_HOPELESS = 10.0
"""A search is given up where so many more steps like the last one would not make the misfit small enough."""
_BEYOND = 10.0
"""Torques grow at once where their impulses' squares are so many times what is expected."""
_FREE = 0.05
"""A torque whose impulses have fewer degrees of freedom changes nothing: its size need not be known better."""
SHOWN = 10.0
"""A torque is missing where the misfit would be larger by this without it: odds of 150 against chance."""
_TELLING = 0.05
"""Residuals tell of the noise's memory where estimates took less than this share of their degrees of freedom."""
_TURNS = 300.0
"""No rod turns by more than so many radians in a time unit: where a search strays so far, it is given up."""


class GaussNewton:
    """Gauss and Newton's steps on states and values, with standard deviations that fit what was found so far."""

    def __init__(
        self,
        model: MotionModel,
        values: Array,
        recorded: Recorded,
        states: Sequence[Array],
        noise: Noise,
        close: float = CLOSE,
    ) -> None:
        """Begin near the maximum that is looked for.

        Args:
            model: gives the motion.
            values: (unknowns,)
            recorded: what was measured.
            states: (nodes, states) of each swing.
            noise: of encoders, and unknown torques.
            close: changes below this share of a standard deviation end the search.
        """
        self._model, self.values, self._recorded, self._close = model, values, recorded, close
        self._swings = recorded.swings
        self.states = [of.copy() for of in states]
        self._noise = noise
        self._impulses: list[Array] = [np.zeros((len(of), 2, 2)) for of in states]
        self._linear: list[Linearised] = []
        self._freedom = np.zeros(2)
        self._taken = 0.0
        self._steps, self._near = 0, 0
        self._before: list[tuple[float, float] | None] = [None, None]
        self.excess = np.ones(2)
        """(2,) the squares of the impulses, over what their standard deviation lets expect."""
        self.converged, self.misfit = False, np.inf

    def run(self, most_steps: int = MOST_STEPS, to_beat: float = np.inf, held: bool = False) -> "GaussNewton":
        """Go on until nothing changes any more.

        Args:
            most_steps: after so many it ends where it is.
            to_beat: a misfit; it ends where its own will hardly be smaller.
            held: whether unknown torques keep their standard deviations.

        Raises:
            IdentificationError: no motion can be computed.
        """
        change, rest, bend, least, stalled, share, is_same = np.inf, np.inf, np.inf, np.inf, 0, 1.0, False
        begun: tuple[Array, list[Array]] | None = None
        looked = held
        for made in range(most_steps + 1):
            self._steps += made > 0
            # Where it goes on from an end it is linear already.
            if (made > 0 or not self._linear) and not self._linearise():
                if begun is None or made == most_steps:
                    raise IdentificationError("the motion between nodes cannot be computed")
                # A step that leads where there is no motion is halved.
                self.values = 0.5 * (begun[0] + self.values)
                self.states = [0.5 * (old + new) for old, new in zip(begun[1], self.states, strict=True)]
                is_same = False
                continue
            if made == most_steps:
                break
            begun = self.values, self.states
            if rest < _ROUGHLY and self._taken < _TELLING and not held:
                self._look_at_residuals()
                looked, is_same = True, False
            # Where the motion is nearly linear in all that changes, standard deviations need no other linearisation.
            for _ in range(most_steps if rest < _ROUGHLY else 1):
                step, torque, adapted = self._step(), self._noise.torque, np.inf
                before, change = change, share * step.change
                if is_same:  # after Newton's steps changes fall as their squares
                    bend = change / before**2
                rest, is_same = min(change, bend * change**2), False
                near = rest < _ROUGHLY
                if held:
                    self._noise = self._of_readings(step.freedom)[0]
                    break
                if near or step.is_beyond:
                    adapted = self._adapt(step.freedom, near)
                else:
                    is_same = share == 1.0
                if not near:
                    break
                self._noise = self._noise.with_tails(step.impulses, self._swings, torque, self._recorded.least_torque)
                if adapted < self._close:
                    break
            self._impulses, self._freedom = step.impulses, step.freedom[1]
            misfit, self.misfit = self.misfit, step.misfit
            self.converged = max(change, adapted) < self._close
            if self.converged and not looked and self._taken < _TELLING:
                # The noise is that of another model still, and may be of another kind.
                before_it, looked = self._noise, True
                self._look_at_residuals()
                self.converged = self._noise.kind == before_it.kind
            if self.converged:
                break
            self._near += near
            if self._near >= _PATIENCE and max(_HOPELESS * (misfit - self.misfit), 0.0) < self.misfit - to_beat:
                break
            if change < least or (np.isfinite(adapted) and not near):
                least, stalled = change, 0
            else:
                stalled += 1
            if stalled == _PATIENCE:
                least, stalled, share = np.inf, 0, 0.5 * share
            self.values = self.values + share * (step.values - self.values)
            self.states = [old + share * (new - old) for old, new in zip(self.states, step.states, strict=True)]
        return self

    def expected_misfit(self) -> float:
        """Return the misfit that the next step would lead to if the motion were linear; infinite without a motion."""
        try:
            return self._misfit_with(self._noise) if self._linearise() else np.inf
        except np.linalg.LinAlgError:
            return np.inf

    def _linearise(self) -> bool:
        """Linearise the motion where the search is; return whether there is one."""
        fastest = _TURNS / self._recorded.time_unit
        if not all(np.all(np.abs(of[:, 2:4]) < fastest) for of in self.states):
            return False
        linear = [
            swing.linearised(self._model, self.values, of) for swing, of in zip(self._swings, self.states, strict=True)
        ]
        if not all(np.all(np.isfinite(of.residuals)) for of in linear):
            return False
        self._linear = linear
        return True

    def found(self) -> WholeSwings:
        """Return what was found."""
        misfit = self._misfit_with(self._noise)
        is_missing = np.zeros(2, dtype=bool)
        for joint in np.flatnonzero(self._noise.torque > self._recorded.least_torque):
            without = self._noise.with_torque_in_one(int(joint), self._recorded.least_torque)
            other = self._misfit_with(without) if self._freedom[joint] > _FREE else misfit
            is_missing[joint] = other > misfit + SHOWN
            if other < misfit:
                self._noise, misfit = without, other
        reduced = self._reduced()
        _, covariance, undetermined = most_likely_change(self._model, self.values, reduced.of_values)
        covariance[undetermined, undetermined] = np.inf
        return WholeSwings(
            model=self._model,
            values=self.values,
            covariance=covariance,
            triangle=reduced.of_values[:, :-1],
            recorded=self._recorded,
            noise=self._noise,
            is_missing=is_missing,
            freedom=self._freedom,
            impulses=tuple(self._impulses),
            states=tuple(self.states),
            linear=tuple(self._linear),
            misfit=misfit,
            steps=self._steps,
            converged=self.converged,
        )

    def _misfit(self, reduced: Reduced, change: Array, noise: Noise) -> float:
        rest = reduced.squares(change) + reduced.logarithm
        return rest + sum(map(noise.logarithm, self._swings, self._linear)) + noise.unlikelihood_of_tails

    def _misfit_with(self, noise: Noise) -> float:
        """Return the misfit that other standard deviations give, as far as the motion is linear in what they move."""
        reduced = self._reduced(noise)
        change, _, _ = most_likely_change(self._model, self.values, reduced.of_values)
        return self._misfit(reduced, change, noise)

    def _look_at_residuals(self) -> None:
        """Let noise have the memory, or the errors of time, and be of the angles, that residuals show most likely."""
        without, swings, linear = replace(self._noise, time=0.0), self._swings, self._linear
        tried = list[tuple[Noise, float]]()
        of_outer = np.inf
        for of, price in ((without, 0.0), (without.of_other_angles(swings, linear), SHOWN)):
            remembering, late = of.remembering(swings, linear), of.with_errors_of_time(swings, linear)
            # Beside theta1, which is the inner encoder's, that angle is independent which scatters less.
            if late.sizes[1] < of_outer:
                tried += [(of, price)]
                tried += [(remembering, price)] * (not (of.is_white and remembering.is_white))
                tried += [(late, price + SHOWN)] * (late.time > 0.0)
                of_outer = late.sizes[1]
        self._noise = min(tried, key=lambda one: self._misfit_with(one[0]) + one[1])[0] if len(tried) > 1 else without

    @cached_property
    def _known(self) -> Known:
        return known_before(self._model)

    def _step(self) -> "_Step":
        """Return where the most likely states and values are, as far as the motion is linear in them."""
        reduced = self._reduced()
        change, covariance, undetermined = most_likely_change(self._model, self.values, reduced.of_values)
        deviations = np.sqrt(np.diag(covariance))
        known = np.logical_not(undetermined) & (deviations > 0.0)
        largest = float(np.abs(change[known] / deviations[known]).max(initial=0.0))
        all_states, all_impulses, total = list[Array](), list[Array](), np.zeros((4, 2))
        for states, linear, part in zip(self.states, self._linear, reduced.parts, strict=True):
            (nodes, n, d), freedom = part.swing.transitions.shape, np.empty((4, 2))
            torques = np.zeros((nodes, 2, 2))
            deviations, spreads = np.empty((nodes, d)), np.empty((nodes, d, d))
            deviations[0], spreads[0] = part.first_node(change[linear.columns], covariance, linear.columns)
            memory_for_rows = np.empty((2 * n + 2, d + 1))
            forwards(part.swing, part.impulses, deviations, spreads, torques, freedom, memory_for_rows)
            all_states.append(states + deviations[:, : states.shape[1]])
            all_impulses.append(torques)
            total += freedom
            # States that effects bring are in units of their own: what counts is what the encoders show of them.
            own = np.delete(deviations, np.s_[states.shape[1] : n], axis=1)
            at_samples = np.repeat(own, np.diff(part.swing.samples_at), axis=0)
            shown = np.einsum("sij,sj->si", linear.slopes, at_samples)
            largest = max(largest, float(np.abs(shown).max() / self._noise.encoders.max()))
        if not np.isfinite(largest):
            raise IdentificationError("the most likely motion cannot be computed")
        misfit = self._misfit(reduced, change, self._noise)
        return _Step(self.values + change, all_states, all_impulses, total, largest, misfit)

    def _adapt(self, freedom: Array, near: bool) -> float:
        """Let the standard deviations fit what was found, and return by how much that matters to the likelihood."""
        noise, off = self._of_readings(freedom)
        _, freedom, _, impulses = freedom
        freedom, tiny = np.maximum(freedom, 0.0), np.finfo(float).tiny
        with np.errstate(over="ignore"):  # a motion that is lost altogether
            self.excess = np.maximum(impulses, tiny) / np.maximum(freedom, tiny)
        steps = [self._step_of_torque(joint) if freedom[joint] > _FREE else 0.0 for joint in range(2)]
        least = self._recorded.least_torque
        torque = np.maximum(noise.torque * np.exp(np.clip(steps, -_LONGEST, _LONGEST)), least)
        if not near:  # what is far from its place yet tells nothing but that torques are larger
            self._before = [None, None]
            self._noise = replace(self._noise, torque=np.maximum(torque, noise.torque))
            return np.inf
        self._noise = replace(noise, torque=torque)
        # By so many of its own standard deviations each logarithm is off.
        of_torques = np.abs(impulses - freedom) / np.sqrt(2.0 * np.maximum(freedom, tiny))
        matters = (freedom > _FREE) & (torque > least)
        return float(max(off, np.where(matters, of_torques, 0.0).max()))

    def _of_readings(self, freedom: Array) -> tuple[Noise, float]:
        """Return noise of readings that fits, and by how many of its own deviations one of its logarithms is off."""
        taken, _, squares, _ = freedom
        counts = sum(swing.counts.sum(axis=0) for swing in self._swings)
        self._taken = float(np.max(taken / counts))
        left = np.maximum(counts - taken, 1.0)
        if self._noise.time > 0.0:
            noise = self._noise.with_errors_of_time(self._swings, self._linear)
            return noise, float(np.max(np.abs(np.log(noise.new / self._noise.new)) * np.sqrt(2.0 * left)))
        noise = replace(self._noise, new=self._noise.new * np.sqrt(squares / left))
        return noise, float(np.max(np.abs(squares - left) / np.sqrt(2.0 * left)))

    def _step_of_torque(self, joint: int) -> float:
        """Return the change of a torque's logarithm that makes the excess' one zero, from the last one's (secant)."""
        size, excess = float(np.log(self._noise.torque[joint])), float(np.log(self.excess[joint]))
        before, self._before[joint] = self._before[joint], (size, excess)
        if before and size != before[0] and (slope := (excess - before[1]) / (size - before[0])) < 0.0:
            return -excess / slope
        return 0.5 * excess if excess > 0.0 else excess

    def _reduced(self, noise: Noise | None = None) -> Reduced:
        rows = self._known.rows(self.values)
        found = reduced(self._model, rows, self._swings, self._linear, self.states, noise or self._noise)
        return found._replace(logarithm=found.logarithm + self._known.logarithm)


class _Step(NamedTuple):
    """Where the most likely states and values are."""

    values: Array
    states: list[Array]
    impulses: list[Array]
    freedom: Array
    """(4, 2) see `forwards`."""
    change: float
    """The largest: of a value over its deviation, or of a reading over noise."""
    misfit: float
    """There, with the standard deviations from which it begins."""

    @property
    def is_beyond(self) -> bool:
        """Whether the impulses are far larger than their standard deviations let expect."""
        _, freedom, _, impulses = self.freedom
        return bool(np.any(impulses > _BEYOND * freedom))

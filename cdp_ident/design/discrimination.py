# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Two effects that the trials do not distinguish: which further trial does.

T-optimal is the trial in which the alternative model, its values adjusted as well as they can be, comes least near to
what the fitted model says (Atkinson and Fedorov, Biometrika 62, 1975). The alternative must keep explaining the trials
that there are. How far it is off is by how much its misfit to whole swings is expected to be the larger one: what it
leaves of the fitted model's motion, its own states and values and the size of the unknown torques adjusted, too.
"""

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.design.knowledge import Knowledge
from cdp_ident.design.starts import CandidateTrial, swing_of
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.scales import ENOUGH
from cdp_ident.likelihood.noise import Noise
from cdp_ident.likelihood.prior import known_before, typical
from cdp_ident.likelihood.recorded import spread_evenly
from cdp_ident.likelihood.reduction import Reduced, most_likely_change, reduced
from cdp_ident.likelihood.scores import beginnings
from cdp_ident.likelihood.swing import Linearised, Swing
from cdp_ident.likelihood.whole_swing import large_torque
from cdp_ident.model.effects.catalogue import known_effects
from cdp_ident.model.effects.effect import JOINTS
from cdp_ident.model.layout import RODS_STATES
from cdp_ident.model.parameters import time_unit
from cdp_ident.trial.trial import Trial

_SAME = 0.1
"""An alternative nearer to the model than so many deviations can be it, as an extended model of an effect can."""
_LARGER = 4.0
"""From one size of the unknown torques that is tried to the next."""
_MOST_STEPS, _CLOSE = 10, 0.01
"""An alternative is adjusted until a step changes what it leaves by less than this share, or by so many steps."""


@dataclass(frozen=True)
class RecordedMotion:
    """What the fitted model says of the trials that there are."""

    swings: tuple[Swing, ...]
    states: tuple[Array, ...]
    """(nodes, states) of each."""
    share: float
    """Motion of these swings, over all."""
    averaged: float
    """How many readings of the next trial one of these stands for."""

    @classmethod
    def of(cls, knowledge: Knowledge, trials: Sequence[Trial]) -> "RecordedMotion":
        """Lay nodes along trials, or along pieces of them where there is more motion than effects are looked for in."""
        sampling, unit = knowledge.sampling, time_unit(*knowledge.model.constants(knowledge.values))
        stretches = [(index, *bounds) for index, trial in enumerate(trials) for bounds in trial.bounds]
        chosen = spread_evenly(trials, stretches, ENOUGH * unit, unit)
        swings = tuple(
            swing
            for index, first, last in chosen
            for swing in Swing.of(trials[index], index, sampling.step, sampling.spacing, bounds=[(first, last)])
        )
        shown, whole = (
            sum(float(np.ptp(trials[index].time[first:last])) for index, first, last in those)
            for those in (chosen, stretches)
        )
        averaged = np.median(np.concatenate([np.diff(swing.time) for swing in swings])) / sampling.interval
        states = tuple(swing.states(knowledge.model) for swing in swings)
        return cls(swings, states, shown / whole, float(averaged))


@dataclass(frozen=True)
class Alternative:
    """A model with another effect in the place of one, adjusted to what the fitted model says of the trials."""

    knowledge: Knowledge
    """Of the fitted model."""
    place: int
    """Of the effect in the fitted model that it lacks."""
    model: MotionModel
    values: Array
    """(unknowns,) of the alternative."""
    noises: tuple[Noise, ...]
    """With unknown torques of several sizes, the fitted model's first."""
    says: tuple[Reduced, ...]
    """What the trials say of its values near these, with each of them."""

    @property
    def deviations_now(self) -> float:
        """By how many standard deviations the two differ in the trials that there are."""
        return self._deviations(self.says)

    @property
    def can_be_the_same(self) -> bool:
        """Whether it can say all that the fitted model says, as an extended model of its effect can."""
        return self.deviations_now < _SAME

    def deviations(self, trial: CandidateTrial) -> float:
        """Return by how many standard deviations the two would differ with a further trial; 0 if it has no motion.

        The alternative is linear about its values.
        """
        try:
            swing, states = swing_of(trial, self.knowledge)
            linear, own = self._difference(swing, states)
        except IdentificationError:
            return 0.0
        both = [
            known.with_more(reduced(self.model, known.of_values, [swing], [linear], [own], noise))
            for known, noise in zip(self.says, self.noises, strict=True)
        ]
        return self._deviations(both)

    def adjusted_to(self, recorded: RecordedMotion) -> "Alternative | None":
        """Return it with values that leave least of the fitted model's motion; None where it has no motion."""
        given, common = self.values, len(self.values) - len(self.model.effects[-1].fitted)
        noises = [replace(noise, new=noise.new / np.sqrt(recorded.averaged)) for noise in self.noises]
        now, best = self, None
        for _ in range(_MOST_STEPS):
            # Of the values that both have, what is known beforehand is known of the fitted model, too.
            centre = np.concatenate([given[:common], now.values[common:]])
            known = known_before(self.model)._replace(centre=centre).rows(now.values)
            try:
                differences = [now._difference(*each) for each in zip(recorded.swings, recorded.states, strict=True)]
            except IdentificationError:
                break
            linear, states = zip(*differences, strict=True)
            says = tuple(
                reduced(self.model, np.sqrt(recorded.share) * known, recorded.swings, linear, states, noise)
                for noise in noises
            )
            now = replace(now, says=tuple(of.times(1.0 / recorded.share) for of in says))
            if best and not now.deviations_now < (1.0 - _CLOSE) * best.deviations_now:
                return min(now, best, key=lambda one: one.deviations_now)
            best, likely = now, now.says[int(np.argmin(now._misfits(now.says)))]
            now = replace(now, values=now.values + most_likely_change(self.model, now.values, likely.of_values)[0])
        return best

    def _deviations(self, says: Sequence[Reduced]) -> float:
        return float(np.sqrt(max(np.min(self._misfits(says)), 0.0)))

    def _misfits(self, says: Sequence[Reduced]) -> Array:
        """Return by how much its misfit is expected to be larger than the fitted model's, with each of the torques.

        Larger torques follow more of the motion and, by their degrees of freedom, of the noise, and are less likely.
        """
        changes = (most_likely_change(self.model, self.values, of.of_values)[0] for of in says)
        left = [of.squares(change) for of, change in zip(says, changes, strict=True)]
        logarithms = np.array([of.logarithm for of in says])
        logarithms_of_squares = 2.0 * np.log(_LARGER) * np.arange(len(says))
        # Degrees of freedom of the torques: how the determinant changes with the logarithm of their square.
        freedom = np.gradient(logarithms, logarithms_of_squares)
        return left + logarithms - logarithms[0] - freedom * (1.0 - np.exp(-logarithms_of_squares))

    def _difference(self, swing: Swing, states: Array) -> tuple[Linearised, Array]:
        """Return what it says otherwise than the fitted model near states (nodes, states) of that one, and its own.

        Raises `IdentificationError` where it has no motion.
        """
        known, count = self.knowledge, self.model.states
        fitted = swing.linearised(known.model, known.values, states)
        own = _without(known.model, self.place, count, states)
        other = swing.linearised(self.model, self.values, own)
        gaps = other.gaps - _without(known.model, self.place, count, fitted.gaps)
        other = other._replace(gaps=gaps, residuals=other.residuals - fitted.residuals)
        if not all(np.all(np.isfinite(of)) for of in (other.transitions, other.slopes, gaps, other.residuals)):
            raise IdentificationError("the alternative has no motion near that of the fitted model")
        return other, own


def alternatives(knowledge: Knowledge, recorded: RecordedMotion, label: str, key: str) -> Iterator[Alternative]:
    """Yield models with another effect in the place of the fitted model's of a label, each form that can be adjusted.

    It is the effect of a key; name and joint alone stand for all of its forms.
    """
    place = knowledge.model.labels.index(label)
    without, remain = knowledge.model.without_effect(place)
    unit = time_unit(*knowledge.model.constants(knowledge.values))
    for form in known_effects():
        if key not in (form.key, f"{form.name}.{form.joint}") or form.at_an_instant:
            continue
        new = ActiveEffect(form)
        begin = np.concatenate([knowledge.values[remain], _beginning(new, unit)])
        noises = _noises(knowledge, {knowledge.model.effects[place].effect.joint, form.joint}, unit)
        begun = Alternative(knowledge, place, without.with_effect(new), begin, noises, ())
        try:
            found = begun.adjusted_to(recorded)
        except (IdentificationError, np.linalg.LinAlgError):
            continue
        if found:
            yield found


def _noises(knowledge: Knowledge, joints: Collection[str], unit: float) -> tuple[Noise, ...]:
    """Return the noise with unknown torques of several sizes in the joints of two effects, of a base in both."""
    there = np.array([joint in joints for joint in JOINTS])
    there = there if np.any(there) else ~there
    noise, largest = knowledge.noise, large_torque(knowledge.noise.encoders, unit)
    steps = max(1, math.ceil(math.log(largest / float(np.min(noise.torque[there])), _LARGER)))
    return tuple(replace(noise, torque=noise.torque * np.where(there, _LARGER**k, 1.0)) for k in range(steps + 1))


def _without(model: MotionModel, place: int, count: int, states: Array) -> Array:
    """Return states (nodes, k) of a model without those of one effect, filled up with zeros to a count of them."""
    counts = [active.effect.states for active in model.effects]
    first = RODS_STATES + sum(counts[:place])
    left = np.delete(states[:, : model.states], np.s_[first : first + counts[place]], axis=1)
    new = np.zeros((len(states), count - left.shape[1]))
    return np.concatenate([left, new, states[:, model.states :]], axis=1)


def _beginning(new: ActiveEffect, unit: float) -> Array:
    """Return values of an effect's parameters to begin with: no strength, where that shows what more of it would do."""
    if not new.effect.has_score:
        return np.array([typical(parameter, unit) for parameter in new.fitted])
    lower, upper = (np.array([getattr(parameter, end) for parameter in new.fitted]) for end in ("lower", "upper"))
    return np.asarray(np.clip(next(beginnings(new, unit)), lower, upper))

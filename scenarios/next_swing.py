# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A rig that is recorded swing by swing, each fitted along with those before it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cdp_ident.design.knowledge import Knowledge
from cdp_ident.fit.data import noise_over
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Mechanism, Prior
from cdp_ident.fit.scales import scales_of
from cdp_ident.likelihood.maxima import most_likely
from cdp_ident.likelihood.swing import Swing
from cdp_ident.likelihood.whole_swing import Recorded, WholeSwings
from cdp_ident.model.parameters import GROUPS
from cdp_ident.model.weights import Weight
from cdp_ident.trial.trial import Trial
from reference.pendulum import TABLE_5, Array
from reference.weights import with_weight
from scenarios.paper_rig import GROUPS as TRUTH
from scenarios.twin import twin

PRIOR = Prior()
MODEL = MotionModel(Mechanism.of(PRIOR))
ALL_GROUPS = tuple(group.symbol for group in GROUPS)
NOISE = 1e-3
"""Of the angles [rad]."""


def swing(
    theta1: float, theta2: float, rng: np.random.Generator, duration: float = 10.0, weight: Weight | None = None
) -> Trial:
    """Return a trial whose rods are let go at rest, from angles from upright [rad].

    A weight on one of them is off by what its standard deviations say.
    """
    times = np.arange(round(200 * duration)) / 200.0
    start = np.array([theta1, theta2, 0.0, 0.0])
    if weight is None:
        return twin(rng, start=start, times=times, noise=NOISE, counts_per_turn=None, tolerance=1e-10)
    mass, place = rng.normal(weight.mass, weight.mass_std), rng.normal(weight.place, weight.place_std)
    heavier = with_weight(TABLE_5, weight.rod, mass, place, weight.inertia)
    trial = twin(rng, heavier, start, times, noise=NOISE, counts_per_turn=None, tolerance=1e-10)
    return replace(trial, weights=(weight,))


@dataclass(frozen=True)
class Swings:
    """Swings of the rig, and what a fit to all of them says. It begins at the truth, whose basin the search finds."""

    trials: tuple[Trial, ...]
    fit: WholeSwings
    knowledge: Knowledge

    @classmethod
    def of(cls, trials: Sequence[Trial], model: MotionModel = MODEL, truth: Array = TRUTH) -> "Swings":
        """Fit trials as `identify` does in the end."""
        noise = noise_over(trials)
        scales = scales_of(trials, PRIOR.length, PRIOR.gravity)
        weights = [weight for trial in trials for weight in trial.weights]
        errors = tuple(dict.fromkeys(error for weight in weights for error in weight.errors))
        model = replace(model, inertia_free=bool(weights), weight_errors=errors)
        values = np.concatenate([model.initial_values(truth[: len(GROUPS)]), truth[len(GROUPS) :]])

        def recorded(spacing: float) -> tuple[Recorded, list[Array]]:
            swings = tuple(
                each
                for index, trial in enumerate(trials)
                for each in Swing.of(trial, index, scales.step, spacing * scales.time_unit)
            )
            encoders = np.full(2, noise[0])
            states = [each.states(model) for each in swings]
            return Recorded(swings, encoders, scales.encoder_steps, scales.time_unit), states

        fit = most_likely(model, values, recorded)
        inertia = 1.0 / model.inverse_inertia(fit.values)
        return cls(tuple(trials), fit, Knowledge.of(fit, fit.values, fit.covariance, inertia))

    def with_one_more(self, trial: Trial) -> "Swings":
        """Return the swings with a further one."""
        return Swings.of((*self.trials, trial))

    def standard_deviations(self, names: Sequence[str]) -> Array:
        """Return the standard deviations of some of the fitted values."""
        return np.asarray(np.sqrt(np.diag(self.knowledge.covariance))[self.knowledge.places(names)])

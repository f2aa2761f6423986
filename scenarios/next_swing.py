"""A rig that is recorded swing by swing, each fitted along with those before it."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cdp_ident.design.information import curvature, scaled_inverse
from cdp_ident.design.knowledge import Knowledge
from cdp_ident.fit.data import noise_over
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.refinement import Fit, refine
from cdp_ident.fit.scales import scales_of
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.parameters import GROUPS, SYMBOLS, groups_of
from cdp_ident.model.weights import Weight
from cdp_ident.trial.trial import Trial
from reference.pendulum import TABLE_5, Array
from reference.weights import with_weight
from scenarios.twin import twin

PRIOR = Prior()
MODEL = MotionModel(Mechanism.of(PRIOR))
TRUTH = groups_of(np.array([TABLE_5[symbol] for symbol in SYMBOLS]), TABLE_5["L"])
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


def covariance(fit: Fit) -> Array:
    """Return the covariance (unknowns, unknowns) of values fitted over windows, of white noise."""
    return np.asarray(fit.variance * scaled_inverse(curvature(fit) + fit.model.penalty, 1e-12)[0])


@dataclass(frozen=True)
class Swings:
    """Swings of the rig, and what a fit to all of them says. It begins at the truth, whose basin the search finds."""

    trials: tuple[Trial, ...]
    fit: Fit
    knowledge: Knowledge

    @classmethod
    def of(cls, trials: Sequence[Trial]) -> "Swings":
        """Cut trials into windows as `identify` does, and fit them."""
        noise = noise_over(trials)
        length, gravity = PRIOR.length, PRIOR.gravity
        scales = scales_of(trials, length, gravity, noise, lambda trial: TRUTH)
        windows = cut_into_windows(trials, scales.window, scales.step, scales.half_width)
        weights = [weight for trial in trials for weight in trial.weights]
        errors = tuple(dict.fromkeys(error for weight in weights for error in weight.errors))
        model = replace(MODEL, inertia_free=bool(weights), weight_errors=errors, penalty_of_errors=NOISE**2)
        fit = refine(model, model.initial_values(TRUTH), windows)
        inertia = 1.0 / model.inverse_inertia(fit.values)
        return cls(tuple(trials), fit, Knowledge.of(fit, covariance(fit), inertia, scales, noise))

    def with_one_more(self, trial: Trial) -> "Swings":
        """Return the swings with a further one."""
        return Swings.of((*self.trials, trial))

    def standard_deviations(self, names: Sequence[str]) -> Array:
        """Return the standard deviations of some of the fitted values."""
        return np.asarray(np.sqrt(np.diag(self.knowledge.covariance))[self.knowledge.places(names)])

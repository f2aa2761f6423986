"""A rig that is recorded swing by swing, each fitted along with those before it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cdp_ident.design.knowledge import Knowledge
from cdp_ident.diagnosis.uncertainty import covariance
from cdp_ident.fit.data import noise_over
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.refinement import Fit, refine
from cdp_ident.fit.scales import scales_of
from cdp_ident.fit.window_lengths import predictable_lengths, window_bounds
from cdp_ident.fit.windows import Window, cut_at
from cdp_ident.model.parameters import GROUPS, SYMBOLS, groups_of
from cdp_ident.trial.trial import Trial
from reference.pendulum import TABLE_5, Array
from scenarios.twin import twin

PRIOR = Prior()
MODEL = MotionModel(Mechanism.of(PRIOR))
TRUTH = groups_of(np.array([TABLE_5[symbol] for symbol in SYMBOLS]), TABLE_5["L"])
ALL_GROUPS = tuple(group.symbol for group in GROUPS)
NOISE = 1e-3
"""Of the angles [rad]."""


def swing(theta1: float, theta2: float, rng: np.random.Generator, duration: float = 10.0) -> Trial:
    """Return a trial whose rods are let go at rest, from angles from upright [rad]."""
    times = np.arange(round(200 * duration)) / 200.0
    start = np.array([theta1, theta2, 0.0, 0.0])
    return twin(rng, start=start, times=times, noise=NOISE, counts_per_turn=None, tolerance=1e-10)


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
        windows: list[Window] = []
        for index, trial in enumerate(trials):
            length_at = predictable_lengths(trial, scales, TRUTH, length, gravity, noise)
            for bounds in window_bounds(trial, length_at):
                windows += cut_at(trial, index, bounds, scales.step, scales.half_width)
        fit = refine(MODEL, TRUTH, windows)
        return cls(tuple(trials), fit, Knowledge.of(fit, covariance(fit), scales))

    def with_one_more(self, trial: Trial) -> "Swings":
        """Return the swings with a further one."""
        return Swings.of((*self.trials, trial))

    def standard_deviations(self, names: Sequence[str]) -> Array:
        """Return the standard deviations of some of the fitted values."""
        return np.asarray(np.sqrt(np.diag(self.knowledge.covariance))[self.knowledge.places(names)])

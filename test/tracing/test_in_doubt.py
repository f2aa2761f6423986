"""Effects that the motion neither shows nor excludes make the values that imitate them less certain."""

from functools import cache

import numpy as np
import pytest

from cdp_ident.diagnosis.uncertainty import covariance
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.refinement import refine
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.parameters import SYMBOLS, groups_of
from cdp_ident.pipeline.identify import identify
from cdp_ident.tracing.in_doubt import added_covariance, effects_in_doubt
from cdp_ident.tracing.trace import trace
from cdp_ident.trial.trial import Trial
from reference.dry_friction import DryFriction
from reference.mechanics import Rig
from reference.pendulum import TABLE_5
from reference.plant import Plant
from reference.sticking import path
from scenarios.twin import TEN_SECONDS, as_measured

TRUTH = groups_of([TABLE_5[symbol] for symbol in SYMBOLS], TABLE_5["L"])
START = np.array([np.pi + 1.5, np.pi - 1.0, 0.0, 0.0])
C2 = 4
"""Place of the outer joint's viscous friction."""
WEAK = 6e-5
"""Dry friction that moves the angles by less than the noise [N m]."""


@cache
def motion(friction):
    return path(Plant(Rig(TABLE_5), outer=DryFriction(friction)), START, TEN_SECONDS).states[:, :2]


@cache
def fitted(friction, seed):
    theta = as_measured(motion(friction), np.random.default_rng(seed), noise=1e-3)
    return refine(
        MotionModel(Mechanism.of(Prior())), TRUTH, cut_into_windows([Trial("swing", TEN_SECONDS, theta)], 1.25)
    )


def deviations(fit, spread):
    return (fit.values - TRUTH) / np.sqrt(np.diag(spread))


@pytest.mark.parametrize("seed", range(4))
def test_friction_too_weak_to_be_sure_of_widens_the_interval_of_what_imitates_it(seed):
    fit = fitted(WEAK, seed)
    in_doubt = effects_in_doubt(fit)
    assert "coulomb_friction.outer" in [effect.active.effect.key for effect in in_doubt[:2]]
    spread = covariance(fit)
    assert deviations(fit, spread)[C2] > 8.0
    assert np.abs(deviations(fit, spread + added_covariance(in_doubt))).max() < 3.0
    dry = next(effect for effect in in_doubt if effect.active.effect.key == "coulomb_friction.outer")
    assert dry.change[C2] < 0.0 < fit.values[C2] - TRUTH[C2]


def test_with_nothing_hidden_intervals_hardly_widen():
    ratios = []
    for seed in range(6):
        fit = fitted(0.0, seed)
        spread = covariance(fit)
        ratios.append(np.sqrt(np.diag(spread + added_covariance(effects_in_doubt(fit))) / np.diag(spread)))
    assert np.min(ratios) >= 1.0
    assert np.median(ratios) < 1.1


def test_weights_fall_and_leave_the_chosen_model_its_own():
    in_doubt = effects_in_doubt(fitted(WEAK, 0))
    weights = [effect.weight for effect in in_doubt]
    assert weights == sorted(weights, reverse=True)
    assert 0.0 < sum(weights) < 1.0
    assert np.linalg.eigvalsh(added_covariance(in_doubt)).min() > -1e-12


def test_a_trace_allows_for_them_in_every_interval():
    theta = as_measured(motion(WEAK), np.random.default_rng(0), noise=1e-3)
    traced = trace(identify([Trial("swing", TEN_SECONDS, theta)], [], IdentifyOptions()))
    assert traced.in_doubt
    assert traced.covariance == pytest.approx(traced.whole.covariance + added_covariance(traced.in_doubt))
    base = np.sqrt(np.diag(traced.whole.covariance))[: len(TRUTH)]
    assert np.all(np.sqrt(np.diag(traced.covariance))[: len(TRUTH)] >= base)

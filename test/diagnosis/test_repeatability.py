"""Whether trials agree."""

import numpy as np
import pytest

from cdp_ident.diagnosis.repeatability import repeatability
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.refinement import refine
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.motions import simulate
from cdp_ident.model.parameters import SYMBOLS, groups_of, physical_coefficients
from cdp_ident.trial.trial import Trial
from reference.pendulum import TABLE_3, TABLE_5
from scenarios.twin import TEN_SECONDS, as_measured

MODEL = MotionModel(Mechanism.of(Prior()))
TRUTH = groups_of([TABLE_5[symbol] for symbol in SYMBOLS], TABLE_5["L"])
NAMES = ("first", "second")


def two_trials(friction=1.0, seed=0):
    rng = np.random.default_rng(seed)
    second = {**TABLE_5, "c1": friction * TABLE_5["c1"]}
    motions = [
        simulate(physical_coefficients(values), np.array(start), TEN_SECONDS, step=0.001)[:, :2]
        for values, start in ((TABLE_5, TABLE_3), (second, (2.2, 2.0, 0.0, 0.0)))
    ]
    trials = [Trial(name, TEN_SECONDS, as_measured(theta, rng)) for name, theta in zip(NAMES, motions, strict=True)]
    return refine(MODEL, TRUTH, cut_into_windows(trials))


def test_trials_of_one_pendulum_agree():
    results = [repeatability(two_trials(seed=seed), NAMES) for seed in range(8)]
    assert sum(result.agree for result in results) >= 7
    assert np.mean([result.p_value for result in results]) > 0.2


def test_each_trial_s_own_estimate_stands_beside_the_joint_one():
    fit = two_trials()
    result = repeatability(fit, NAMES)
    assert result.trials == NAMES
    assert np.abs((result.values - TRUTH) / result.std).max() < 4
    assert np.all(fit.values >= result.values.min(axis=0) - result.std.max(axis=0))
    assert np.all(fit.values <= result.values.max(axis=0) + result.std.max(axis=0))


@pytest.mark.parametrize("friction", [0.9, 1.1])
def test_trials_with_different_friction_do_not_agree(friction):
    result = repeatability(two_trials(friction), NAMES)
    assert not result.agree
    apart = np.abs(np.diff(result.values, axis=0)[0]) / np.linalg.norm(result.std, axis=0)
    assert np.argmax(apart) == 3  # c1 / A22


def test_one_trial_has_nothing_to_agree_with():
    fit = two_trials()
    alone = refine(MODEL, TRUTH, [window for window in fit.windows if window.trial == 1])
    assert repeatability(alone, NAMES) is None


def test_what_only_one_trial_shows_is_not_compared():
    fit = two_trials()
    impulse = next(effect for effect in CATALOGUE if effect.key == "impulse.inner")
    model = MODEL.with_effect(ActiveEffect(impulse, trial=0))
    result = repeatability(refine(model, np.append(fit.values, [0.0, 1.0]), fit.windows), NAMES)
    assert np.isinf(result.std[1, 5])
    assert result.agree == repeatability(fit, NAMES).agree

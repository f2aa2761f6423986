# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects that the motion neither shows nor excludes make the values that imitate them less certain."""

from functools import cache

import numpy as np
import pytest

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.likelihood.scores import Score
from cdp_ident.model.effects.curves import CURVES
from cdp_ident.tracing.in_doubt import added_covariance, effects_in_doubt
from cdp_ident.tracing.neighbours import scores_of
from scenarios.swings import TRUE, fitted, known, measured, motion, recorded

C2 = 4
"""Place of the outer joint's viscous friction."""
WEAK = 1.2e-4
"""Dry friction that is hardly shown [N m]."""
DRY = "coulomb_friction.outer"


@cache
def swing(friction, seed):
    return fitted(recorded([measured(motion(dry=friction), np.random.default_rng(seed), noise=1e-3)]))


def in_doubt_of(found):
    scored = scores_of(found, named_only=True)
    return effects_in_doubt(scored)


def score(gain, key=DRY, **more):
    effect = known(key) if isinstance(key, str) else key
    change = np.array([1.0, 0.0])
    return Score(ActiveEffect(effect, **more), -gain, gain, np.zeros(1), change, np.diag([0.0, 2.0]))


@pytest.mark.parametrize("seed", range(2))
def test_friction_too_weak_to_be_sure_of_widens_the_interval_of_what_imitates_it(seed):
    found = swing(WEAK, seed)
    in_doubt = in_doubt_of(found)
    dry = next(effect for effect in in_doubt if effect.active.effect.key == DRY)
    assert dry.change[C2] < 0.0 < found.values[C2] - TRUE[C2]
    widened = np.diag(found.covariance + added_covariance(in_doubt))
    assert widened[C2] > 1.1 * found.covariance[C2, C2]
    assert np.all(widened >= np.diag(found.covariance))


@pytest.mark.parametrize("friction", [2e-5, 5e-5])
def test_with_them_values_are_as_far_off_as_is_said(friction):
    """The friction moves the angles by less than the noise, and viscous friction by many standard deviations."""
    found = swing(friction, 0)
    spread = found.covariance + added_covariance(in_doubt_of(found))
    assert np.abs((found.values - TRUE) / np.sqrt(np.diag(spread))).max() < 4.0


def test_with_nothing_hidden_intervals_hardly_widen():
    ratios = []
    for seed in range(3):
        found = swing(0.0, seed)
        spread = found.covariance + added_covariance(in_doubt_of(found))
        ratios.append(np.sqrt(np.diag(spread) / np.diag(found.covariance)))
    assert np.min(ratios) >= 1.0
    assert np.median(ratios) < 1.2


def test_weights_fall_and_leave_the_chosen_model_its_own():
    in_doubt = in_doubt_of(swing(WEAK, 0))
    weights = [effect.weight for effect in in_doubt]
    assert weights == sorted(weights, reverse=True)
    assert 0.0 < sum(weights) < 1.0
    assert np.linalg.eigvalsh(added_covariance(in_doubt)).min() > -1e-12


def test_an_effect_in_doubt_weighs_as_much_as_its_gain_is_beyond_chance_and_harmonics_of_one_together():
    (found,) = effects_in_doubt([score(4.0)])  # twice its strengths: the chosen model's own weight
    assert found.weight == pytest.approx(np.exp(1.0) / (1.0 + np.exp(1.0)))
    assert effects_in_doubt([score(3.0)]) == ()
    # What happens at an instant, and a torque without a name.
    assert effects_in_doubt([score(50.0, "impulse.inner", trial=0), score(50.0, CURVES[0])]) == ()
    alone = effects_in_doubt([score(6.0, "cogging_torque.outer.3 per turn")])
    both = effects_in_doubt([score(6.0, f"cogging_torque.outer.{count} per turn") for count in (3, 4)])
    assert sum(effect.weight for effect in both) == pytest.approx(alone[0].weight)


def test_each_adds_what_it_moves_and_its_own_uncertainty_by_its_weight():
    found = effects_in_doubt([score(8.0)])
    np.testing.assert_allclose(added_covariance(found), found[0].weight * np.diag([1.0, 2.0]))
    assert added_covariance(()) == 0

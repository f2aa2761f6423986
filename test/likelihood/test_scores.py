# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A score foresees what a fit with an effect then finds, and what happened at one instant is found at its node."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.likelihood.gauss_newton import GaussNewton
from cdp_ident.likelihood.scores import begun, repeated, scores, shocks
from reference import pendulum
from reference.pendulum import TABLE_5
from scenarios.paper_rig import A22
from scenarios.swings import TIME, UNIT, fitted, known, measured, motion, recorded, with_effect

PUSH = 1e-3
"""[N m s]"""


@pytest.fixture(scope="module")
def rubbing():
    return fitted(recorded([measured(motion(dry=2e-4), np.random.default_rng(0))]))


@pytest.fixture(scope="module")
def clean():
    return fitted(recorded([measured(motion(), np.random.default_rng(1))]))


CANDIDATES = ["coulomb_friction.inner", "coulomb_friction.outer", "air_drag.outer.strips", "joint_spring.outer"]


def scored(found, keys=CANDIDATES):
    return scores(found, begun(map(known, keys), UNIT))


def test_what_is_hidden_has_the_best_score_and_each_the_one_that_it_has_alone(rubbing):
    together = scored(rubbing)
    best, *others = together
    assert best.active.effect.key == "coulomb_friction.outer"
    assert best.misfit < -10.0
    assert best.misfit < min(other.misfit for other in others) - 2.0
    for score in together:
        (alone,) = scored(rubbing, [score.active.effect.key])
        assert alone.misfit == pytest.approx(score.misfit, abs=1e-3)


def test_a_score_foresees_the_misfit_the_strength_and_the_other_values_that_a_fit_then_has(clean):
    for score in scored(clean, ["air_drag.outer.strips", "joint_spring.outer", "encoder_scale.inner"]):
        found = with_effect(clean, score.active.effect.key, *score.values)
        std = np.sqrt(np.diag(found.covariance))
        assert found.misfit - clean.misfit == pytest.approx(score.misfit, abs=1.0)
        np.testing.assert_allclose(
            (found.values - np.r_[clean.values + score.change, score.values]) / std, 0.0, atol=0.3
        )
        added = np.sqrt(np.diag(clean.covariance + score.spread))
        np.testing.assert_allclose(added, std[:5], rtol=0.15)


def test_without_anything_hidden_no_score_promises_much_and_strengths_stay_within_their_limits(clean):
    assert min((score.misfit for score in scored(clean)), default=0.0) > -8.0
    for score in scored(clean):
        lower, upper = np.transpose([(p.lower, p.upper) for p in score.active.fitted])
        assert np.all((score.values >= lower) & (score.values <= upper))
    assert all(shock.gain < 25.0 for of_kind in shocks(clean) for shock in of_kind.values())


@pytest.mark.parametrize("joint", ["inner", "outer"])
def test_counts_are_found_where_they_were_lost(joint):
    trial, at, lost = measured(motion(), np.random.default_rng(2)), 4.118, 5e-3  # a node is at 4.12 s
    shown = [1.0, 1.0] if joint == "inner" else [0.0, 1.0]
    slipped = replace(trial, theta=trial.theta + lost * (at < TIME)[:, None] * shown)
    _, slips = shocks(fitted(recorded([slipped])))
    assert max(slips, key=lambda each: slips[each].gain) == joint
    assert slips[joint].gain > 100.0
    assert slips[joint].time == pytest.approx(4.12)
    assert slips[joint].size == pytest.approx(lost, rel=0.2)
    times = [slips[joint].time, *(time for _, time in slips[joint].elsewhere)]
    assert len(times) == 3
    assert np.diff(sorted(times)).min() > 3.0 * np.diff(TIME).max()


@pytest.mark.parametrize("rod", ["inner", "outer"])
@pytest.mark.parametrize("of_base", [False, True])
def test_an_impulse_is_found_where_it_was_also_where_the_base_is_said_to_move(rod, of_base):
    found = fitted(recorded([measured(pushed(rod), np.random.default_rng(3))]))
    if of_base:
        noise = replace(found.noise, of_base=True)
        found = GaussNewton(found.model, found.values, found.recorded, found.states, noise).run().found()
    impulses, _ = shocks(found)
    assert max(impulses, key=lambda each: impulses[each].gain) == rod
    assert impulses[rod].gain > 40.0
    assert impulses[rod].time == pytest.approx(4.0, abs=0.3 * UNIT)
    assert impulses[rod].size == pytest.approx(PUSH / A22, rel=0.2)


def pushed(rod):
    def push(time, state):
        torque = PUSH * np.exp(-0.5 * ((time - 4.0) / 0.01) ** 2) / (0.01 * np.sqrt(2.0 * np.pi))
        return (torque, 0.0) if rod == "inner" else (0.0, torque)

    return pendulum.motion(TABLE_5, (1.5, 1.2, 0.0, 0.0), TIME, torque=push, tolerance=1e-9)[:, :2]


@pytest.mark.parametrize("joint", [0, 1], ids=["inner", "outer"])
def test_an_error_that_repeats_many_times_a_turn_is_found_with_its_periods(clean, joint):
    """But not as many as a coarse encoder has steps."""
    angles = motion()
    turned = angles[:, joint] - (angles[:, 0] if joint else np.pi)
    error = 2e-4 * np.sin(60.0 * turned + 0.7)
    trial = measured(angles + error[:, None] * ([0.0, 1.0] if joint else [1.0, 1.0]), np.random.default_rng(1))
    found = fitted(recorded([trial]))
    kinds = [known(f"encoder_interpolation.{name}") for name in ("inner", "outer")]
    scored = list(repeated(found, kinds))
    of_joint, other = scored[joint], scored[1 - joint]
    assert of_joint.misfit < other.misfit - 20.0
    sine, cosine, periods = of_joint.values
    assert periods == 60.0
    assert [sine, cosine] == pytest.approx(2e-4 * np.array([np.cos(0.7), np.sin(0.7)]), abs=4e-5)
    assert all(score.misfit > -2.0 for score in repeated(clean, kinds))
    coarse = replace(found, recorded=replace(found.recorded, steps=np.full(2, 2.0 * np.pi / 100)))
    assert all(score.values[2] <= 33.0 for score in repeated(coarse, kinds))

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A name is as sure as the models that hold it are probable, and as what it explains beside what remains."""

from types import SimpleNamespace

import numpy as np
import pytest

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.model.effects.curves import CURVES
from cdp_ident.tracing.certainty import certainties, not_distinguished, probabilities, shown_by
from cdp_ident.tracing.selection import Selection
from scenarios.swings import MODEL, known

DRY, STRIBECK, DRAG = "coulomb_friction.outer", "stribeck_friction.outer", "air_drag.outer.strips"
OFFSET = "encoder_offset.inner"


def model(cost, *keys, torque=(0.0, 0.0)):
    """Return a fitted model of a cost, with effects, in whose joints torques are missing."""
    found = MODEL
    for key in keys:
        found = found.with_effect(ActiveEffect(known(key) if isinstance(key, str) else key))
    torque = np.array(torque)
    return SimpleNamespace(
        model=found,
        cost=cost,
        is_missing=torque > 0.0,
        torque=torque,
        noise=SimpleNamespace(torque_with_tails=torque + 1e-6),
    )


def search(*models):
    """Return a search that ended at the first of some fitted models."""
    return SimpleNamespace(fitted=dict(enumerate(models)), best=models[0], cost=lambda found: found.cost)


def test_the_probability_of_a_name_sums_the_models_that_hold_it():
    found = search(model(0.0, DRY, DRAG), model(0.0, DRY), model(0.0, DRAG), model(0.0))
    assert probabilities(found) == pytest.approx((0.5, 0.5))


def test_a_model_s_weight_falls_by_half_its_cost():
    found = search(model(0.0, DRY), model(2.0 * np.log(9.0)))
    assert probabilities(found) == pytest.approx((0.9,))


def test_a_model_that_was_refused_has_no_weight():
    found = search(model(0.0, DRY), model(-50.0, STRIBECK), model(2.0 * np.log(9.0)))
    assert probabilities(found) == pytest.approx((0.9,))


def test_one_form_of_an_effect_speaks_for_its_name_as_another_does():
    drag = "air_drag.outer.rotation"
    found = search(model(0.0, DRAG), model(0.0, drag), model(0.0))
    assert probabilities(found) == pytest.approx((2.0 / 3.0,))


def test_what_could_be_in_its_place_is_told_and_what_is_far_behind_is_not():
    found = search(model(0.0, DRY, OFFSET), model(5.0, STRIBECK, OFFSET), model(7.0, DRAG, OFFSET))
    assert not_distinguished(found) == ((STRIBECK,), ())


@pytest.mark.parametrize(
    "other", [(DRY,), (STRIBECK,), (STRIBECK, DRAG, OFFSET), (DRY, STRIBECK)], ids=["less", "other", "more", "instead"]
)
def test_a_model_with_more_or_fewer_effects_is_no_rival_in_a_name_s_place(other):
    found = search(model(0.0, DRY, OFFSET), model(1.0, *other))
    of_dry, of_offset = not_distinguished(found)
    assert of_dry == ()
    assert of_offset == ((STRIBECK,) if other == (DRY, STRIBECK) else ())


def test_another_form_of_the_same_effect_and_a_torque_without_a_name_are_no_alternatives():
    found = search(model(0.0, DRAG), model(1.0, "air_drag.outer.rotation"), model(1.0, CURVES[0]))
    assert not_distinguished(found) == ((),)


def test_the_alternatives_come_the_nearest_first():
    found = search(model(0.0, DRY), model(3.0, STRIBECK), model(2.0, DRAG), model(1.0, "joint_spring.outer"))
    assert not_distinguished(found) == (("joint_spring.outer", DRAG, STRIBECK),)


def certainty(probability=1.0, also_possible=(), left=0.0, before=1.0, key=DRY):
    found = search(model(0.0, key, torque=(0.0, left)))
    return certainties(found, [model(99.0, torque=(0.0, before))], [probability], [also_possible])


@pytest.mark.parametrize(
    ("probability", "expected"), [(0.96, "named"), (0.9, "probable"), (0.71, "probable"), (0.5, "acts_like")]
)
def test_a_name_is_as_sure_as_it_is_probable(probability, expected):
    assert certainty(probability) == (expected,)


def test_a_name_for_which_there_are_others_is_probable():
    assert certainty(also_possible=(DRAG,)) == ("probable",)


@pytest.mark.parametrize(
    ("left", "expected"), [(0.9, "acts_like"), (0.75, "acts_like"), (0.6, "named"), (0.0, "named")]
)
def test_an_effect_that_leaves_most_of_the_missing_torque_is_no_name(left, expected):
    """Torques are compared by their mean squares."""
    assert certainty(left=left) == (expected,)


def test_a_model_that_cannot_be_fitted_without_an_effect_is_no_evidence_against_it():
    found = search(model(0.0, DRY, torque=(0.0, 1.0)))
    assert certainties(found, [None], [1.0], [()]) == ("named",)


@pytest.mark.parametrize("left", [0.0, 1.0])
def test_a_torque_without_a_name_has_none(left):
    assert certainty(key=CURVES[0], left=left) == ("acts_like",)


@pytest.mark.parametrize(("harmonics", "expected"), [(3, "named"), (4, "acts_like")])
def test_more_than_a_few_torques_over_one_angle_are_a_torque_without_a_name(harmonics, expected):
    found = search(model(0.0, *[f"cogging_torque.outer.{k + 2} per turn" for k in range(harmonics)]))
    assert certainties(found, [None] * harmonics, [1.0] * harmonics, [()] * harmonics) == (expected,) * harmonics


@pytest.mark.parametrize(("deviations", "expected"), [(3.0, "acts_like"), (3.3, "named")])
def test_a_name_is_not_sure_whose_effect_all_that_was_measured_shows_less_than_the_odds_against_it_ask(
    deviations, expected
):
    after = model(0.0, DRY)
    after.recorded = SimpleNamespace(nodes=100)
    selection = Selection(
        before=model(1.0), after=after, steps=(), without=(None,), probability=(1.0,), also_possible=((),),
        certainty=("named",), scores=(), failures=(), interrupted=False, seconds=1.0,
    )  # fmt: skip
    values = np.zeros(len(after.model.names))
    values[-1] = deviations
    assert shown_by(selection, values, np.eye(len(values))).certainty == (expected,)

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A name is as sure as the models that hold it are probable, and as what it explains beside what remains."""

from types import SimpleNamespace

import numpy as np
import pytest

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.model.effects.curves import CURVES
from cdp_ident.tracing.certainty import certainties, not_distinguished, probabilities, shown_by, where_more_remains
from cdp_ident.tracing.selection import Selection
from scenarios.swings import MODEL, known

DRY, STRIBECK, DRAG = "coulomb_friction.outer", "stribeck_friction.outer", "air_drag.outer.strips"
OFFSET, SPRING = "encoder_offset.inner", "joint_spring.outer"
TWO = ("cogging_torque.inner.2 per turn", "cogging_torque.inner.3 per turn")


def model(cost, *keys):
    """Return a fitted model of a cost, with effects."""
    found = MODEL
    for key in keys:
        found = found.with_effect(ActiveEffect(known(key) if isinstance(key, str) else key))
    # The first effect is shown best.
    values = np.concatenate(
        [np.zeros(len(MODEL.names)), *(np.full(len(a.fitted), 0.5**k) for k, a in enumerate(found.effects))]
    )
    return SimpleNamespace(model=found, values=values, covariance=np.eye(len(values)), cost=cost)


def search(*models):
    """Return a search that ended at the first of some fitted models."""
    return SimpleNamespace(fitted=dict(enumerate(models)), best=models[0], cost=lambda found: found.cost)


@pytest.mark.parametrize(
    ("models", "expected"),
    [
        # Models that hold a name are summed.
        ([(0.0, DRY, DRAG), (0.0, DRY), (0.0, DRAG), (0.0,)], (0.5, 0.5)),
        # A model's weight falls by half its cost.
        ([(0.0, DRY), (2.0 * np.log(9.0),)], (0.9,)),
        # A model that was refused has none.
        ([(0.0, DRY), (-50.0, STRIBECK), (2.0 * np.log(9.0),)], (0.9,)),
        # One form of an effect speaks for its name as another does.
        ([(0.0, DRAG), (0.0, "air_drag.outer.rotation"), (0.0,)], (2.0 / 3.0,)),
        # Of two of a name the second is there only where both are.
        ([(0.0, *TWO), (2.0 * np.log(9.0), TWO[1])], (1.0, 0.9)),
    ],
)
def test_the_probability_of_a_name_is_that_of_the_models_that_hold_it(models, expected):
    assert probabilities(search(*(model(*of) for of in models))) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("models", "expected"),
    [
        # What could be in its place is told, and what is far behind is not.
        ([(0.0, DRY, OFFSET), (5.0, STRIBECK, OFFSET), (7.0, DRAG, OFFSET)], ((STRIBECK,), ())),
        # A model with more or fewer effects is no rival in a name's place.
        *(([(0.0, DRY, OFFSET), (1.0, *other)], ((), ())) for other in ((DRY,), (STRIBECK,), (STRIBECK, DRAG, OFFSET))),
        ([(0.0, DRY, OFFSET), (1.0, DRY, STRIBECK)], ((), (STRIBECK,))),
        # Another form of the same effect and a torque without a name are no alternatives.
        ([(0.0, DRAG), (1.0, "air_drag.outer.rotation"), (1.0, CURVES[0])], ((),)),
        # The alternatives come the nearest first.
        ([(0.0, DRY), (3.0, STRIBECK), (2.0, DRAG), (1.0, SPRING)], ((SPRING, DRAG, STRIBECK),)),
    ],
)
def test_what_could_be_in_a_name_s_place_is_told(models, expected):
    assert not_distinguished(search(*(model(*of) for of in models))) == expected


@pytest.mark.parametrize(
    ("key", "probability", "also_possible", "expected"),
    [
        *(
            (DRY, p, (), sure)
            for p, sure in ((0.96, "named"), (0.9, "probable"), (0.71, "probable"), (0.5, "acts_like"))
        ),
        # There are others in its place.
        (DRY, 1.0, (DRAG,), "probable"),
        # It is a torque without a name.
        (CURVES[0], 1.0, (), "acts_like"),
    ],
)
def test_a_name_is_as_sure_as_it_is_probable(key, probability, also_possible, expected):
    assert certainties(search(model(0.0, key)), [probability], [also_possible]) == (expected,)


@pytest.mark.parametrize(("harmonics", "expected"), [(3, "named"), (4, "acts_like")])
def test_more_than_a_few_torques_over_one_angle_are_a_torque_without_a_name(harmonics, expected):
    found = search(model(0.0, *[f"cogging_torque.outer.{k + 2} per turn" for k in range(harmonics)]))
    assert certainties(found, [1.0] * harmonics, [()] * harmonics) == (expected,) * harmonics


@pytest.mark.parametrize(("deviations", "expected"), [(3.0, "acts_like"), (3.3, "named")])
def test_a_name_is_not_sure_whose_effect_all_that_was_measured_shows_less_than_the_odds_against_it_ask(
    deviations, expected
):
    selection = named()
    values = np.zeros(len(selection.after.model.names))
    values[-1] = deviations
    assert shown_by(selection, values, np.eye(len(values))).certainty == (expected,)


@pytest.mark.parametrize(
    ("without", "noise", "expected"),
    [
        (2.3e-3, 0.0, "probable"),
        (2.2e-3, 0.0, "acts_like"),
        # The encoders' noise is no part of what remains.
        *((without, 8e-4, of) for without, of in ((1.6e-3, "probable"), (1.5e-3, "acts_like"), (9e-4, "acts_like"))),
        # Where it cannot be computed, it is no evidence against the name.
        (np.nan, 0.0, "probable"),
    ],
)
def test_where_more_than_noise_remains_a_name_is_probable_if_little_of_it_is_left_beside_it(without, noise, expected):
    assert where_more_remains(named(), 1e-3, [without], noise).certainty == (expected,)


def named():
    after = model(0.0, DRY)
    after.recorded = SimpleNamespace(nodes=100)
    return Selection(
        before=model(1.0), after=after, steps=(), without=(None,), probability=(1.0,), also_possible=((),),
        certainty=("named",), scores=(), failures=(), interrupted=False, looked_in=1.0,
    )  # fmt: skip

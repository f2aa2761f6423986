"""Effects that an earlier identification of the rig lets expect."""

import numpy as np
import pytest

from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.tracing.expected import ExpectedEffect, begin_with
from cdp_ident.tracing.progress import Progress

NOISE = 5e-4


def expectation(key, *values):
    effect = next(effect for effect in CATALOGUE if effect.key == key)
    return ExpectedEffect(effect, np.array(values), np.full(len(values), 1e-3))


@pytest.mark.parametrize("stiffness", [0.3, 0.5])
def test_what_is_there_is_confirmed_and_fitted_again_and_what_is_not_is_withdrawn(plain, stiffness):
    told = []
    progress = Progress(plain, NOISE, told.append)
    spring, scale = expectation("joint_spring.outer", stiffness, 0.0), expectation("encoder_scale.inner", 2e-3)
    spring = ExpectedEffect(spring.effect, spring.values[: len(spring.effect.parameters)], spring.std)
    begin_with(progress, [scale, spring])
    assert progress.current.model.labels == ("joint_spring.outer",)
    assert progress.current.fit.rmse() < 1.2 * NOISE
    assert "confirmed joint_spring.outer" in told[-1]


def test_where_nothing_of_it_is_there_the_model_stays_as_it_is(plain):
    progress = Progress(plain, NOISE)
    begin_with(progress, [expectation("cogging_torque.inner.3 per turn", 1e-3, 1e-3)])
    assert progress.current is plain


def test_where_nothing_is_expected_nothing_is_tried(plain):
    progress = Progress(plain, NOISE)
    begin_with(progress, [])
    assert progress.current is plain
    assert not progress.steps

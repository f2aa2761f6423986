# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects that an earlier identification of the rig lets expect."""

from types import SimpleNamespace

import numpy as np
import pytest

from cdp_ident.fit.data import prepare
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.fit.roles import PartedTrial
from cdp_ident.fit.scales import scales_of
from cdp_ident.likelihood.maxima import NEAR
from cdp_ident.likelihood.recorded import fitted_recorded
from cdp_ident.tracing.model_search import ModelSearch
from cdp_ident.tracing.select_effects import ExpectedEffect, select_effects, withdrawn_from
from scenarios.paper_rig import A22
from scenarios.swings import fitted, known, measured, motion

NOISE = np.full(2, 3e-4)


@pytest.fixture(scope="module")
def found():
    rng = np.random.default_rng(0)
    trials = [measured(motion(dry=4e-4), rng) for _ in range(2)]
    scales = scales_of(trials, 0.4, 9.81)
    parted = [PartedTrial(trial, frozenset([0] * index), trial) for index, trial in enumerate(trials)]
    data = prepare(parted, 1.0, scales, NOISE)
    whole = fitted(fitted_recorded(data, NEAR, np.inf))
    options = IdentifyOptions(named_effects_only=True)
    return SimpleNamespace(whole=whole, data=data, options=options, enough=np.inf)


def expectation(key, *values):
    return ExpectedEffect(known(key), np.array(values), np.full(len(values), 1e-3))


DRY, SCALE = expectation("coulomb_friction.outer", 0.01), expectation("encoder_scale.inner", 2e-3)


def test_what_is_there_is_confirmed_and_fitted_again_and_what_is_not_is_withdrawn(found):
    told = []
    selection = select_effects(found, told.append, expected=[SCALE, DRY])
    assert selection.after.model.labels == (DRY.effect.key,)
    assert selection.after.values[-1] == pytest.approx(4e-4 / A22, rel=0.1)
    assert "confirmed encoder_scale.inner and coulomb_friction.outer" in told[0]
    assert selection.steps[1].action == "dropped encoder_scale.inner"


def test_a_selection_that_is_stopped_says_so_and_keeps_the_paper_s_model(found):
    selection = select_effects(found, stop=lambda: True, expected=[DRY])
    assert selection.interrupted
    assert selection.after is selection.before
    assert selection.probability == ()
    assert selection.looked_in == pytest.approx(8.0, abs=0.02)


def test_a_numerical_failure_ends_the_search_and_loses_nothing_that_was_found(found, monkeypatch):
    def fails(*_):
        raise np.linalg.LinAlgError("singular")

    monkeypatch.setattr(ModelSearch, "_zeros", fails)
    selection = select_effects(found, expected=[DRY])
    assert selection.after.model.labels == (DRY.effect.key,)
    assert selection.failures == ("the search ended early: singular",)
    assert len(selection.without) == 1
    assert not selection.interrupted


def test_what_is_withdrawn_leaves_the_others_as_sure_and_scores_that_fail_are_told(found, monkeypatch):
    selection = select_effects(found, expected=[DRY])
    without = withdrawn_from(selection, None, found.options)
    assert without.after is selection.before
    assert (without.without, without.probability, without.certainty) == ((), (), ())
    assert without.steps[-1].action == f"withdrawn, as held-out motion is predicted worse: {DRY.effect.key}"
    assert without.scores

    def fails(*_):
        raise np.linalg.LinAlgError("singular")

    monkeypatch.setattr(ModelSearch, "_scores_of", fails)
    failed = withdrawn_from(selection, None, found.options)
    assert failed.after is selection.before
    assert (failed.scores, failed.failures[-1]) == ((), "what other effects would do: singular")

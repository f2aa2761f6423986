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
from cdp_ident.tracing.select_effects import ExpectedEffect, select_effects
from scenarios.swings import TRUE, fitted, known, measured, motion

NOISE = np.full(2, 3e-4)


@pytest.fixture(scope="module", params=[4e-4, 0.0], ids=["rubbing", "clean"])
def identified(request):
    rng = np.random.default_rng(0)
    trials = [measured(motion(dry=request.param), rng) for _ in range(2)]
    scales = scales_of(trials, 0.4, 9.81)
    parted = [PartedTrial(trial, frozenset([0] * index), trial) for index, trial in enumerate(trials)]
    data = prepare(parted, 1.0, scales, NOISE)
    whole = fitted(fitted_recorded(data, NEAR, np.inf))
    options = IdentifyOptions(named_effects_only=True)
    return bool(request.param), SimpleNamespace(whole=whole, data=data, options=options, enough=np.inf)


def expectation(key, *values):
    return ExpectedEffect(known(key), np.array(values), np.full(len(values), 1e-3))


DRY, SCALE = expectation("coulomb_friction.outer", 0.01), expectation("encoder_scale.inner", 2e-3)


def test_what_is_there_is_confirmed_and_fitted_again_and_what_is_not_is_withdrawn(identified):
    rubbing, found = identified
    told = []
    selection = select_effects(found, told.append, expected=[SCALE, DRY])
    if rubbing:
        assert selection.after.model.labels == ("coulomb_friction.outer",)
        assert selection.after.values[-1] == pytest.approx(4e-4 / 0.0652, rel=0.1)
        assert "confirmed encoder_scale.inner and coulomb_friction.outer" in told[0]
        assert selection.steps[1].action == "dropped encoder_scale.inner"
    else:
        assert selection.after.model.labels == ()
        assert not told


def test_where_nothing_is_expected_nothing_is_confirmed(identified):
    rubbing, found = identified
    selection = select_effects(found)
    assert not any(step.action.startswith("confirmed") for step in selection.steps)
    assert bool(selection.after.model.effects) == rubbing


def test_a_balance_of_forces_gives_groups_and_strengths_to_begin_with(identified):
    rubbing, found = identified
    balance = SimpleNamespace(groups=TRUE * 1.05, inertia=None, found=[(DRY.effect, DRY.values)])
    selection = select_effects(SimpleNamespace(**{**vars(found), "balances": (balance,)}))
    assert selection.after.model.labels == ("coulomb_friction.outer",) * rubbing
    if rubbing:
        assert selection.steps[0].action == "added coulomb_friction.outer"
        assert ("coulomb_friction.outer",) in [tried.effects for tried in selection.steps[0].tried]


def test_a_selection_that_is_stopped_says_so_and_keeps_the_paper_s_model(identified):
    _, found = identified
    selection = select_effects(found, stop=lambda: True, expected=[DRY])
    assert selection.interrupted
    assert selection.after is selection.before
    assert selection.probability == ()
    assert selection.looked_in == pytest.approx(8.0, abs=0.02)


def test_a_numerical_failure_ends_the_search_and_loses_nothing_that_was_found(identified, monkeypatch):
    rubbing, found = identified

    def fails(*_):
        raise np.linalg.LinAlgError("singular")

    monkeypatch.setattr(ModelSearch, "_other_maxima", fails)
    selection = select_effects(found, expected=[DRY])
    assert selection.after.model.labels == ("coulomb_friction.outer",) * rubbing
    assert selection.failures == ("the search ended early: singular",)
    assert len(selection.without) == len(selection.after.model.effects)
    assert not selection.interrupted

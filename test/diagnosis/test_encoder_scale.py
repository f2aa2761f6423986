# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where encoders show a factor times the angle, the balance of forces with the lengths known tells the factor."""

from functools import cache

import numpy as np
import pytest

from cdp_ident.diagnosis.encoder_scale import encoder_scale
from cdp_ident.fit.force_balance import Pieces, balances_of
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.fit.prior import Prior
from cdp_ident.pipeline.identify import identify
from cdp_ident.tracing.trace import trace
from cdp_ident.trial.trial import Trial
from reference.truths import truth

SEED = 30001
"""Of a rig of 0.3 m whose outer rod turns over, with noise of 1.2 mrad."""


@cache
def made(kind="none", seed=SEED):
    return truth(kind, seed)


def read_with(inner, outer, of):
    def trial(measured):
        theta1, relative = measured.theta[:, 0], measured.theta[:, 1] - measured.theta[:, 0]
        shown = np.pi + inner * (theta1 - np.pi)
        return Trial(measured.name, measured.time, np.column_stack([shown, shown + outer * relative]))

    return [trial(measured) for measured in of.trials]


def found_in(trials, of):
    pieces = Pieces.of(trials[:2], of.setting.nominal["L"], 9.81)
    return encoder_scale(pieces, balances_of(pieces))


@pytest.mark.parametrize(
    ("inner", "outer", "settings"),
    [
        pytest.param(0.5, 1.0, "trial: {inner_scale: 0.5}", marks=pytest.mark.campaign),
        (2.0, 2.0, "trial: {inner_scale: 2, outer_scale: 2}"),
    ],
)
def test_a_wrong_setting_is_named_as_the_cause_of_the_failure(inner, outer, settings):
    found = found_in(read_with(inner, outer, made()), made())
    assert found.factor == pytest.approx(max((inner, outer), key=lambda f: abs(np.log(f))), rel=2e-3)
    assert settings[:-2] in found.failure
    assert "Check the counts per turn" in found.failure


def test_a_factor_near_one_is_an_effect_with_which_forces_balance():
    found = found_in(read_with(1.0, 1.046, made()), made())
    assert found.failure == ""
    assert found.factor == pytest.approx(1.046, abs=4 * found.std)
    assert found.std < 1e-3
    ((effect, values),) = found.balance.found[:1]
    assert effect.key == "encoder_scale.outer"
    assert values == pytest.approx([0.046], abs=1e-3)


@pytest.mark.parametrize(
    ("kind", "seed"),
    [
        ("none", SEED),
        pytest.param("coulomb_friction.inner+coulomb_friction.outer", 31000, marks=pytest.mark.campaign),
        ("magnet.outer", 31000),
    ],
)
def test_none_is_found_where_readings_are_right_whatever_else_acts(kind, seed):
    of = made(kind, seed)
    assert found_in(read_with(1.0, 1.0, of), of) is None


def test_pieces_with_joints_turned_otherwise_are_what_would_have_been_measured():
    def motion(inner, outer):
        return Pieces.of(read_with(inner, outer, made())[:1], made().setting.nominal["L"], 9.81)

    right, twice = motion(1.0, 1.0), motion(2.0, 2.0)
    mended, three = twice.with_joints_turned(0.5, 0.5), right.with_joints_turned(1.0, 3.0)
    for found, expected in ((mended, right), (three, motion(1.0, 3.0))):
        assert len(found.motions) == len(expected.motions) > 0
        for one, other in zip(found.motions, expected.motions, strict=True):
            assert one.angles == pytest.approx(other.angles, abs=1e-9)
            assert one.rates == pytest.approx(other.rates, abs=1e-6)


@pytest.mark.campaign
def test_an_encoder_off_by_a_twentieth_is_found_though_the_paper_s_model_cannot_follow():
    trials = read_with(1.0, 1.046, made())
    options = IdentifyOptions(prior=Prior(nominal=made().setting.nominal))
    found = trace(identify(trials[:2], trials[2:], options))
    assert [e.active.effect.key for e in found.effects] == ["encoder_scale.outer"]
    assert found.effects[0].parameters[0].shown == pytest.approx(0.046, abs=1e-4)
    assert found.after.holdout.rmse() < 1.2 * made().floor


@pytest.mark.campaign
def test_nothing_is_sought_in_readings_of_half_the_angle():
    trials = read_with(0.5, 1.0, made())
    options = IdentifyOptions(prior=Prior(nominal=made().setting.nominal))
    found = trace(identify(trials[:2], trials[2:], options))
    assert "the inner encoder shows 0.4" in found.failure or "the inner encoder shows 0.5" in found.failure
    assert found.effects == ()

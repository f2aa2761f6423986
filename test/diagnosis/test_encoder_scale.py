"""Where encoders show a factor times the angle, the balance of forces with the lengths known tells the factor."""

from functools import cache

import numpy as np
import pytest

from cdp_ident.diagnosis.encoder_scale import encoder_scale
from cdp_ident.fit.balance_unknowns import DRY, Mechanism
from cdp_ident.fit.force_balance import balance_of_pieces, pieces_of
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
    mechanism = Mechanism(of.setting.nominal["L"], 9.81, of.setting.nominal["L"])
    pieces = pieces_of(trials[:2], mechanism.time_unit)
    return encoder_scale(pieces, mechanism, [balance_of_pieces(pieces, mechanism)])


@pytest.mark.parametrize(
    ("inner", "outer", "settings"),
    [
        pytest.param(0.5, 1.0, "trial.inner_scale: 0.5", marks=pytest.mark.campaign),
        (2.0, 2.0, "trial.inner_scale: 2 and trial.outer_scale: 2"),
    ],
)
def test_a_wrong_setting_is_named_as_the_cause_of_the_failure(inner, outer, settings):
    found = found_in(read_with(inner, outer, made()), made())
    assert found.factor == pytest.approx(max((inner, outer), key=lambda f: abs(np.log(f))), rel=2e-3)
    assert settings[:-1] in found.failure
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


def test_a_piece_with_joints_turned_otherwise_is_what_would_have_been_measured():
    mechanism = Mechanism(made().setting.nominal["L"], 9.81, made().setting.nominal["L"])
    right, twice = (pieces_of(read_with(factor, factor, made())[:1], mechanism.time_unit)[0] for factor in (1.0, 2.0))
    mended = twice.with_joints_turned(0.5, 0.5)
    assert mended.motion.values[0] == pytest.approx(right.motion.values[0], abs=1e-9)
    assert mended.motion.rates[0] == pytest.approx(right.motion.rates[0], abs=1e-7)
    assert mended.motion.noise == pytest.approx(right.motion.noise, rel=1e-6)
    other = right.with_joints_turned(1.0, 3.0)
    assert other.kinematics.joint_angles[0] == pytest.approx(right.kinematics.joint_angles[0])
    assert other.kinematics.joint_angles[1] == pytest.approx(3.0 * right.kinematics.joint_angles[1])
    assert other.kinematics.joint_speeds[1] == pytest.approx(3.0 * right.kinematics.joint_speeds[1])


def test_without_copies_noise_is_not_allowed_for():
    mechanism = Mechanism(made().setting.nominal["L"], 9.81, made().setting.nominal["L"])
    pieces = pieces_of(read_with(1.0, 1.0, made())[:1], mechanism.time_unit)
    alone = balance_of_pieces([piece.without_copies() for piece in pieces], mechanism, effects=DRY, optional=())
    assert alone.noise_share == pytest.approx([0.0, 0.0])
    assert balance_of_pieces(pieces, mechanism).noise_share.min() > 0.0


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

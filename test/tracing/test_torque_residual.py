"""The torque that a model lacks, by inverse dynamics."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.refinement import refine
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.parameters import SYMBOLS, groups_of, inertia_about_cart
from cdp_ident.tracing.torque_residual import torque_residual
from cdp_ident.trial.trial import Trial
from reference.dry_friction import DryFriction
from reference.pendulum import TABLE_5
from reference.sticking import motion

PHYSICAL = np.array([TABLE_5[symbol] for symbol in SYMBOLS])
GROUPS = groups_of(PHYSICAL, TABLE_5["L"])
INERTIA = float(inertia_about_cart(PHYSICAL, TABLE_5["L"]))
TIME = np.arange(1600) / 200.0
TORQUE = 0.1


@pytest.fixture(scope="module")
def stopping():
    """Return the paper's model fitted to a swing that dry friction ends, its values held."""
    friction = DryFriction(TORQUE)
    angles = motion(TABLE_5, (3.9, 4.4, 0.0, 0.0), TIME, friction, friction)[:, :2]
    windows = cut_into_windows([Trial("swing", TIME, angles)], 0.5)
    model = MotionModel(Mechanism(TABLE_5["L"], TABLE_5["g"], TABLE_5["L"], INERTIA))
    return refine(model, GROUPS, windows, hold_values=True)


def test_friction_is_missing_against_the_motion_and_nothing_is_said_of_rods_at_rest(stopping):
    residual = torque_residual(stopping)
    assert residual.time.max() < 5.0 < TIME[-1]
    fast = np.abs(residual.speed[:, 1]) > 1.0
    missing = residual.torque[fast, 1] * np.sign(residual.speed[fast, 1])
    assert np.median(missing) == pytest.approx(-TORQUE / INERTIA, rel=0.05)


def test_where_rods_do_nothing_but_rest_all_samples_are_taken(stopping):
    still = replace(stopping, windows=stopping.windows[-2:], residuals=stopping.residuals[-2:])
    assert torque_residual(still).time.size > 0

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Initial states that went astray are found again."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.initial_states import fit_initial_states
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.parameters import SYMBOLS, groups_of, inertia_about_cart
from cdp_ident.trial.trial import Trial
from reference.dry_friction import DryFriction
from reference.pendulum import TABLE_5
from reference.sticking import motion

PHYSICAL = np.array([TABLE_5[symbol] for symbol in SYMBOLS])
GROUPS = groups_of(PHYSICAL, TABLE_5["L"])
INERTIA = float(inertia_about_cart(PHYSICAL, TABLE_5["L"]))
TIME = np.arange(1600) / 200.0
TORQUE = 0.1
ELSEWHERE = 2.5
"""Change of theta2 [rad] to an angle from which the outer rod falls, and from which it is not found again."""
COUNTS = 2 * np.pi / 8000


@pytest.fixture(scope="module")
def begun():
    """Return a model with dry friction in both joints, its values, and the windows of a swing that ends at rest."""
    friction = DryFriction(TORQUE)
    angles = motion(TABLE_5, (3.9, 4.4, 0.0, 0.0), TIME, friction, friction)[:, :2]
    trial = Trial("swing", TIME, np.round(angles / COUNTS) * COUNTS)
    model, values = MotionModel(Mechanism(TABLE_5["L"], TABLE_5["g"], TABLE_5["L"], INERTIA)), GROUPS
    for joint in ("inner", "outer"):
        effect = next(e for e in CATALOGUE if e.key == f"coulomb_friction.{joint}")
        model, values = model.with_effect(ActiveEffect(effect)), np.append(values, TORQUE / INERTIA)
    return model, values, cut_into_windows([trial], 1.0)


def astray(windows):
    """Return the windows, the last of which begins where its outer rod is not."""
    *others, last = windows
    return [*others, replace(last, start=last.start + np.array([0.0, ELSEWHERE, 0.0, 0.0]))]


def test_a_rod_at_rest_is_found_where_it_is(begun):
    model, values, windows = begun
    assert windows[-1].sample_weights is not None  # it is at rest there
    right = fit_initial_states(model, values, windows)
    assert fit_initial_states(model, values, astray(windows)).rmse() < 1.1 * right.rmse()


def test_a_rod_at_rest_that_was_taken_for_moving_is_found_though_noise_hides_most_of_its_error(begun):
    model, values, quiet = begun
    rng, noise = np.random.default_rng(0), 0.012
    windows = [replace(w, theta=w.theta + rng.normal(0.0, noise, w.theta.shape), sample_weights=None) for w in quiet]
    right = fit_initial_states(model, values, windows)
    *others, last = windows
    moving = replace(last, start=last.start + np.array([0.0, 0.0, 0.3, 0.9]))
    assert fit_initial_states(model, values, [*others, moving]).rmse() < 1.01 * right.rmse()

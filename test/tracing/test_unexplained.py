# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What remains is a torque that is missing, or readings that scatter more than their noise."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from cdp_ident.diagnosis.identification import Inertia
from cdp_ident.likelihood.gauss_newton import GaussNewton
from cdp_ident.likelihood.noise import Noise
from cdp_ident.likelihood.recorded import states_of
from cdp_ident.tracing.unexplained import unexplained
from scenarios.swings import MODEL, NOISE, TRUE, fitted, measured, motion, recorded

OF_ANGLES = NOISE * np.array([1.0, np.sqrt(2.0)])
"""Noise of theta1 and theta2, the sum of both encoders' angles [rad]."""
FRICTION = 4e-4
"""In the outer joint [N m]."""
INERTIA = Inertia(0.06, 0.1, np.zeros(len(TRUE)), False)
"""A22."""


def final(error=1.0, outer=None):
    """Return a model that leaves errors of both angles, over the noise."""
    of = np.array([error, error if outer is None else outer]) * OF_ANGLES

    def rmse(angle=None):
        return float(np.sqrt(np.mean(of**2)) if angle is None else of[angle])

    return SimpleNamespace(fit=SimpleNamespace(rmse=rmse), holdout=SimpleNamespace(rmse=rmse))


def remains(whole, inertia=INERTIA, **of_final):
    return unexplained(final(**of_final), whole, OF_ANGLES, inertia)


def of_its_noise(whole):
    """Return a fit to readings whose noise was known."""
    return replace(whole, recorded=replace(whole.recorded, encoders=np.full(2, NOISE)))


def test_nothing_remains_of_clean_motion(clean):
    found = remains(of_its_noise(clean))
    assert not found.significant
    assert found.description == "nothing but the encoders' noise"
    assert np.all(found.torque == 0.0)
    assert found.times_noise == pytest.approx(1.0)
    assert remains(of_its_noise(clean), error=3.0).times_noise == pytest.approx(3.0)


def test_autocorrelated_noise_is_noise():
    of = recorded([measured(motion(), np.random.default_rng(5), memory=0.8)])
    small = Noise.white(of.encoders, of.least_torque)
    found = remains(of_its_noise(GaussNewton(MODEL, TRUE, of, states_of(of, MODEL), small).run().found()))
    assert not found.significant
    assert found.description.startswith("nothing but the encoders' noise, of which 8")
    assert found.description.endswith(" % is in the next reading still")


@pytest.fixture(scope="module")
def rubbing_twice():
    starts, rng = ((1.5, 1.2), (1.4, 1.9)), np.random.default_rng(0)
    return of_its_noise(fitted(recorded([measured(motion(start, dry=FRICTION), rng) for start in starts])))


def test_a_missing_torque_remains_in_its_joint_with_what_it_goes_with(rubbing_twice):
    found = remains(rubbing_twice, error=3.0)
    assert found.significant
    assert found.joint == "outer"
    assert found.torque[0] == 0.0
    assert found.torque[1] == pytest.approx(FRICTION, rel=0.6)
    assert f"{1e3 * found.torque[1]:.2g} mN m in the outer joint are missing" in found.description
    guessed = remains(rubbing_twice, replace(INERTIA, relative_std=1.0), error=3.0)
    assert f"{found.torque[1] / INERTIA.value:.2g} 1/s² over A22 in the outer joint are missing" in guessed.description
    assert "N m" not in guessed.description
    assert "% of that in the outer joint goes with the outer joint's speed" in found.description


def test_a_short_recording_s_missing_torque_is_in_the_joint_in_which_one_is_missing(rubbing):
    assert remains(of_its_noise(rubbing), error=3.0).joint == "outer"


def test_a_missing_torque_that_moves_nothing_by_more_than_the_noise_is_told_beside_it(rubbing_twice):
    found = remains(rubbing_twice)
    assert not found.significant
    assert found.description == (
        "nothing but the encoders' noise, and torques that matter less than that, "
        f"{1e3 * found.torque[1]:.2g} mN m in the outer joint (root mean square)"
    )


@pytest.mark.parametrize("angle", [0, 1])
def test_an_error_above_the_noise_that_no_torque_explains_remains(clean, angle):
    errors = [1.0, 1.0]
    errors[angle] = 1.5
    found = remains(of_its_noise(clean), error=errors[0], outer=errors[1])
    assert found.significant
    assert found.joint == ("inner", "outer")[angle]
    assert found.description == f"theta{angle + 1} is 1.5 times its noise off, by what no torque would explain"


@pytest.mark.parametrize(("error", "significant"), [(1.1, False), (1.5, True)])
def test_without_whole_swings_the_errors_alone_say_whether_more_than_noise_remains(error, significant):
    found = remains(None, error=1.0, outer=error)
    assert found.significant == significant
    assert found.joint == "outer"
    assert found.description == "what remains could not be examined"

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Readings of joints at rest."""

import numpy as np
import pytest

from cdp_ident.fit.rest import weights_at_rest, weights_of_runs


def test_repeated_readings_of_rods_at_rest_count_as_one_sample_together():
    time = np.arange(100) / 100.0
    theta = np.column_stack([np.sin(time), np.cos(time)])
    assert weights_at_rest(time, theta, 0.1) is None
    theta[40:70] = theta[40]
    theta[80:85] = theta[80]  # too short for a rest
    weight = weights_at_rest(time, theta, 0.1)
    assert weight[40:70] == pytest.approx(np.full((30, 2), 1.0 / 30.0))
    assert np.all(np.delete(weight, np.s_[40:70], axis=0) == 1.0)


@pytest.mark.parametrize(("joint", "of_joint"), [(0, [0.0, 1.0]), (1, [1.0, 1.0])])
@pytest.mark.parametrize("edge", [0.0, 1e-3])
def test_readings_of_one_joint_at_rest_count_as_one_of_its_encoder(joint, of_joint, edge):
    time = np.arange(100) / 100.0
    theta = np.column_stack([np.sin(time), np.cos(time)])
    assert weights_at_rest(time, theta, 0.1, np.full(2, 1e-3)) is None
    theta[40:70] = theta[40] + 0.1 * np.arange(30)[:, None] * of_joint
    theta[45:60:3, joint] += edge  # the reading is on the edge between two
    theta[45:60:3, 1] += edge * (joint == 0)
    weight = weights_at_rest(time, theta, 0.1, np.full(2, 1e-3))
    assert weight[40:70, joint] == pytest.approx(np.full(30, 1.0 / 30.0))
    assert np.all(np.delete(weight[:, joint], np.s_[40:70]) == 1.0)
    assert np.all(weight[:, 1 - joint] == 1.0)
    theta[50:56, joint] += 0.1  # it moves between two short rests
    assert weights_at_rest(time, theta, 0.1, np.full(2, 1e-3)) is None


def test_readings_that_an_encoder_repeats_count_as_one_of_that_encoder():
    inner, outer = np.array([0.1, 0.2, 0.2, 0.2, 0.3]), np.array([0.5, 0.5, 0.6, 0.7, 0.7])
    weight = weights_of_runs(np.column_stack([inner, inner + outer]))
    third = 1.0 / 3.0
    np.testing.assert_allclose(weight[:, 0], [1.0, third, third, third, 1.0])
    np.testing.assert_allclose(weight[:, 1], [0.5, 0.5, 1.0, 0.5, 0.5])

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Noise of encoders that is remembered is told from white noise, and whitened."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import t as student

from cdp_ident.likelihood.noise import Noise
from cdp_ident.likelihood.swing import Linearised, Swing
from cdp_ident.trial.trial import Trial

NODES, N, D = 10, 4, 9


def swing(time):
    (found,) = Swing.of(Trial("still", time, np.zeros((len(time), 2))), 0, 0.005, 0.01 * len(time) / NODES)
    return replace(found, counts=np.ones((len(time), 2)))


def linear(of, residuals, rates=0.0):
    nodes = len(of.node_times)
    return Linearised(
        np.zeros((nodes, N, D)),
        np.zeros((nodes, N)),
        np.zeros((nodes, 2, 2)),
        np.zeros((nodes, 2)),
        np.zeros((len(residuals), 2, D)),
        residuals,
        np.arange(D - N),
        np.zeros((len(residuals), 2)) + rates,
    )


def mixed_noise(rng, samples, kept, of_kept, white):
    """Return noise (samples, 2) of which a part is kept, and a white one, of standard deviations."""
    started = np.concatenate([np.ones((1, 2)), np.full((samples - 1, 2), np.sqrt(1.0 - kept**2))])
    remembered = lfilter([1.0], [1.0, -kept], rng.normal(size=(samples, 2)) * started, axis=0)
    return of_kept * remembered + white * rng.normal(size=(samples, 2))


def times(samples):
    return 0.01 * np.arange(samples)


def remembered(noise):
    of = swing(times(len(noise)))
    return Noise.white(np.full(2, 1e-3), 1.0).remembering([of], [linear(of, noise)])


@pytest.mark.parametrize(("of_kept", "white"), [(1e-3, 0.0), (1e-3, 1e-3), (2e-3, 1e-3)])
def test_how_much_is_kept_and_how_much_is_in_the_next_reading_is_found(of_kept, white):
    found = remembered(mixed_noise(np.random.default_rng(0), 40000, 0.8, of_kept, white))
    np.testing.assert_allclose(found.kept, 0.8, atol=0.03)
    np.testing.assert_allclose(found.memory, 0.8 * of_kept**2 / (of_kept**2 + white**2), atol=0.03)


def test_white_noise_is_not_autocorrelated():
    noises = [mixed_noise(np.random.default_rng(seed), 2000, 0.0, 0.0, 1e-3) for seed in range(20)]
    assert all(remembered(noise).is_white for noise in noises)


@pytest.mark.parametrize("white", [0.0, 1e-3])
def test_whitening_leaves_white_noise_of_size_one(white):
    noise = mixed_noise(np.random.default_rng(1), 40000, 0.8, 2e-3, white)
    of = swing(times(len(noise)))
    found = remembered(noise)
    found = replace(found, new=found.new * np.std(noise, axis=0) / found.encoders)
    whitened = found.whitened(of, linear(of, noise))
    # What is carried from node to node is in the state, which here is as the sweep would find it.
    left = shown(whitened)
    np.testing.assert_allclose(np.std(left, axis=0), 1.0, atol=0.02)
    for lag in range(1, 6):
        assert np.all(np.abs(np.mean(left[lag:] * left[:-lag], axis=0)) < 0.03)


def shown(whitened):
    """Return what readings leave (samples, 2), given that nothing moves and nothing is remembered at the start."""
    state, left = np.zeros(whitened.transitions.shape[1]), whitened.right.copy()
    n = len(state)
    for k in range(len(whitened.transitions)):
        for sample in range(whitened.samples_at[k], whitened.samples_at[k + 1]):
            left[sample] += whitened.rows[sample, :, :n] @ state
        state = whitened.transitions[k, :, :n] @ state + whitened.gaps[k]
    return left


def test_the_size_of_the_noise_is_that_of_its_parts_together():
    found = replace(remembered(mixed_noise(np.random.default_rng(2), 40000, 0.9, 1e-3, 1e-3)), new=np.ones(2))
    noise = mixed_noise(np.random.default_rng(2), 40000, 0.9, 1e-3, 1e-3)
    of = swing(times(len(noise)))
    new = np.std(shown(found.whitened(of, linear(of, noise))), axis=0)
    np.testing.assert_allclose(replace(found, new=new).encoders, np.sqrt(2.0) * 1e-3, rtol=0.03)


def test_noise_is_forgotten_over_a_gap():
    time = times(200)
    time[100:] += 1.0
    noise = Noise(np.full(2, 1e-3), np.full(2, 0.9), np.zeros(2), np.ones(2))
    of = replace(swing(times(200)), time=time)
    errors = np.full((200, 2), 1e-3)
    left = shown(noise.whitened(of, linear(of, errors)))
    usual = 1.0 - 0.9
    np.testing.assert_allclose(left[[50, 150]], usual)
    size = np.sqrt(1.0 - 0.9**2)  # of a reading before which there is nothing
    np.testing.assert_allclose(left[[0, 100]], size)
    steady = noise.logarithm(swing(times(200)), linear(of, errors))
    assert noise.logarithm(of, linear(of, errors)) == pytest.approx(steady - 2.0 * np.log(size**2))


def test_outliers_count_less():
    of, errors = swing(times(200)), np.random.default_rng(3).normal(size=(200, 2)) * 1e-3
    errors[20] = 0.1
    left = Noise.white(np.full(2, 1e-3), 1.0).whitened(of, linear(of, errors)).right
    np.testing.assert_array_less(left[20], 0.3 * 100.0)
    others = np.arange(200) != 20
    np.testing.assert_allclose(left[others], errors[others] / 1e-3)


def test_repeated_readings_that_do_not_count_are_no_part_of_the_likelihood():
    of = swing(times(200))
    counts = np.ones((200, 2))
    counts[50:] = 0.0
    noise, none = Noise.white(np.full(2, 1e-3), 1.0), linear(of, np.zeros((200, 2)))
    assert noise.logarithm(replace(of, counts=counts), none) == pytest.approx(0.25 * noise.logarithm(of, none))


def test_torques_of_a_student_s_distribution_may_be_large_at_a_node_and_are_of_one_size_otherwise():
    of = swing(times(2000))
    impulses = np.zeros((NODES, 2, 2))
    usual = 0.01 * np.sqrt(of.spacing)
    impulses[:, 0] = usual
    impulses[4, 0, 1] = 100.0 * usual
    noise = replace(Noise.white(np.full(2, 1e-3), 0.01), torque=np.array([0.01, 0.01]))
    found = noise.with_tails([impulses], [of], noise.torque, 1e-5)
    (tails,) = found.tails
    assert tails[4, 1] == pytest.approx(50.0, rel=0.01)
    np.testing.assert_allclose(np.delete(tails, 4, axis=0), 1.0)
    assert found.torque_with_tails == pytest.approx([0.01, 0.01 * np.sqrt((tails[:, 1] ** 2).mean())])


def test_that_a_torque_may_be_large_is_as_unlikely_as_its_distribution_says():
    of = swing(times(2000))
    impulses, noise = np.zeros((NODES, 2, 2)), Noise.white(np.full(2, 1e-3), 0.01)
    size = 30.0 * 0.01 * np.sqrt(of.spacing)
    impulses[4, 0, 1] = size
    found = noise.with_tails([impulses], [of], noise.torque, 1e-5)
    tail = found.tails[0][4, 1]
    normal = 2.0 * np.log(tail) + (30.0 / tail) ** 2
    calm = noise.with_tails([np.zeros((NODES, 2, 2))], [of], noise.torque, 1e-5)
    expected = -2.0 * (student.logpdf(30.0, 3.0) - student.logpdf(0.0, 3.0))
    at_rest = 2.0 * np.log(calm.tails[0][4, 1])
    assert normal - at_rest + found.unlikelihood_of_tails - calm.unlikelihood_of_tails == pytest.approx(expected)


def test_least_torques_have_one_size():
    of = swing(times(2000))
    noise = Noise.white(np.full(2, 1e-3), 1e-5)
    found = noise.with_tails([np.ones((NODES, 2, 2))], [of], noise.torque, 1e-5)
    assert np.all(found.tails[0] == 1.0)
    assert found.unlikelihood_of_tails == 0.0


def late(seed, time, size=1e-3, samples=4000):
    """Return a swing and what it is off by, where both encoders are read at times that are off by chance [s]."""
    rng, of = np.random.default_rng(seed), swing(times(samples))
    rates = 8.0 * np.sin(np.outer(of.time, [3.0, 7.0]) + np.arange(2))
    off = rng.normal(scale=time, size=(samples, 1)) * rates + rng.normal(scale=size, size=(samples, 2))
    return of, linear(of, off, rates)


@pytest.mark.parametrize("time", [5e-4, 2e-3])
def test_errors_of_time_are_told_from_the_noise_of_the_encoders(time):
    of, off = late(0, time)
    found = Noise.white(np.std(off.residuals, axis=0), 1.0).with_errors_of_time([of], [off])
    assert found.time == pytest.approx(time, rel=0.05)
    np.testing.assert_allclose(found.new, 1e-3, rtol=0.05)


def test_where_times_are_right_hardly_any_error_of_time_is_found():
    of, off = late(1, 0.0)
    found = Noise.white(np.std(off.residuals, axis=0), 1.0).with_errors_of_time([of], [off])
    assert found.time * 8.0 < 0.3e-3


def test_readings_at_wrong_times_are_white_and_of_size_one_once_whitened():
    of, off = late(2, 2e-3, samples=20000)
    noise = replace(Noise.white(np.full(2, 1e-3), 1.0), time=2e-3)
    left = noise.whitened(of, off).right
    np.testing.assert_allclose(np.cov(left.T), np.eye(2), atol=0.05)


def test_the_likelihood_of_readings_at_wrong_times_is_that_of_their_covariance():
    of, off = late(3, 2e-3, samples=50)
    noise = replace(Noise.white(np.array([1e-3, 2e-3]), 1.0), time=2e-3)
    covariances = [np.diag(noise.new**2) + noise.time**2 * np.outer(rate, rate) for rate in off.rates]
    assert noise.logarithm(of, off) == pytest.approx(sum(np.linalg.slogdet(one)[1] for one in covariances))
    # On average a reading at a wrong time is off by the acceleration.
    means = 0.5 * noise.time**2 * np.gradient(off.rates, of.time, axis=0)
    squares = sum(e @ np.linalg.solve(c, e) for e, c in zip(off.residuals + means, covariances, strict=True))
    assert np.sum(noise.whitened(of, off).right ** 2) == pytest.approx(squares)

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The mapping of clocks against delays of the kinds that serial lines and USB have."""

import math

import numpy as np
import pytest
from scipy.stats import theilslopes

from cdp_ident.rig.device_clock import DeviceClock, median_slope

ROLL_OVER_US = 2**32
EPOCH_NS = 1_760_000_000_000_000_000


def stamps(device_us, arrivals_ns):
    """Return the stamp of each sample as the driver makes it, and where the fit was started anew."""
    clock = DeviceClock()
    result = []
    waiting = []
    restarted = []
    for index, (time_us, arrival) in enumerate(
        zip((device_us % ROLL_OVER_US).tolist(), arrivals_ns.tolist(), strict=True)
    ):
        if clock.is_new_run(time_us, arrival):
            result += [clock.times(time)[0] for time in waiting]
            waiting = []
            clock = DeviceClock()
            restarted.append(index)
        clock.observe(time_us, arrival)
        waiting.append(time_us)
        if clock.ready:
            result += [clock.times(time)[0] for time in waiting]
            waiting = []
    result += [clock.times(time)[0] for time in waiting]
    return np.array(result), restarted


def line(seconds, rate, skew, start_us=0):
    """Return device times [us] and the host's true times [s] of a device whose clock is fast by `skew`."""
    true = np.arange(int(seconds * rate)) / rate
    return start_us + np.round(true * (1 + skew) * 1e6).astype(np.int64), true


def arrive(true, delay):
    """Return arrival times [ns]: a message waits behind those before it."""
    return EPOCH_NS + np.round(np.maximum.accumulate(true + delay) * 1e9).astype(np.int64)


DELAYS = {
    "uniform": lambda generator, true: generator.uniform(0.0, 0.015, len(true)),
    "usb frames of 16 ms": lambda _, true: 0.016 - true % 0.016,
    "mostly late": lambda generator, true: 0.015 * generator.beta(4.0, 1.5, len(true)),
    "bursts": lambda generator, true: generator.exponential(0.001, len(true)) + 0.3 * (true % 7.0 < 0.3),
}


@pytest.mark.parametrize("skew", [0.0, 1e-4, -1e-4])
@pytest.mark.parametrize("rate", [200.0, 1000.0])
@pytest.mark.parametrize("kind", DELAYS)
def test_stamps_keep_the_devices_even_spacing_while_arrivals_jitter(kind, rate, skew):
    device, true = line(40.0, rate, skew, start_us=ROLL_OVER_US - 9_000_000)
    arrivals = arrive(true, DELAYS[kind](np.random.default_rng(1), true))
    result, restarted = stamps(device, arrivals)
    assert restarted == []
    assert len(result) == len(device)
    stretch = np.diff(result) / (np.diff(device) * 1000.0) - 1.0
    error = (result - EPOCH_NS) * 1e-9 - true
    assert np.abs(stretch + skew).max() < 1e-3  # arrivals are off by up to 15 periods
    assert error.min() > -1.5e-3
    assert np.ptp(error[int(10 * rate) :]) < 4e-3


def test_a_backlog_that_is_caught_up_at_first_is_not_taken_for_the_clock():
    device, true = line(20.0, 200.0, 0.0)
    delay = np.maximum(0.4 - 0.35 * true, 0.0) + np.random.default_rng(6).uniform(0.0, 0.01, len(true))
    result, restarted = stamps(device, arrive(true, delay))
    assert restarted == []
    assert np.abs(np.diff(result) / 5e6 - 1.0).max() < 1e-3
    assert np.abs((result - EPOCH_NS) * 1e-9 - true).max() < 4e-3


def test_a_ceramic_resonator_is_followed():
    device, true = line(60.0, 500.0, 4e-3)
    arrivals = arrive(true, np.random.default_rng(2).uniform(0.0, 0.01, len(true)))
    result, _ = stamps(device, arrivals)
    late = slice(15000, None)
    slope = np.polyfit(true[late], (result[late] - EPOCH_NS) * 1e-9, 1)[0]
    assert slope == pytest.approx(1.0, abs=2e-4)


def test_a_silence_restarts_the_fit_and_stamps_go_on_at_the_right_time():
    device, true = line(30.0, 500.0, 5e-5)
    keep = (true < 10.0) | (true > 12.0)
    device, true = device[keep], true[keep]
    arrivals = arrive(true, np.random.default_rng(3).uniform(0.0, 0.015, len(true)))
    result, restarted = stamps(device, arrivals)
    assert restarted == [5000]
    assert len(result) == len(device)
    assert np.abs((result - EPOCH_NS) * 1e-9 - true).max() < 4e-3


@pytest.mark.parametrize("step", [-0.5, 0.5])
def test_a_host_clock_that_is_set_restarts_the_fit(step):
    device, true = line(30.0, 500.0, 0.0)
    true = true + step * (true > 10.0)
    result, restarted = stamps(device, EPOCH_NS + np.round(true * 1e9).astype(np.int64))
    assert len(restarted) == 1
    error = (result - EPOCH_NS) * 1e-9 - true
    assert np.abs(error[:5000]).max() < 1e-3
    assert np.abs(error[10000:]).max() < 1e-3


def test_a_stall_that_is_caught_up_is_only_a_delay():
    device, true = line(20.0, 500.0, 0.0)
    delay = np.where((true > 10.0) & (true < 12.0), 12.0 - true, 0.0)
    result, restarted = stamps(device, arrive(true, delay))
    assert restarted == []
    assert np.abs((result - EPOCH_NS) * 1e-9 - true).max() < 1e-3


def test_nothing_is_stamped_before_anything_was_observed():
    with pytest.raises(ValueError, match="nothing observed"):
        DeviceClock().times(0)


def test_a_simulated_host_clock_that_goes_in_late_steps_gives_even_stamps():
    device, true = line(30.0, 200.0, 0.0)
    generator = np.random.default_rng(4)
    steps = np.floor(true / 0.04) * 0.04 - 0.5 * (generator.random(len(true)) < 0.01)
    clock = DeviceClock(simulated=True)
    result = []
    for time_us, arrival in zip(
        device.tolist(), (EPOCH_NS + np.round(steps * 1e9)).astype(np.int64).tolist(), strict=True
    ):
        assert not clock.is_new_run(time_us, arrival)
        clock.observe(time_us, arrival)
        if clock.ready:
            result.append(clock.times(time_us)[0])
    assert len(result) > 5700
    assert np.all(np.diff(result) == 5_000_000)


@pytest.mark.parametrize("skew", [0.0, 5e-5, -5e-3])
@pytest.mark.parametrize("kind", ["uniform", "bursts"])
def test_the_rate_that_is_told_is_as_good_as_it_says(kind, skew):
    off = []
    for seed in range(20):
        device, true = line(10.0 + seed, 200.0, skew)
        arrivals = arrive(true, DELAYS[kind](np.random.default_rng(seed), true))
        clock = DeviceClock()
        for time_us, arrival in zip(device.tolist(), arrivals.tolist(), strict=True):
            clock.observe(time_us, arrival)
        rate = clock.rate()
        assert rate is not None
        assert 0.0 < rate.std < 1e-3
        off.append((rate.fast - skew) / rate.std)
    assert 0.4 < np.sqrt(np.mean(np.square(off))) < 1.6


def test_no_rate_is_told_before_enough_was_seen_and_none_but_one_of_a_simulated_clock():
    clock, simulated = DeviceClock(), DeviceClock(simulated=True)
    for number in range(800):
        clock.observe(number * 5000, EPOCH_NS + number * 5_000_000)
    assert clock.rate() is None
    assert simulated.rate() == (0.0, 0.0)


def test_the_devices_own_time_counts_roll_overs():
    clock = DeviceClock()
    first = ROLL_OVER_US - 1_000_000
    for number in range(400):
        clock.observe((first + number * 5000) % ROLL_OVER_US, EPOCH_NS + number * 5_000_000)
    assert clock.times((first + 399 * 5000) % ROLL_OVER_US)[1] == (first + 399 * 5000) * 1000


ONE_SIGMA = math.erf(math.sqrt(0.5))
"""Probability of a normal number within one standard deviation."""


@pytest.mark.parametrize("digits", [12, 1, 0])
@pytest.mark.parametrize("count", [2, 6, 59])
def test_slope_and_interval_are_scipy_s_though_values_repeat(count, digits):
    rng = np.random.default_rng(count)
    for _ in range(20):
        x = np.cumsum(rng.uniform(0.5, 1.5, count))
        y = np.round(0.03 * x + rng.exponential(1.0, count), digits)
        expected = theilslopes(y, x, ONE_SIGMA)
        assert median_slope(x, y) == (expected.slope, expected.low_slope, expected.high_slope)


def test_values_that_are_all_equal_have_no_slope():
    assert median_slope(np.arange(6.0), np.ones(6)) == (0.0, 0.0, 0.0)

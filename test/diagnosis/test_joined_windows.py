"""That windows follow one another makes values more exact, and is believed only where the model holds."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from cdp_ident.diagnosis.joined_windows import jumps
from cdp_ident.diagnosis.uncertainty import covariance
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.model.motions import simulate
from cdp_ident.model.parameters import SYMBOLS, groups_of, physical_coefficients
from cdp_ident.pipeline.identify import identify
from cdp_ident.tracing.trace import trace
from cdp_ident.trial.trial import Trial
from reference.pendulum import TABLE_5
from scenarios.twin import TEN_SECONDS, as_measured

TRUTH = groups_of([TABLE_5[symbol] for symbol in SYMBOLS], TABLE_5["L"])
STARTS = ((2.2, 2.0, 0.0, 0.0), (2.4, 4.5, 0.0, 0.0), (2.8, 2.2, 0.0, 0.0))


@cache
def trials(seed):
    rng = np.random.default_rng(seed)
    coefficients = physical_coefficients(TABLE_5)
    return tuple(
        Trial(
            f"trial {number}",
            TEN_SECONDS,
            as_measured(simulate(coefficients, np.array(start), TEN_SECONDS, step=0.001)[:, :2], rng, 1e-3),
        )
        for number, start in enumerate(STARTS)
    )


@cache
def identified(seed=0):
    return identify(trials(seed)[:2], trials(seed)[2:], IdentifyOptions(window=1.5, join_windows=True))


@cache
def traced():
    """What was traced in these, and what was said meanwhile."""
    said = []
    return trace(identified(), said.append), said


def deviations(values, spread):
    return (values[: len(TRUTH)] - TRUTH) / np.sqrt(np.diag(spread))[: len(TRUTH)]


@pytest.mark.parametrize("seeds", [1, pytest.param(4, marks=pytest.mark.campaign)])
def test_intervals_become_narrower_and_hold_the_truth(seeds):
    ratios = []
    for seed in range(seeds):
        fit = identified(seed).fit
        spread = covariance(fit)
        found = jumps(fit, spread)
        assert found.join
        assert np.abs(deviations(found.values, found.covariance)).max() < 4.0
        ratios.append(np.sqrt(np.diag(spread) / np.diag(found.covariance)))
    assert np.min(ratios) >= 1.0 - 1e-9
    assert np.median(ratios) > 1.5


def test_where_the_model_lacks_something_windows_do_not_join():
    fit = identified().fit
    spread = covariance(fit)
    friction = 20.0 * np.sqrt(spread[3, 3])
    wrong = replace(fit, values=fit.values + np.eye(len(fit.values))[3] * friction)
    found = jumps(wrong, spread)
    assert not found.join
    assert found.p_value < 1e-6


def test_windows_that_do_not_follow_one_another_say_nothing():
    fit = identified().fit
    assert jumps(fit.over([0]), covariance(fit)) is None
    assert jumps(fit.over(range(0, len(fit.windows), 2)), covariance(fit)) is None


def test_a_trace_ends_with_the_joined_values_on_request_alone():
    found, (joined, said) = identified(), traced()
    assert joined.joined
    assert any(line.startswith("windows are joined: p = ") for line in said)
    assert joined.after.fit.values == pytest.approx(jumps(found.fit, covariance(found.fit)).values)
    assert np.all(np.diag(joined.covariance) < np.diag(covariance(found.fit)))
    assert joined.after.fit.rmse() == pytest.approx(found.fit.rmse(), rel=0.02)
    apart = trace(replace(found, options=replace(found.options, join_windows=False)))
    assert not apart.joined
    assert apart.after.fit is found.fit


def test_motion_that_is_held_out_has_no_part_in_it():
    *fitted, held_out = trials(0)
    disturbed = replace(held_out, theta=held_out.theta + np.random.default_rng(1).normal(0, 5e-3, held_out.theta.shape))
    joined = trace(identify(fitted, [disturbed], IdentifyOptions(window=1.5, join_windows=True)))
    assert joined.unexplained.significant
    assert joined.joined
    assert np.array_equal(joined.after.fit.values, traced()[0].after.fit.values)

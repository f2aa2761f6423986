# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
import numpy as np
import pytest
import sympy

from cdp_ident.errors import OptionError
from cdp_ident.machine import parallel
from cdp_ident.model.motions import simulate
from cdp_ident.model.parameters import PARAMETERS, coefficients_of, groups_of
from cdp_ident.model.population import Population, Segment, inputs_at_half_steps
from cdp_ident.model.time_grid import TimeGrid
from reference.pendulum import TABLE_3, TIME, cart_acceleration
from scenarios.twin import twin

CART = 0.05 * sympy.sin(5 * TIME)


def members(count, seed=0):
    """Return coefficients (count, 7) of pendulums spread over the default box."""
    lower = [p.nominal * p.lower_factor for p in PARAMETERS]
    upper = [p.nominal * p.upper_factor for p in PARAMETERS]
    physical = np.random.default_rng(seed).uniform(lower, upper, (count, len(PARAMETERS)))
    return coefficients_of(groups_of(physical, 0.4), 0.4, 9.81)


def segment(times, seed=0, cart=None):
    trial = twin(np.random.default_rng(seed), times=times, cart=0 * TIME if cart is None else cart)
    u = None if cart is None else cart_acceleration(cart, times)
    return Segment(np.array(TABLE_3), times, trial.theta, u)


@pytest.fixture(scope="module")
def segments():
    rng = np.random.default_rng(3)
    return [
        segment(np.arange(400) / 200.0),
        segment(np.sort(rng.uniform(0.1, 1.5, 333)), seed=1),
        segment(np.arange(150) / 100.0, seed=2, cart=CART),
    ]


def test_errors_are_those_of_each_simulated_alone(segments):
    def alone(pendulum, each):
        u = inputs_at_half_steps(each, TimeGrid.over(each.time))[:, 0]
        return np.sum((simulate(pendulum, each.start, each.time, u)[:, :2] - each.theta) ** 2)

    pendulums = members(21)
    expected = [[alone(pendulum, each) for each in segments] for pendulum in pendulums]
    # Alone, steps that are too long for a wild pendulum are divided; in lanes side by side they cannot be.
    np.testing.assert_allclose(Population(segments).squared_errors(pendulums), expected, rtol=1e-6)


def test_the_step_is_the_callers():
    each = segment(np.arange(200) / 200.0)
    fine, coarse = (Population([each], step).squared_errors(members(1)) for step in (0.0025, 0.02))
    assert 0 < abs(coarse[0, 0] / fine[0, 0] - 1) < 0.01


def test_the_number_of_cores_changes_nothing(segments, monkeypatch):
    found = []
    for count in (1, 2, 3, 5):
        monkeypatch.setattr(parallel, "core_count", lambda count=count: count)
        found.append(Population(segments).squared_errors(members(100)))
    assert all(np.array_equal(errors, found[0]) for errors in found)


@pytest.mark.parametrize("size", [1, 15, 16, 17, 40])
def test_nobody_else_in_the_population_changes_a_members_error(segments, size):
    pendulums, population = members(size), Population(segments)
    together = population.squared_errors(pendulums)
    assert together.shape == (size, len(segments))
    np.testing.assert_array_equal(population.squared_errors(pendulums[::-1])[::-1], together)
    for member in {0, size // 2, size - 1}:
        np.testing.assert_array_equal(population.squared_errors(pendulums[member : member + 1])[0], together[member])


def test_a_member_that_cannot_move_is_infinitely_wrong_and_leaves_the_others_alone(segments):
    pendulums, population = members(18), Population(segments)
    expected = population.squared_errors(pendulums)
    broken = pendulums.copy()
    broken[4] = np.nan
    broken[11, 6] = 1e300
    errors = population.squared_errors(broken)
    assert np.all(errors[[4, 11]] == np.inf)
    others = np.delete(np.arange(18), [4, 11])
    np.testing.assert_array_equal(errors[others], expected[others])


@pytest.mark.parametrize(
    ("start", "time", "theta", "u"),
    [
        (np.zeros(3), np.arange(5.0), np.zeros((5, 2)), None),
        (np.zeros(4), np.arange(5.0), np.zeros((4, 2)), None),
        (np.zeros(4), np.arange(5.0), np.zeros((5, 3)), None),
        (np.zeros(4), np.arange(5.0), np.zeros((5, 2)), np.zeros(4)),
    ],
    ids=["start", "too few angles", "too many joints", "cart"],
)
def test_a_segment_whose_parts_do_not_fit_is_refused(start, time, theta, u):
    with pytest.raises(OptionError, match="segment"):
        Segment(start, time, theta, u)

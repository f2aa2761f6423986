# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects laid out for compiled code: their states, their directions of derivatives, and which of them act."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.model.acting import NO_EFFECTS, outer_rod_length
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.effects.effect import exclude_each_other
from cdp_ident.model.motions import InitialValueProblem, motions, simulate
from cdp_ident.model.time_grid import TimeGrid
from scenarios.effects import EFFECTS, acting
from scenarios.paper_rig import COEFFICIENTS

START = np.array([2.3, 1.4, 0.5, -1.0])
GRID = TimeGrid.over(np.arange(40) / 100.0)


def derived(effects, start=START):
    return motions([InitialValueProblem(COEFFICIENTS, start, GRID, effects=effects)], derive=True)


def test_a_rod_is_as_long_as_the_other_one_or_twice_as_long_as_to_its_centre():
    assert outer_rod_length(0.4, 0.15) == 0.4
    assert outer_rod_length(0.4, 0.25) == 0.5


@pytest.mark.parametrize("key", EFFECTS)
def test_a_state_has_as_many_numbers_more_as_an_effect_says_and_begins_at_zero(key):
    effect, effects = EFFECTS[key], acting(key)
    assert effects.states == 4 + effect.states
    found = simulate(COEFFICIENTS, START, GRID.place * GRID.step, effects=effects)
    whole = simulate(COEFFICIENTS, np.append(START, [0.0] * effect.states), GRID.place * GRID.step, effects=effects)
    assert found.shape == (40, effects.states)
    np.testing.assert_array_equal(found, whole)


def test_effects_act_the_same_in_any_order_each_on_its_own_states():
    keys = ("presliding_friction.inner", "coulomb_friction.outer", "pivot_compliance.base.oscillating")
    own = dict(zip(keys, ([0.2], [], [1e-3, 0.01]), strict=True))
    starts = (np.concatenate([START, *(own[key] for key in order)]) for order in (keys, keys[::-1]))
    found, turned = (
        derived(acting(*order, fitted=True), start) for order, start in zip((keys, keys[::-1]), starts, strict=True)
    )
    # In the first order presliding's state is number 4, in the second one number 6, and its two parameters are last.
    states = [0, 1, 2, 3, 6, 4, 5]
    directions = [*states, *range(7, 14), 18, 19, 17, 14, 15, 16]
    np.testing.assert_allclose(turned.readings, found.readings, rtol=0, atol=1e-9)
    np.testing.assert_allclose(turned.ends[:, states], found.ends, rtol=0, atol=1e-8)
    np.testing.assert_allclose(turned.ends_by[0][np.ix_(states, directions)], found.ends_by[0], rtol=1e-4, atol=1e-4)


def test_what_is_fitted_are_directions_but_for_what_defines_an_effect():
    effects = acting("cogging_torque.inner.5 per turn", "joint_spring.outer", fitted=True)
    assert effects.parameters == (0, 1, 3, 4)
    assert effects.directions == 4 + 7 + 4
    assert acting("cogging_torque.inner.5 per turn").directions == 4 + 7
    assert effects.without_directions().directions == 4
    few = derived(replace(effects, coefficients=(0, 6), parameters=(4,)))
    np.testing.assert_allclose(few.by, derived(effects).by[..., [0, 1, 2, 3, 4, 10, 14]], rtol=1e-9, atol=1e-12)


def test_some_of_the_effects_are_taken_with_their_values():
    effects = acting("joint_spring.outer", "encoder_scale.inner", "coulomb_friction.inner")
    moving = effects.only(lambda effect: effect.moves)
    assert [(effect.key, values) for effect, values in moving.each()] == [
        ("joint_spring.outer", [0.1, 0.01]),
        ("coulomb_friction.inner", [0.05]),
    ]
    assert moving.directions == 4
    assert list(NO_EFFECTS.each()) == []


def test_there_is_room_for_all_effects_that_may_be_together_and_more_are_refused():
    together = []
    for effect in sorted(CATALOGUE, key=lambda effect: (-effect.states, -len(effect.parameters))):
        if not effect.harmonic and not any(exclude_each_other(effect, other) for other in together):
            together.append(effect)
    plain = [effect.key for effect in together if not effect.curve]
    found = derived(acting(*plain, fitted=True))
    assert found.ends.shape[1] == 4 + sum(effect.states for effect in together)
    assert np.all(np.isfinite(found.by))
    curves = [key for key, effect in EFFECTS.items() if effect.curve]
    assert np.all(np.isfinite(derived(acting(*curves[:2], fitted=True)).by))
    with pytest.raises(ValueError, match="room for"):
        derived(acting(*curves, *plain, fitted=True))

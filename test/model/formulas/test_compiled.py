# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Laws by their addresses: those of the catalogue, and a user's own that were never there before."""

from dataclasses import replace
from itertools import count

import numpy as np
import pytest

from cdp_ident.errors import OptionError
from cdp_ident.model.acting import ActingEffects
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.effects.effect import Effect, EffectParameter, Law, State
from cdp_ident.model.formulas.compiled import motion_law, reading_law
from cdp_ident.model.motions import InitialValueProblem, motions, simulate
from cdp_ident.model.parameters import NOMINAL, physical_coefficients
from cdp_ident.model.time_grid import TimeGrid

EFFECTS = {effect.key: effect for effect in CATALOGUE}
COEFFICIENTS = physical_coefficients(NOMINAL)
NUMBERS = count()
START, TIMES = np.array([-1.0, 0.2, 4.7, 7.9]), np.arange(100) / 200.0


def own(law, *names, joint="outer"):
    parameters = tuple(EffectParameter(name, "1", -10.0, 10.0, 0.1) for name in names)
    return Effect("own_law", joint, "a law of a user", law, parameters, "a user", variant=f"form {next(NUMBERS)}")


def moved(effect, values):
    return simulate(COEFFICIENTS, START, TIMES, effects=ActingEffects.of([(effect, values)], 0.4))


def test_a_law_has_an_address_where_it_does_something():
    assert all((motion_law(effect) != 0) == (effect.moves or effect.states > 0) for effect in CATALOGUE)
    assert all((reading_law(effect) != 0) == (not effect.moves) for effect in CATALOGUE)
    assert motion_law(EFFECTS["joint_spring.inner"]) != motion_law(EFFECTS["joint_spring.outer"])


def test_of_no_strength_only_what_is_known_then_is_another_law():
    for effect in CATALOGUE:
        changes = effect.moves and effect.known_at_zero and not effect.curve
        assert (motion_law(effect, True) != motion_law(effect)) == (changes or effect.name == "backlash")


@pytest.mark.parametrize(
    ("key", "law"),
    [
        ("joint_spring.outer", Law(torque="torque + stiffness*(theta1 - theta2)")),
        ("quadratic_friction.outer", Law(torques=("coefficient*speed^2*sign(speed)", "-coefficient*abs(speed)*speed"))),
        ("coulomb_friction.outer", Law(friction="half + half", where=(("half", "torque/2"),))),
        ("gravity_tilt.base", Law(torques=("a1*g*(sin(theta1 - tilt) - sin(theta1))",
                                           "A23/L*g*(sin(theta2 - tilt) - sin(theta2))"))),
    ],
)  # fmt: skip
def test_a_user_s_law_that_says_the_same_in_other_words_moves_the_rods_the_same(key, law):
    effect = EFFECTS[key]
    values = [parameter.typical for parameter in effect.parameters]
    mine = replace(effect, name="own_law", law=law)
    assert motion_law(mine) != motion_law(effect)
    np.testing.assert_allclose(moved(mine, values), moved(effect, values), rtol=0, atol=1e-9)


OWN = [
    own(Law(torque="-size*slow*exp(-slow^2)", states=(State("slow", "(speed - slow)/width"),), reading="width*slow"),
        "size", "width"),
    own(Law(torques=("mean(size*sin(place*theta1), place)", "size*rate(cos(theta2))"), readings=("width*u", "t*width")),
        "size", "width", joint="base"),
    own(Law(cart="size*(alpha1 + u/2) - width*back", states=(State("back", "u + more"), State("more", "pull"))),
        "size", "width", joint="base"),
    own(Law(reading="size*angle*alpha2 + width*carried", lateness="width/10"), "size", "width", joint="inner"),
]  # fmt: skip


@pytest.mark.parametrize("effect", OWN, ids=lambda effect: effect.formula[:30])
def test_a_user_s_law_has_the_derivatives_of_differences(effect):
    grid = TimeGrid.over(TIMES, 0.001)
    u = np.sin(4.0 * grid.half_step_times())

    def found(point, derive=False):
        values, states = point[-2:], 4 + effect.states
        acting = ActingEffects.of([(effect, values)], 0.4, carried=0.3, fitted=True)
        return motions([InitialValueProblem(point[states:-2], point[:states], grid, u, acting, 1.0)], derive)

    point = np.concatenate([START, np.full(effect.states, 0.02), COEFFICIENTS, [0.3, 0.2]])
    exact = found(point, derive=True)
    for k in range(len(point)):
        step = 1e-5 * max(abs(point[k]), 0.1) * np.eye(len(point))[k]
        ahead, behind = found(point + step), found(point - step)
        for there, here, by in (
            (ahead.readings, behind.readings, exact.by), (ahead.ends, behind.ends, exact.ends_by)
        ):  # fmt: skip
            expected = (there - here) / (2.0 * step[k])
            assert np.abs(by[..., k] - expected).max() < 1e-5 * np.abs(expected).max() + 1e-6, f"direction {k}"


@pytest.mark.parametrize(
    ("law", "message"),
    [
        (
            Law(torque="-size*sped"),
            r"own_law\.outer: torque on theta1: sped is not known.*at character 9: -\(-size\*>>>sped",
        ),
        (Law(torque="-size*bend", states=(State("bend", "sped"),)), r"rate 1: sped is not known"),
        (Law(reading="size*hidden", where=(("hidden", "open(1)"),)), r"the function open is not known"),
    ],
)
def test_a_law_that_is_none_is_refused_when_it_is_compiled(law, message):
    with pytest.raises(OptionError, match=message):
        moved(own(law, "size"), [0.1])

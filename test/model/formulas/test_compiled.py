# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Laws by their addresses: those of the catalogue, and a user's own that were never there before.

Their machine code computes what their Python code does, and is made anew where what was kept of it is damaged.
"""

import ctypes
import inspect
from dataclasses import replace
from itertools import count

import numpy as np
import pytest

from cdp_ident.errors import OptionError
from cdp_ident.machine import compilation
from cdp_ident.model.acting import ActingEffects
from cdp_ident.model.effects.catalogue import CATALOGUE, WRITTEN
from cdp_ident.model.effects.effect import Effect, EffectParameter, Law, State
from cdp_ident.model.formulas.algebra import FUNCTIONS
from cdp_ident.model.formulas.code import text_of
from cdp_ident.model.formulas.compiled import compiled_law, laws_in
from cdp_ident.model.formulas.language import INPUTS, PARAMETERS, ROWS
from cdp_ident.model.motions import InitialValueProblem, motions, simulate
from cdp_ident.model.time_grid import TimeGrid
from scenarios.effects import EFFECTS, acting
from scenarios.paper_rig import COEFFICIENTS

NUMBERS = count()
START, TIMES = np.array([-1.0, 0.2, 4.7, 7.9]), np.arange(100) / 200.0


def own(law, *names, joint="outer"):
    parameters = tuple(EffectParameter(name, "1", -10.0, 10.0, 0.1) for name in names)
    return Effect("own_law", joint, "a law of a user", law, parameters, "a user", variant=f"form {next(NUMBERS)}")


def moved(effect, values):
    return simulate(COEFFICIENTS, START, TIMES, effects=acting((effect, values)))


def test_of_no_strength_only_what_is_known_then_is_another_law():
    assert compiled_law(EFFECTS["joint_spring.inner"]) != compiled_law(EFFECTS["joint_spring.outer"])
    for effect in CATALOGUE:
        changes = effect.known_at_zero and not effect.curve
        assert (compiled_law(effect, True) != compiled_law(effect)) == changes


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
    assert compiled_law(mine) != compiled_law(effect)
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
    ],
)
def test_a_law_that_is_none_is_refused_when_it_is_compiled(law, message):
    with pytest.raises(OptionError, match=message):
        moved(own(law, "size"), [0.1])


LAWS = text_of(WRITTEN)
SCOPE = {**FUNCTIONS, "pi": np.pi}
exec(LAWS, SCOPE)
EVERYTHING = """
def everything(z, p, sums, rows):
    a = z[0]
    rows[0] = sin(a) + cos(a) + tan(a) + atan(a) + tanh(a) + exp(a) + log(a) + sqrt(a) + abs(-a) + pi
    rows[1] = sign(a - 1)
    rows[2] = step(a - 1.0)
    rows[3] = a**2.5 - a/3 - a**3 + a**-2
    rows[4] += -a
    sums[0] += p[0]
"""


def call(address, *arrays):
    numbers = ctypes.POINTER(ctypes.c_double)
    ctypes.CFUNCTYPE(None, *[numbers] * 4)(address)(*(array.ctypes.data_as(numbers) for array in arrays))


def both(function, address, z, p):
    """Return what Python and what machine code leave in sums and rows."""
    found = []
    for run in (function, lambda *arrays: call(address, *arrays)):
        sums, rows = np.full(3 * PARAMETERS, 0.5), np.full(ROWS * (PARAMETERS + 4), 0.25)
        run(z, p, sums, rows)
        found.append(np.concatenate([sums, rows]))
    return found


@pytest.mark.parametrize(
    "name", [name for name, law in SCOPE.items() if inspect.isfunction(law) and name not in FUNCTIONS]
)
def test_every_law_of_the_catalogue_is_the_same_in_machine_code(name):
    rng = np.random.default_rng(1)
    for _ in range(3):
        z, p = rng.normal(size=len(INPUTS)), rng.uniform(0.1, 1.0, 4)
        in_python, in_machine_code = both(SCOPE[name], laws_in(LAWS).of(name), z, p)
        np.testing.assert_allclose(in_machine_code, in_python, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("at", [0.3, 1.0, 2.0])
def test_every_word_of_laws_code_is_known(tmp_path, monkeypatch, at):
    monkeypatch.setattr(compilation, "_CACHE_FOLDER", str(tmp_path))
    scope = {**SCOPE}
    exec(EVERYTHING, scope)
    found = both(scope["everything"], laws_in(EVERYTHING).of("everything"), np.array([at]), np.array([2.0]))
    np.testing.assert_allclose(found[1], found[0], rtol=1e-12)


LAW = "def doubled(z, p, sums, rows):\n    rows[0] = 2.0*p[0]\n"


@pytest.mark.parametrize(
    "damage", [lambda code: b"", lambda code: code[:-20] + b"x" * 20, lambda code: code[: len(code) // 2]],
    ids=["empty", "changed", "cut off"],
)  # fmt: skip
def test_damaged_machine_code_is_made_anew(tmp_path, monkeypatch, damage):
    monkeypatch.setattr(compilation, "_CACHE_FOLDER", str(tmp_path))

    def doubled():
        laws, rows = laws_in(LAW), np.zeros(1)
        call(laws.of("doubled"), rows, np.array([3.0]), rows, rows)
        return rows[0]

    assert doubled() == 6.0
    (file,) = tmp_path.glob("*.o")
    whole = file.read_bytes()
    file.write_bytes(damage(whole))
    assert [doubled(), doubled()] == [6.0, 6.0]
    assert file.read_bytes() == whole

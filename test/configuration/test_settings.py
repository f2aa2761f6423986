# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From names and values to options; config/identify.yaml shows every key as it is."""

import contextlib
import math
import re
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.configuration.parameter_file import read_parameter_file
from cdp_ident.configuration.settings import KEYS, Settings, description_of, is_key, without_results
from cdp_ident.errors import OptionError
from cdp_ident.fit.objective import SHORT_IGA
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.model.weights import Weight
from cdp_ident.search.options import IGA, TGA
from cdp_ident.trial.options import TrialOptions


def test_without_anything_told_all_is_the_library_s_default_and_every_key_has_a_description():
    assert Settings.of({}) == Settings(IdentifyOptions(), TrialOptions())
    assert [key.name for key in KEYS.values() if not key.description] == []


def test_the_values_in_effect_make_the_same_settings_again():
    of_search = {"method": "tga", "search.population": 50}
    settings = Settings.of({"L": 0.3, "known.m1": 0.11, "known_std.m1": 0.001, "trial.zero": "hanging"} | of_search)
    assert Settings.of(settings.values()).values() == settings.values()


def test_weights_are_by_bag_and_rod_and_come_back_as_they_were_given():
    given = {
        "trials.swing.one.added.outer": [0.05, 0.3, 1e-5],
        "trials.swing.one.added_std.outer": [1e-4, 1e-3],
        "trials.swing.one.added.inner": [0.0, 0.0],
    }
    settings = Settings.of(given)
    assert settings.weights == {
        "swing.one": {"inner": None, "outer": Weight("outer", 0.05, 0.3, 1e-5, 1e-4, 1e-3)},
    }
    assert {name: value for name, value in settings.values().items() if name.startswith("trials.")} == given
    assert all(is_key(name) and description_of(name).description.startswith("swing.one: ") for name in given)
    # One of which nothing more is said is known to a percent and a millimetre.
    weight = Settings.of({"trials.two.added.outer": [0.05, 0.3]}).weights["two"]["outer"]
    assert (weight.mass_std, weight.place_std) == pytest.approx((5e-4, 1e-3))


def test_values_arrive_where_they_belong():
    of_prior = {"g": 9.8, "nominal.m1": 0.1, "lower.m1": 0.05, "upper.m1": 0.3}
    settings = Settings.of(of_prior | {"window": 2.0, "seed": 5, "trial.inner_sign": -1})
    prior = settings.identify.prior
    assert (prior.gravity, prior.centre[0], prior.box[0][0], prior.box[1][0]) == (9.8, 0.1, 0.05, 0.3)
    assert (settings.identify.window, settings.identify.seed, settings.trial.inner_sign) == (2.0, 5, -1)


@pytest.mark.parametrize(("method", "base"), [("", SHORT_IGA), ("iga", IGA), ("tga", TGA)])
def test_the_search_is_that_of_the_method_but_for_what_is_told(method, base):
    settings = Settings.of({"method": method, "search.population": 44})
    assert settings.identify.search == replace(base, population=44)


def test_a_whole_number_may_stand_for_a_real_one_and_a_number_in_text_too():
    assert Settings.of({"L": 1}).identify.prior.length == 1.0
    assert (
        Settings.of({"nominal.c2": "1e-5"}).identify.prior.centre[-1] == 1e-5
    )  # YAML reads 1e-5 as text, ROS does not


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"windo": 2.0}, "'windo'; did you mean 'window'"),
        ({"nominal.l": 2.0}, "nominal.l"),
        ({"Nominal.m1": 2.0}, "did you mean 'nominal.m1'"),
        ({"nominal.L": 0.4}, "unknown key"),
        ({"window": "long"}, "window is 'long': expected a number"),
        ({"window": True}, "window is True: expected a number"),
        ({"window": math.nan}, "window is nan: expected a number"),
        ({"window": [2.0]}, "expected a number"),
        ({"window": 10**400}, "expected a number"),
        ({"window": None}, "expected a number"),
        ({"window": -0.1}, "it must be at least 0.001 s, or 0 for what suits the rig"),
        ({"seed": 1.5}, "seed is 1.5: expected a whole number"),
        ({"seed": -1}, "seed is -1; it must be 0 or more"),
        ({"seed": 10**30}, "not believed"),
        ({"seed": 10**400}, "not believed"),
        ({"trial.inner_scale": 1e-308}, "not believed"),
        ({"gravity_std": 1e-308}, "not believed"),
        ({"window": 1e-9}, "at least 0.001 s"),
        ({"named_effects_only": 1}, "expected true or false"),
        ({"trial.topic": 3}, "expected text"),
        ({"method": "sga"}, "expected one of '', 'iga', 'tga'"),
        ({"trial.zero": "down"}, "trial.zero is 'down': expected one of 'upright', 'hanging'"),
        ({"trial.shortest": -1.0}, "trial.shortest is -1.0: expected a positive number"),
        ({"L": 0.0}, "L is 0.0; it must be a positive number"),
        ({"g": math.inf}, "g is inf; it must be a positive number"),
        ({"L": 1e308}, "L is 1e+308: such a number is not believed"),
        ({"nominal.m1": 1e200}, "nominal.m1 is 1e+200: such a number is not believed"),
        ({"nominal.m1": -1.0}, "nominal.m1 is -1.0"),
        ({"lower.m1": 1.0}, "lower.m1 is 1, above upper.m1"),
        ({"known_std.m1": 0.1}, "known.m1 is not"),
        ({"search.population": 2}, "population is 2"),
        ({"trials.two.added.outer": 0.05}, "trials.two.added.outer is 0.05; expected [mass in kg, place in m]"),
        ({"trials.two.added.outer": [0.05]}, "expected [mass in kg, place in m]"),
        ({"trials.two.added.outer": [0.05, -0.3]}, "trials.two.added.outer is -0.3; expected a number"),
        ({"trials.two.added.outer": [math.nan, 0.3]}, "trials.two.added.outer is nan"),
        ({"trials.two.added.outer": ["x", 0.3]}, "is 'x'; expected a number"),
        ({"trials.two.added.inner": [0.05, 0.0]}, "a weight in the joint that does not move adds 0"),
        ({"trials.two.added_std.outer": [0.001, 0.001]}, "trials.two.added.outer is not: give both"),
        ({"trials.two.addd.outer": [0.05, 0.3]}, "expected trials.<bag>.added.<rod>"),
        ({"trials.two.added.middle": [0.05, 0.3]}, "expected trials.<bag>.added.<rod>"),
        ({"search.generations": 5.0}, "expected a whole number"),
    ],
)
def test_what_makes_no_sense_is_refused(values, words):
    with pytest.raises(OptionError) as refusal:
        Settings.of(values)
    assert words in str(refusal.value)


SCALARS = st.one_of(
    st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=5), st.lists(st.floats(), max_size=2)
)


@given(st.dictionaries(st.sampled_from(sorted(KEYS)), SCALARS, max_size=4))
def test_any_values_make_settings_or_a_refusal(values):
    with contextlib.suppress(OptionError):
        assert set(values) <= set(Settings.of(values).values())


def test_what_identify_shows_with_its_result_is_passed_over_in_one_line_and_nothing_else_is():
    fitted = {"m1": 0.1, "groups.A23_over_A22": 0.1, "std.L": 0.0, "determined.m1": True}
    fitted |= {"effects.air_drag.inner.x": 1.0}
    settings = {"L": 0.4, "nominal.m1": 0.1, "trials.one.added.inner": [0.1, 0.2], "windwo": 2.0}
    kept, line = without_results(settings | fitted)
    assert kept == settings
    assert line.startswith("m1, groups.A23_over_A22, std.L …: results")
    assert without_results(settings) == (settings, "")


FILE = Path(__file__).parents[2] / "config/identify.yaml"
TEXT = FILE.read_text()


def test_the_file_changes_nothing():
    assert Settings.of(read_parameter_file(FILE, "identify").taken()).values() == Settings.of({}).values()


def test_it_sets_exactly_the_keys_whose_default_depends_on_nothing():
    depends = ("lower.", "upper.", "known.", "known_std.", "search.")
    fixed = {name for name in KEYS if not name.startswith(depends)}
    assert set(read_parameter_file(FILE, "identify").taken()) == fixed


def test_all_other_keys_are_there_commented_out_with_their_defaults(tmp_path):
    # Taking away the "# " of what is a key or a group of them makes them active.
    active = re.sub(r"(?m)^    # ((?:  )?\w+:(?: [\w.…]+)?(?: +#.*)?)$", r"    \1", TEXT).replace("…", "null")
    (tmp_path / "all.yaml").write_text(active)
    found = read_parameter_file(tmp_path / "all.yaml", "identify").taken()
    assert set(found) == set(KEYS)
    for key in KEYS.values():
        assert found[key.name] == (key.value if not isinstance(key.value, float) else pytest.approx(key.value))


@pytest.mark.parametrize("key", [key for key in KEYS.values() if key.unit], ids=lambda key: key.name)
def test_units_stand_beside_the_keys(key):
    group, _, name = key.name.rpartition(".")
    section = TEXT[TEXT.index(f"{group}:\n") :] if group else TEXT
    line = re.search(rf"(?m)(?:^.*\n)?^[ #]*{name}:.*$", section)
    assert f"[{key.unit}]" in line[0]

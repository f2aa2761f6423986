# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Trials with and without a known weight: A22, torques in N m and frictions with intervals of their own."""

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest
import yaml

from cdp_ident.configuration.fitted_model import fitted_model, fitted_yaml
from cdp_ident.configuration.settings import Settings
from cdp_ident.diagnosis.warnings import find_warnings
from cdp_ident.errors import IdentificationError, OptionError, TrialError
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.model.parameters import SYMBOLS
from cdp_ident.model.weights import Weight
from cdp_ident.output_folder import json_text
from cdp_ident.pipeline.identify import identify
from cdp_ident.pipeline.job import load
from cdp_ident.report.outcome import Job
from cdp_ident.report.schema import problem
from cdp_ident.report.wording import weights_words
from scenarios.clean_bags import write_clean_bags
from scenarios.paper_rig import GROUPS, PHYSICAL
from scenarios.weighted import FRICTION, INERTIA, WEIGHT, plain_and_weighted

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def weighted():
    return identify(plain_and_weighted(np.random.default_rng(3)), [], IdentifyOptions())


def test_two_swings_of_ten_seconds_with_and_without_50_g_give_the_inertia_within_1_percent(weighted):
    assert weighted.fit.model.names[5:7] == ("L", "one_over_A22")
    assert weighted.inertia.shown
    assert weighted.inertia.value == pytest.approx(INERTIA, rel=0.01)
    assert abs(weighted.inertia.value - INERTIA) < 3.0 * weighted.inertia.std < 0.01 * INERTIA


def test_frictions_are_determined_and_what_shares_the_rest_is_not(weighted):
    determined = [symbol for symbol, sure in zip(SYMBOLS, weighted.physical.determined, strict=True) if sure]
    assert determined == ["c1", "c2"]
    errors = np.abs(weighted.physical.values - PHYSICAL) / weighted.physical.std
    assert np.all(errors[-2:] < 4.0)


def test_trials_with_different_weights_agree(weighted):
    assert weighted.repeatability.agree
    assert "one_over_A22" not in weighted.repeatability.names
    alone = np.abs(weighted.repeatability.values[:, :5] - GROUPS) / weighted.repeatability.std[:, :5]
    assert np.all(alone < 4.0)


@pytest.mark.parametrize(
    ("place", "name", "words"),
    [
        (0.302, "weight_off", "the weight on the outer rod in two is at 0.30"),
        (0.31, "trials_disagree", "Are the weights where they are said to be"),
    ],
)
def test_a_weight_that_is_not_where_it_was_said_to_be_is_told(place, name, words):
    trials = plain_and_weighted(np.random.default_rng(3), replace(WEIGHT, place=place), WEIGHT)
    (warning,) = [one for one in find_warnings(identify(trials, [], IdentifyOptions())) if one.name == name]
    assert warning.about[-1] == "two"
    assert words in warning.message


def test_a_trial_whose_weight_is_not_told_disagrees():
    plain, other = plain_and_weighted(np.random.default_rng(3))
    found = identify([plain, replace(other, weights=())], [], IdentifyOptions())
    assert not found.inertia.shown
    assert not found.repeatability.agree


def coverage(seeds, weight):
    """Return how often intervals held the truth where the weight was off as its standard deviations say."""
    held = []
    for seed in range(seeds):
        rng = np.random.default_rng(1000 + seed)
        mass, place = (rng.normal(weight.mass, weight.mass_std), rng.normal(weight.place, weight.place_std))
        trials = plain_and_weighted(rng, weight, replace(weight, mass=mass, place=place))
        found = identify(trials, [], IdentifyOptions(seed=seed))
        errors = np.append((found.fit.values[:5] - GROUPS) / np.sqrt(np.diag(found.covariance)[:5]), [
            (found.inertia.value - INERTIA) / found.inertia.std,
            *((found.physical.values - PHYSICAL) / found.physical.std)[-2:],
        ])  # fmt: skip
        held.append(np.abs(errors) < 1.96)
    return np.mean(held, axis=0)


@pytest.mark.campaign
@pytest.mark.parametrize(
    "weight",
    [
        WEIGHT,
        replace(WEIGHT, mass_std=5e-4, place_std=1e-3),
        Weight("inner", 0.1, 0.3, 1e-5, mass_std=1e-3, place_std=1e-3),
    ],
    ids=["weighed well", "weighed badly", "on the inner rod"],
)
def test_intervals_hold_the_truth_as_often_as_they_say(weight):
    held = coverage(24, weight)
    assert np.all(held >= 0.8), held
    assert np.mean(held) >= 0.9, held


def test_an_effect_beside_it_has_its_strength_in_N_m(weighted_content):  # noqa: N802 - a unit
    (effect,) = weighted_content["effects"]
    assert (effect["name"], effect["joint"]) == ("coulomb_friction", "outer")
    torque = effect["parameters"]["torque"]
    assert torque["value"] == pytest.approx(FRICTION, rel=0.03)
    assert abs(torque["value"] - FRICTION) < 3.0 * torque["std"] < 0.1 * FRICTION


def test_the_report_says_what_the_weight_determines(weighted_content):
    assert problem(json.loads(json_text(weighted_content))) == ""
    inertia = weighted_content["after"]["physical"]["A22"]
    assert inertia["determined"]
    assert inertia["value"] == pytest.approx(INERTIA, rel=0.01)
    assert weighted_content["after"]["physical"]["c1"]["determined"]
    (sentence,) = [words for words in weighted_content["identifiability"]["words"] if words.startswith("A22 =")]
    assert "kg m^2, determined by the weight in two" in sentence
    first, second = weighted_content["trials"]
    assert first["weights"] == []
    assert weights_words(second) == "0.050000 ± 0.000010 kg at 0.30000 ± 0.00010 m on the outer rod"


def test_the_fitted_model_carries_it(weighted_content):
    values = yaml.safe_load(fitted_yaml(weighted_content))["/**"]["ros__parameters"]
    assert values["determined.A22"]
    assert values["std.A22"] < 0.01 * values["A22"]
    model = fitted_model(values, "fitted.yaml")
    assert model.motion.mechanism.inertia == values["A22"]
    (active,) = model.motion.effects
    (torque,) = model.values[model.motion.places(0)]
    assert torque * values["A22"] == pytest.approx(values[f"effects.{active.effect.key}.torque"])


def test_a_weight_that_all_trials_have_shows_nothing():
    plain, other = plain_and_weighted(np.random.default_rng(3))
    for fit, holdout in (([other], []), ([other, replace(other, name="three")], []), ([plain], [other])):
        with pytest.raises(IdentificationError, match="a weight shows A22 only beside a trial"):
            identify(fit, holdout, IdentifyOptions())


@pytest.fixture(scope="module")
def bags(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bags")
    write_clean_bags(folder, swing=6.0)
    return folder


def job(bags, **values):
    return Job((bags / "swing_wide", bags / "swing_folded"), (), Settings.of(values))


def weights(loaded):
    return {trial.name: trial.weights for trial in loaded.fit}


@pytest.fixture
def recorded(bags, tmp_path):
    """Return a function that gives the second bag other custom data, and returns the folder of both."""

    def folder_with(**custom):
        shutil.copytree(bags, tmp_path, dirs_exist_ok=True)
        path = tmp_path / "swing_folded/metadata.yaml"
        content = yaml.safe_load(path.read_text())
        content["rosbag2_bagfile_information"]["custom_data"] = custom
        path.write_text(yaml.safe_dump(content))
        return tmp_path

    return folder_with


def test_a_weight_is_told_by_the_configuration(bags):
    loaded = load(job(bags, **{"trials.swing_folded.added.outer": [0.05, 0.3]}))
    assert weights(loaded) == {
        "swing_wide": (),
        "swing_folded": (Weight("outer", 0.05, 0.3, mass_std=5e-4, place_std=1e-3),),
    }


def test_a_weight_is_told_by_the_bag_and_the_configuration_wins(recorded):
    folder = recorded(added=json.dumps({"added.outer": [0.05, 0.3], "added.inner": [0.08, 0.2]}))
    inner, outer = weights(load(job(folder)))["swing_folded"]
    assert (inner.rod, inner.mass, outer.rod, outer.mass) == ("inner", 0.08, "outer", 0.05)
    values = {"trials.swing_folded.added.outer": [0.1, 0.2, 1e-5], "trials.swing_folded.added_std.outer": [1e-4, 1e-3]}
    inner, outer = weights(load(job(folder, **values)))["swing_folded"]
    assert inner.mass == 0.08
    assert outer == Weight("outer", 0.1, 0.2, 1e-5, 1e-4, 1e-3)
    assert weights(load(job(folder, **{"trials.swing_folded.added.outer": [0, 0]})))["swing_folded"] == (inner,)


def test_a_single_file_of_a_bag_has_the_weight_of_its_bag(recorded):
    folder = recorded(added=json.dumps({"added.outer": [0.05, 0.3]}))
    (file,) = (folder / "swing_folded").glob("*.mcap")
    assert load(Job((file,), (), Settings.of({}))).fit[0].weights[0].mass == 0.05


def test_where_the_recorder_was_killed_the_weight_is_not_known_and_that_is_told(recorded):
    notes = load(job(recorded(salvaged="yes"))).fit[1].notes
    assert any("whether weights were on the rods is not known" in note for note in notes)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("heavy", "is not JSON"),
        ("[1]", "must name weights by rod"),
        ('{"added.middle": [1, 2]}', "did you mean"),
        ('{"added.outer": 5}', "expected \\[mass in kg"),  # what else is none is in test_settings.py
    ],
)
def test_what_a_bag_says_is_checked(recorded, text, words):
    with pytest.raises(TrialError, match=words):
        load(job(recorded(added=text)))


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"trials.swing_folden.added.outer": [0.05, 0.3]}, "did you mean 'swing_folded'"),
        ({"trials.swing_folded.added.outer": [0.05, 30.0]}, "30 m is far beyond the rod of 0.4 m"),
        ({"trials.swing_folded.added.inner": [50.0, 0.3]}, "50 kg is far heavier than the pendulum of 0.424 kg"),
    ],
)
def test_a_weight_of_no_bag_or_off_its_rod_is_refused(bags, values, words):
    with pytest.raises(OptionError, match=words):
        load(job(bags, **values))


def test_a_bag_that_is_still_to_come_may_have_a_weight(bags):
    load(job(bags, **{"trials.tomorrow.added.outer": [0.05, 0.3]}), more_to_come=True)

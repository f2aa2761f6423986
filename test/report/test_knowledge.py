# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is known of a rig, read again from a report's folder, what that lets expect, and what has changed since."""

from dataclasses import asdict, replace

import numpy as np
import pytest

from cdp_ident.design.discrimination import RecordedMotion
from cdp_ident.design.knowledge import NEW, Knowledge
from cdp_ident.errors import CdpIdentError, ReportError
from cdp_ident.report.knowledge import compared, expected_effects, knowledge_of, recorded_motion
from cdp_ident.report.next_trial import next_trial_section
from cdp_ident.report.schema import REPORT, filled
from cdp_ident.report.selection import expected_in_words
from scenarios.weighted import WEIGHT


def known_after(outcome):
    """Return what an identification knew."""
    trace = outcome.trace
    last = trace.completed
    return Knowledge.of(last.whole, last.fit.values, trace.covariance, last.inertia.value)


def test_a_report_read_from_its_file_knows_what_the_identification_knew(outcome, read_content):
    direct, again = known_after(outcome), knowledge_of(read_content)
    assert_the_same(again, direct)
    for name in ("new", "kept", "mixed", "torque"):
        assert getattr(again.noise, name) == pytest.approx(getattr(direct.noise, name))
    assert asdict(again.sampling) == {k: pytest.approx(v) for k, v in asdict(direct.sampling).items()}


def assert_the_same(again, direct):
    assert again.model.names == direct.model.names
    assert again.values == pytest.approx(direct.values, rel=1e-9)
    assert again.rows.T @ again.rows == pytest.approx(direct.rows.T @ direct.rows, rel=1e-4)
    infinite = np.isinf(np.diag(direct.covariance))
    assert np.array_equal(np.isinf(np.diag(again.covariance)), infinite)


def test_what_weights_have_shown_is_read_too(weighted_outcome, weighted_content):
    assert_the_same(knowledge_of(weighted_content), known_after(weighted_outcome))
    mass, place = weighted_content["after"]["weight_errors"]
    assert (mass["of"], mass["rod"], mass["given"]) == ("mass", None, WEIGHT.mass)
    assert (place["of"], place["rod"], place["given"]) == ("place", "outer", WEIGHT.place)
    assert abs(place["value"]) < 4
    assert 0 < place["std"] <= 1.01
    advice = weighted_content["next_trial"]["advice"][-1]
    assert (advice["for"], advice["names"]) == ("A22", ["A22"])
    assert advice["std_now"] == pytest.approx([weighted_content["after"]["physical"]["A22"]["std"]])
    assert advice["std_then"][0] < advice["std_now"][0]


def test_the_motion_of_the_fitted_model_is_read_from_the_curves(outcome, read_content, shown_curves):
    knowledge = knowledge_of(read_content)
    found = recorded_motion(read_content, shown_curves, knowledge)
    direct = RecordedMotion.of(knowledge, outcome.identification.data.trials)
    assert (found.share, found.averaged) == pytest.approx((direct.share, direct.averaged))
    for states, of_direct in zip(found.states, direct.states, strict=True):
        assert states[:, :2] == pytest.approx(of_direct[:, :2], abs=5e-3)


def test_a_report_of_a_fit_that_failed_knows_nothing(read_content):
    read_content["next_trial"] = None
    assert knowledge_of(read_content) is None


def test_errors_of_time_and_a_base_that_moves_are_assumed_of_the_next_trial(outcome, read_content):
    trace, whole = outcome.trace, outcome.trace.completed.whole
    noise = replace(whole.noise, time=1e-3, of_base=True)
    found = replace(whole, noise=noise, is_missing=np.array([True, False]))
    told = replace(outcome, trace=replace(trace, completed=replace(trace.completed, whole=found)))
    read_content["next_trial"] = next_trial_section(told, failed=pytest.fail)
    noise = knowledge_of(read_content).noise
    assert (noise.time, noise.of_base) == (1e-3, True)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("time_noise_s", -1e-3),
        ("interval_s", 0.0),
        ("interval_s", 1e-300),
        ("spacing_s", 1e-300),
        ("new_noise_rad", {"inner": -1.0, "outer": 1e-3}),
        ("noise_kept", {"inner": 0.0, "outer": 1.0}),
        ("duration_s", 1e300),
    ],
)
def test_a_trial_without_end_is_refused(read_content, key, value):
    read_content["next_trial"]["assumed"][key] = value
    with pytest.raises(ReportError, match="identify again"):
        knowledge_of(read_content)


def test_values_that_no_mechanism_has_are_refused(read_content):
    read_content["after"]["groups"]["A33_over_A22"]["value"] = 0.0
    with pytest.raises(CdpIdentError):
        knowledge_of(read_content)


def test_a_value_that_is_not_seen_has_no_bounds(read_content):
    read_content["after"]["groups"]["c2_over_A22"]["std"] = np.inf
    assert np.isinf(knowledge_of(read_content).covariance[4, 4])


def test_a_trial_has_zeros_of_its_own_where_those_before_had(read_content):
    correlation = read_content["after"]["correlation"]
    correlation["names"] += ["zero.inner.trial_1", "zero.outer.trial_1"]
    size = len(correlation["names"])
    correlation["matrix"] = np.eye(size).tolist()
    assert knowledge_of(read_content).model.zeros == (NEW,)


def test_the_effects_of_a_report_are_expected_with_the_values_that_motion_showed(content, outcome):
    (expected,) = expected_effects(content)
    assert expected.effect.key == "coulomb_friction.outer"
    place = outcome.trace.after.model.places(0)
    assert expected.values == outcome.trace.completed.fit.values[place]
    assert np.all(expected.std > 0)


def test_what_happened_once_and_what_has_no_name_is_not_expected_again(content):
    (effect,) = content["effects"]
    once, nameless = effect | {"name": "impulse"}, effect | {"name": "unknown_torque", "variant": "over_angle"}
    assert expected_effects(content | {"effects": [once, nameless]}) == ()


def test_each_is_said_to_be_confirmed_withdrawn_or_new(content, outcome):
    (known,) = expected_effects(content)
    off = replace(known, values=known.values + 3 * np.sqrt(2) * known.std)
    (confirmed,) = filled(REPORT["properties"]["expected"], compared([off], outcome.trace.effects))
    assert confirmed["state"] == "confirmed"
    assert round(confirmed["parameters"]["torque"]["deviations"], 3) == 3.0
    assert [section.values["state"] for section in compared([known], ())] == ["withdrawn"]
    assert [section.values["state"] for section in compared([], outcome.trace.effects)] == ["new"]
    words = list(expected_in_words({"expected": [confirmed]}))
    assert words[0].startswith("coulomb friction, outer is confirmed: torque 0.0")
    assert words[0].endswith("(3.0 std), torques over A22")

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""report.json holds what its readers expect."""

import copy
import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cdp_ident.bag.device_messages import ClockRate
from cdp_ident.configuration.settings import Settings
from cdp_ident.diagnosis.warnings import find_warnings
from cdp_ident.output_folder import json_text
from cdp_ident.pipeline.job import load, run
from cdp_ident.report.contents import report
from cdp_ident.report.outcome import Job
from cdp_ident.report.schema import problem

TRUE_GROUPS = {"A23_over_A22": 0.13128, "A33_over_A22": 0.082410, "a1_over_A22": 2.68854, "c1_over_A22": 0.08241}
"""Of the example bags' rig (bags/README.md)."""


def test_a_device_s_clock_is_stated_with_its_deviation(outcome):
    first, *others = outcome.loaded.fit
    timed = (replace(first, clock=ClockRate(3e-6, 2e-6)), *others)
    content = json.loads(json_text(report(replace(outcome, loaded=replace(outcome.loaded, fit=timed)))))
    assert content["trials"][0]["clock"] == {"fast": 3e-6, "std": 2e-6}
    assert not problem(content)


def test_an_effect_comes_with_its_evidence_and_its_parameters_with_units(content):
    for effect in content["effects"]:
        assert effect["joint"] in ("inner", "outer", "base")
        assert effect["evidence"]["rmse_holdout_after_rad"] < effect["evidence"]["rmse_holdout_before_rad"]
        assert effect["evidence"]["log10_odds"] > 3
        assert 0.95 < effect["evidence"]["probability"] <= 1
        assert all(quantity["unit"] and quantity["std"] >= 0 for quantity in effect["parameters"].values())
    added = [step["action"] for step in content["selection"]["steps"] if step["action"].startswith("added")]
    assert len(added) >= len(content["effects"])


def test_every_other_effect_has_odds_and_the_probability_that_they_mean(content):
    candidates = content["selection"]["candidates"]
    odds = [candidate["log10_odds"] for candidate in candidates]
    assert odds == sorted(odds, reverse=True)
    assert max(odds) < 0
    for candidate in candidates:
        assert candidate["probability"] == pytest.approx(1 / (1 + 10 ** -candidate["log10_odds"]))
    keys = [candidate["effect"] for candidate in candidates]
    assert "air_drag.outer.strips" in keys
    assert "coulomb_friction.outer" not in keys


def test_steps_have_the_odds_of_what_was_tried(content):
    first, *later = content["selection"]["steps"]
    best = max(first["tried"], key=lambda tried: tried["log10_odds"])
    assert best["effects"] == ["coulomb_friction.outer"]
    assert first["log10_odds"] == pytest.approx(best["log10_odds"])
    assert all(tried["log10_odds"] < 0 for step in later for tried in step["tried"])
    assert content["selection"]["looked_in_s"] == pytest.approx(24, abs=1)


def test_where_effects_were_not_looked_for_the_report_says_nothing_of_any(outcome):
    found = outcome.identification
    trace = replace(outcome.trace, selection=None, effects=(), in_doubt=(), completed=found, after=outcome.trace.before)
    content = report(replace(outcome, trace=trace))
    assert content["selection"] == {"interrupted": False, "looked_in_s": 0.0, "steps": [], "candidates": []}
    assert problem(json.loads(json_text(content))) == ""


def test_the_true_groups_are_in_their_intervals(content):
    for symbol, truth in TRUE_GROUPS.items():
        quantity = content["after"]["groups"][symbol]
        assert quantity["value"] == pytest.approx(truth, rel=1e-3)
        assert quantity["determined"]


def test_the_error_falls_from_stage_to_stage_and_before_is_the_last(content):
    errors = [stage["fit"]["rmse_rad"] for stage in content["stages"].values()]
    assert errors == sorted(errors, reverse=True)
    held_out = [stage["holdout"]["rmse_rad"] for stage in content["stages"].values()]
    assert held_out[-1] == min(held_out)
    assert content["before"]["error"] == content["stages"]["refined"]
    after = content["after"]["error"]["holdout"]["rmse_rad"]
    assert after < 1.2 * max(content["noise_rad"].values()) < errors[-1]
    assert f"{1e3 * after:.3g} mrad" in content["verdict"]
    assert not content["unexplained"]["significant"]


def test_the_search_s_history_is_that_of_the_search(content):
    search = content["search"]
    assert len(search["history"]) == search["generations"] + 1
    assert search["history"][-1] == search["sse"]
    assert search["cut_short"]


def job_in(content):
    options = json.loads(json_text(content["run"]["options"]))
    options["trial.stop"] = math.inf  # which JSON cannot say: null there
    bags = [Path(bag) for bag in content["run"]["bag_sha256"]]
    return Job(tuple(bags[:2]), tuple(bags[2:]), Settings.of(options))


def test_what_was_asked_for_stands_in_the_report(content, outcome):
    job, asked = job_in(content), outcome.loaded.job
    assert (job.bags, job.holdout, job.settings.values()) == (asked.bags, asked.holdout, asked.settings.values())


@pytest.mark.campaign
def test_a_run_can_be_repeated_from_its_report(content):
    again = report(run(load(job_in(content)), lambda progress: None))
    # As text, since numbers that are none differ from themselves.
    assert json_text(without_times(again)) == json_text(without_times(content))


def without_times(content):
    content = copy.deepcopy(content)
    del content["search"]["seconds"], content["run"]["seconds"], content["run"]["written_at"]
    return content


def test_the_bags_are_named_by_their_contents(content):
    sums = content["run"]["bag_sha256"]
    assert len(sums) == 3
    assert all(len(digest) == 64 for files in sums.values() for digest in files.values())


def test_it_is_strict_json_even_where_a_number_is_not_finite(outcome):
    trace = outcome.trace
    nominal = trace.errors["nominal"]
    nominal = replace(
        nominal,
        fit=replace(nominal.fit, sse_free_run=math.inf),
        holdout=replace(nominal.holdout, sse_free_run=math.nan),
    )
    covariance = outcome.identification.covariance.copy()
    covariance[0, 0] = np.inf
    identification = replace(outcome.identification, covariance=covariance)
    trace = replace(trace, errors={**trace.errors, "nominal": nominal})
    content = report(replace(outcome, identification=identification, trace=trace))

    def refuse(constant):
        raise AssertionError(constant)

    read = json.loads(json_text(content), parse_constant=refuse)
    assert read["stages"]["nominal"]["fit"]["sse_free_run"] is None
    assert read["stages"]["nominal"]["holdout"]["sse_free_run"] is None
    assert read["before"]["groups"]["A23_over_A22"] == {
        "value": pytest.approx(0.13128, rel=0.01),
        "std": None,
        "unit": "1",
        "determined": False,
    }


def test_each_trial_s_own_estimate_stands_beside_the_joint_one(content):
    trials = content["repeatability"]["trials"]
    assert [trial["trial"] for trial in trials] == ["swing_wide", "swing_folded"]
    assert content["repeatability"]["agree"]
    joint = content["after"]["groups"]["a1_over_A22"]["value"]
    assert all(trial["groups"]["a1_over_A22"]["value"] == pytest.approx(joint, rel=0.02) for trial in trials)


def test_warnings_speak_of_the_model_with_its_effects(outcome, content):
    assert "error_above_noise" in [warning.name for warning in find_warnings(outcome.identification)]
    assert "error_above_noise" not in [warning["name"] for warning in content["warnings"]]

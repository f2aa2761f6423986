"""What a report says of a next trial, and what is made of it again."""

import copy
import json

import numpy as np
import pytest

from cdp_ident.design.knowledge import NEW, Knowledge
from cdp_ident.errors import CdpIdentError, ReportError
from cdp_ident.report.folder import json_text
from cdp_ident.report.next_trial import Question, fitted_motion, knowledge_of, strength_of, usual_questions
from cdp_ident.report.wording import advice_words


def test_the_report_answers_for_all_groups_and_for_the_strength_of_each_effect(content):
    advice = content["next_trial"]["advice"]
    assert [(a["for"], a["against"]) for a in advice] == [("all", None), ("coulomb_friction.outer.torque", None)]
    for one in advice:
        assert 0 < one["expected"] <= one["worst"] < 1
        values = np.array(one["map"]["values"], dtype=float)
        assert values.shape == (8, 8)
        assert np.all(values[np.isfinite(values)] <= 1 + 1e-9)  # no trial makes anything less sure
        assert np.all(np.array(one["std_then"]) < one["std_now"])
    groups = content["after"]["groups"]
    assert advice[0]["std_now"] == pytest.approx([quantity["std"] for quantity in groups.values()], rel=1e-6)


def test_the_advice_is_in_words(content):
    of_all, of_friction = advice_words(content)
    assert of_all.startswith("all groups: let go with the inner rod ")
    assert "their intervals fall to " in of_all
    assert of_friction.startswith("coulomb friction, outer, torque: ")
    changed = copy.deepcopy(content)
    first = changed["next_trial"]["advice"][0]
    first |= {"for": "coulomb_friction.outer", "against": "air_drag outer", "expected": 9.04, "deviations_now": 1.2}
    first |= {"inner_rad": 0.0, "outer_rad": np.pi}
    assert advice_words(changed)[0] == (
        "coulomb friction, outer, or air drag, outer: let go with the inner rod hanging and the outer rod upright: "
        "the two are then 9 standard deviations apart, now 1.2"
    )
    changed["next_trial"] = None
    assert advice_words(changed) == []


def test_a_report_read_from_its_file_knows_what_the_identification_knew(outcome, read_content):
    trace = outcome.trace
    direct = Knowledge.of(trace.after.fit, trace.covariance, outcome.identification.data.scales)
    again = knowledge_of(read_content)
    assert again.model.names == direct.model.names
    assert again.values == pytest.approx(direct.values, rel=1e-9)
    scale = np.sqrt(np.diag(direct.covariance))
    assert again.covariance / np.outer(scale, scale) == pytest.approx(direct.covariance / np.outer(scale, scale))
    assert again.whitening == pytest.approx(direct.whitening)
    assert (again.noise, again.sampling) == (pytest.approx(direct.noise), direct.sampling)


def test_the_motion_of_the_fitted_model_is_read_from_the_curves(outcome, read_content, shown_curves):
    windows = fitted_motion(read_content, shown_curves, knowledge_of(read_content))
    fit = outcome.trace.after.fit
    assert len(windows) == len(fit.windows)
    for window, of_fit, error in zip(windows, fit.windows, fit.errors, strict=True):
        assert window.theta == pytest.approx(of_fit.theta - error)
        assert (window.trial, window.begin) == (of_fit.trial, of_fit.begin)


def test_a_report_of_a_fit_that_failed_knows_nothing(read_content):
    read_content["next_trial"] = None
    assert knowledge_of(read_content) is None


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("interval_s", 0.0),
        ("interval_s", 1e-300),
        ("noise_rad", -1.0),
        ("duration_s", 1e300),
        ("whitening", [[0.0, 0.0], [0.0, 0.0]]),
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
    read_content["after"]["groups"]["c2_over_A22"]["std"] = None
    read = json.loads(json_text(read_content))
    assert np.isinf(knowledge_of(read).covariance[4, 4])


def test_a_trial_has_zeros_of_its_own_where_those_before_had(read_content):
    correlation = read_content["after"]["correlation"]
    correlation["names"] += ["zero.inner.trial_1", "zero.outer.trial_1"]
    size = len(correlation["names"])
    correlation["matrix"] = np.eye(size).tolist()
    assert knowledge_of(read_content).model.zeros == (NEW,)


def test_what_could_be_another_effect_is_asked_first(read_content):
    model = knowledge_of(read_content).model
    asked = usual_questions(model, {"coulomb_friction.outer": ["air_drag outer"]})
    assert asked[0] == Question("coulomb_friction.outer", "air_drag outer")
    assert strength_of(model, "coulomb_friction.outer") == "coulomb_friction.outer.torque"

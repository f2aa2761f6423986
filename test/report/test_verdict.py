# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The sentence that people read first."""

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from cdp_ident.report.verdict import effect_in_words, judgement, verdict
from cdp_ident.tracing.trace import Withdrawn

MILLI = 1e-3


@pytest.fixture
def trace(outcome):
    """Where nothing but noise remains, whatever does."""
    return replace(outcome.trace, unexplained=replace(outcome.trace.unexplained, significant=False))


def named(trace):
    """Return a trace whose effect's name is sure."""
    return replace(trace, effects=tuple(replace(effect, certainty="named") for effect in trace.effects))


def test_it_names_the_effect_its_place_its_strength_and_what_is_left(trace):
    (parameter,) = trace.effects[0].parameters
    sentence = verdict(named(trace))
    assert sentence.startswith(f"Dry friction in the outer joint, {parameter.shown:.4f}")
    in_newton_metres = f"{1e3 * parameter.value:.3g} mN m, give or take a factor of three"
    assert f" 1/s² over A22 ({in_newton_metres}), explains 100 % of what the paper's model could not: " in sentence
    assert " mrad on held-out motion; the rest is encoder noise. " in sentence
    assert sentence.endswith(" Torques in N m are known to ± 21 % once the outer rod is weighed.")


def test_it_says_that_trials_differ_from_one_another_and_in_what(trace):
    (one,) = named(trace).effects
    more = replace(one, active=replace(one.active, trial=1))
    assert effect_in_words(more).startswith("More dry friction in the outer joint in one trial, ")
    said = verdict(replace(trace, effects=(one, more)))
    assert "Trials differ from one another in dry friction in the outer joint: the next one may differ, too." in said
    assert "Trials differ" not in verdict(trace)


def test_newton_metres_are_headlined_where_they_rest_on_something(weighted_outcome):
    said = verdict(named(weighted_outcome.trace))
    assert " mN m, explains " in said
    assert "A22" not in said


@pytest.mark.parametrize(("value", "strength"), [(2.5e-4, ", 250 ± 48 µN m"), (1e-9, "")])
def test_a_strength_is_written_as_precisely_as_it_is_known_and_one_of_nothing_is_not(trace, value, strength):
    (parameter,) = trace.effects[0].parameters
    effect = replace(named(trace).effects[0], parameters=(replace(parameter, value=value, std=4.8e-5),))
    assert effect_in_words(effect) == f"Dry friction in the outer joint{strength}"


@pytest.mark.parametrize(
    ("unit", "words"),
    [("s^2", "30.06 ± 0.18 ms^2"), ("m/N", "30.06 ± 0.18 µm/N"), ("1/s", "0.00003006 ± 0.00000018 1/s")],
)
def test_a_prefix_has_the_power_of_what_it_stands_before(trace, unit, words):
    (parameter,) = trace.effects[0].parameters
    description = replace(parameter.description, unit=unit)
    changed = replace(parameter, value=3.006e-5, std=1.8e-7, shown=3.006e-5, shown_std=1.8e-7, description=description)
    effect = replace(named(trace).effects[0], parameters=(changed,))
    assert effect_in_words(effect).endswith(words)


def test_what_cannot_be_told_apart_is_said_with_the_effect(trace):
    effect = replace(trace.effects[0], also_possible=("stribeck_friction.outer",))
    assert effect_in_words(effect).endswith(" (or stribeck friction, outer, which the data do not distinguish from it)")


def test_several_effects_are_counted_and_named_one_by_one(trace):
    sentence = verdict(replace(trace, effects=trace.effects * 2))
    assert sentence.startswith("Two effects explain 100 % of what the paper's model could not: ")

    assert "ry friction" not in sentence


def test_of_several_effects_none_of_which_is_sure_it_says_so(trace):
    unsure = replace(trace.effects[0], certainty="acts_like")
    sentence = verdict(replace(trace, effects=(unsure, unsure)))
    assert sentence.startswith("Two effects, or what acts like them, explain 100 % of what ")


def test_what_remains_is_said_with_and_without_effects(trace):
    remains = replace(trace.unexplained, significant=True, description="a lot")
    assert "; more than the encoders' noise remains." in verdict(replace(trace, unexplained=remains))
    left = replace(trace, effects=(), unexplained=remains)
    assert verdict(replace(left, selection=None)).endswith("and effects could not be looked for.")
    error = f"{1e3 * trace.after.holdout.rmse():.3g} mrad"
    assert verdict(left) == (f"The paper's model leaves more than noise, {error}, and no known effect explains it.")
    moved = replace(left.whole, noise=replace(left.whole.noise, of_base=True), is_missing=np.array([True, False]))
    assert verdict(replace(left, whole=moved)).endswith(f"{error}, and it is as if the base moved.")


def test_errors_of_time_are_said_with_the_noise(trace):
    late = replace(trace, whole=replace(trace.whole, noise=replace(trace.whole.noise, time=1.2e-3)))
    said = "encoder noise and errors of 1.2 ms in the times of both encoders"
    assert f"; the rest is {said}." in verdict(late)
    noise = trace.completed.data.noise_level
    assert judgement("", 0, noise, noise, noise, False, late="errors").endswith("is encoder noise and errors.")


def test_what_was_withdrawn_is_said_with_both_errors_and_the_paper_s_model_is_kept(trace):
    before = trace.before.holdout.rmse()
    withdrawn = Withdrawn(("air_drag.outer.strips", "backlash.inner"), 1.5 * before)
    sentence = verdict(replace(trace, effects=(), after=trace.before, withdrawn=withdrawn))
    assert sentence.startswith("air drag, outer, strips and backlash, inner were found, but do not carry over: ")
    assert (
        f"{1e3 * before:.3g} -> {1.5e3 * before:.3g} mrad on held-out motion. So the paper's model is kept; "
        in sentence
    )


def test_effects_that_were_left_out_beside_others_are_named(trace):
    sentence = verdict(replace(trace, withdrawn=Withdrawn(("backlash.inner",), 1e-3)))
    left_out = " Left out, as held-out motion is predicted worse with it: backlash, inner."
    assert sentence.replace(left_out, "") == verdict(trace) != sentence


@pytest.mark.parametrize(
    ("count", "before", "after", "significant", "sentence"),
    [
        (1, 4.0, 1.0, False, "Friction, explains 100 % of what the paper's model could not: 4 -> 1 mrad on held-out "
         "motion; the rest is encoder noise."),
        (1, 4.0, 1.0, True, "Friction, explains more than 99 % of what the paper's model could not: 4 -> 1 mrad on "
         "held-out motion; more than the encoders' noise remains."),
        (2, 4.0, 2.0, False, "Friction explain 80 % of what the paper's model could not: 4 -> 2 mrad on held-out "
         "motion; 2 times the encoders' noise is left."),
        (1, 4.0, 5.0, False, "Friction, was found, but does not carry over: 4 -> 5 mrad on held-out motion. So the "
         "paper's model is kept; 4 times the encoders' noise is left."),
        (2, 1.0, 1.01, False, "Friction were found, but hardly matter here: 1 -> 1.01 mrad on held-out motion; the "
         "rest is encoder noise."),
        (1, 1.02, 1.01, False, "Friction, explains 50 % of what the paper's model could not: 1.02 -> 1.01 mrad on "
         "held-out motion; hardly more than the encoders' noise is left."),
        (0, 1.2, 1.2, False, "The paper's model explains the motion: what it leaves, 1.2 mrad, is encoder noise."),
        (0, 4.0, 4.0, False, "The paper's model leaves 4 mrad, 4 times the encoders' noise, and no known effect "
         "explains it."),
    ],
)  # fmt: skip
def test_the_sentence_says_what_the_numbers_do(count, before, after, significant, sentence):
    assert judgement("Friction", count, MILLI * before, MILLI * after, MILLI, significant) == sentence


SIZES = st.floats(0.3, 3e4)


@given(st.integers(0, 12), SIZES, SIZES, st.booleans())
@example(1, 1.0, 1.0, False)
@example(1, 1.0, 1.02, False)
@example(1, 0.9, 0.5, False)
@example(1, 1000.0, 1.6, False)
@example(3, 1000.0, 1000.0, True)
def test_a_verdict_never_contradicts_itself(count, before, after, significant):
    """Errors are in multiples of the noise."""
    before = before if count else after
    sentence = judgement("Something", count, MILLI * before, MILLI * after, MILLI, significant)
    shares = [float(share) for share in re.findall(r"(-?[\d.]+) %", sentence)]
    assert all(0.0 < share <= 100.0 for share in shares)
    is_noise = "is encoder noise" in sentence
    if is_noise:
        assert not significant
        assert after <= 1.5
    else:
        assert "encoders' noise" in sentence or "more than noise" in sentence
        assert "100 %" not in sentence
    assert not re.search(r"\b0 times", sentence)
    if count:
        assert ("not carry over" in sentence) == (after > 1.02 * before)
        assert not shares or after < before
    if is_noise and shares:
        assert min(shares) >= 90.0
    if significant:
        assert "more than" in sentence

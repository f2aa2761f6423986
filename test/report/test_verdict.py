"""The sentence that people read first."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.report.verdict import effect_in_words, verdict


@pytest.fixture
def trace(outcome):
    return outcome.trace


def test_it_names_the_effect_its_place_its_strength_and_what_is_left(trace):
    (parameter,) = trace.effects[0].parameters
    sentence = verdict(trace)
    assert sentence.startswith(f"Dry friction in the outer joint, {1e3 * parameter.value:.2f} ± ")
    assert " mN m, explains 100 % of what the paper's model could not: " in sentence
    assert sentence.endswith(" mrad on held-out motion; the rest is encoder noise.")


def test_a_strength_is_written_as_precisely_as_it_is_known(trace):
    (parameter,) = trace.effects[0].parameters
    effect = replace(trace.effects[0], parameters=(replace(parameter, value=2.5e-4, std=4.8e-5),))
    assert effect_in_words(effect) == "Dry friction in the outer joint, 250 ± 48 µN m"


def test_what_cannot_be_told_apart_is_said_with_the_effect(trace):
    effect = replace(trace.effects[0], also_possible=("stribeck_friction outer",))
    assert effect_in_words(effect).endswith(" (or stribeck_friction outer, which the data do not distinguish from it)")


def test_several_effects_are_counted_and_named_one_by_one(trace):
    sentence = verdict(replace(trace, effects=trace.effects * 2))
    assert sentence.startswith("Two effects explain 100 % of what the paper's model could not: ")
    assert "ry friction" not in sentence


def test_what_remains_is_said_with_and_without_effects(trace):
    remains = replace(trace.unexplained, significant=True, description="a lot")
    assert verdict(replace(trace, unexplained=remains)).endswith("; more than the encoders' noise remains.")
    error = f"{1e3 * trace.after.holdout.rmse():.3g} mrad"
    assert verdict(replace(trace, effects=(), unexplained=remains)) == (
        f"The paper's model leaves more than noise, {error}, and no known effect explains it."
    )


def test_where_nothing_is_found_and_nothing_remains_all_is_noise(trace):
    error = 1e3 * float(np.round(trace.after.holdout.rmse(), 9))
    sentence = verdict(replace(trace, effects=()))
    assert sentence == f"The paper's model explains the motion: what it leaves, {error:.3g} mrad, is encoder noise."

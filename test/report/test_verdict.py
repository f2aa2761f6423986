"""The sentence that people read first."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.report.verdict import verdict


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
    assert "outer joint, 250 ± 48 µN m," in verdict(replace(trace, effects=(effect,)))


def test_what_cannot_be_told_apart_is_said_with_the_effect(trace):
    effect = replace(trace.effects[0], also_possible=("stribeck_friction outer",))
    assert "(or stribeck_friction outer, which the data cannot tell from it)" in verdict(
        replace(trace, effects=(effect,))
    )


def test_what_remains_is_said_with_and_without_effects(trace):
    remains = replace(trace.unexplained, significant=True, description="a lot")
    assert verdict(replace(trace, unexplained=remains)).endswith("; something remains: a lot.")
    assert verdict(replace(trace, effects=(), unexplained=remains)) == (
        "The paper's model leaves more than noise, and no known effect explains it; something remains: a lot."
    )


def test_where_nothing_is_found_and_nothing_remains_all_is_noise(trace):
    error = 1e3 * float(np.round(trace.after.holdout.rmse(), 9))
    sentence = verdict(replace(trace, effects=()))
    assert sentence == f"The paper's model explains the motion: what it leaves, {error:.3g} mrad, is encoder noise."

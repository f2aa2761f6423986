"""Trials with something in them that nobody told the package of. The answer sheet is read in the assertions alone."""

import numpy as np
import pytest

from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.pipeline.identify import identify
from cdp_ident.tracing.trace import Trace, trace
from scenarios.hidden_truths import FIT_TRIALS, Answer, hidden_truth

FIT_TO_THE_NOISE = 1.2


def test_a_kind_and_a_seed_always_hide_the_same() -> None:
    (first, *_), answer = hidden_truth("coulomb_friction.outer", 3)
    (again, *_), other_answer = hidden_truth("coulomb_friction.outer", 3)
    (another, *_), _ = hidden_truth("coulomb_friction.outer", 4)
    assert np.array_equal(first.theta, again.theta)
    assert answer.hidden[0].strength == other_answer.hidden[0].strength
    assert not np.array_equal(first.theta[0], another.theta[0])


def traced(kind: str, seed: int, visible: float | None = None) -> tuple[Trace, Answer]:
    trials, answer = hidden_truth(kind, seed, visible)
    identified = identify(trials[:FIT_TRIALS], trials[FIT_TRIALS:], IdentifyOptions())
    return trace(identified), answer


def named(found: Trace) -> set[tuple[str, str]]:
    return {(e.active.effect.name, e.active.effect.joint) for e in found.effects if e.certainty != "acts_like"}


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.campaign)])
def test_nothing_is_named_where_nothing_is_hidden(seed: int) -> None:
    found, answer = traced("none", seed, 0.0)
    assert named(found) == set()
    assert not found.unexplained.significant
    assert found.after.holdout.rmse() < FIT_TO_THE_NOISE * answer.floor


@pytest.mark.parametrize(
    "kind",
    [
        "encoder_offset.outer",
        pytest.param("coulomb_friction.outer", marks=pytest.mark.campaign),
        pytest.param("air_drag.outer", marks=pytest.mark.campaign),
    ],
)
def test_what_is_hidden_is_named_and_explains_all_but_the_noise(kind: str) -> None:
    found, answer = traced(kind, 0, 3.0)
    assert named(found) == {hidden.identity for hidden in answer.hidden}
    assert found.ladder.before.fit.rmse() > 1.05 * answer.floor  # windows are short where the motion is chaotic
    assert found.after.holdout.rmse() < FIT_TO_THE_NOISE * answer.floor


@pytest.mark.campaign
def test_an_effect_that_took_the_part_of_two_goes_once_both_are_there() -> None:
    found, answer = traced("coulomb_friction.outer+air_drag.outer", 7003)
    assert "dropped load_friction.outer" in [step.action for step in found.ladder.steps]
    assert named(found) == {hidden.identity for hidden in answer.hidden}
    assert found.after.holdout.rmse() < FIT_TO_THE_NOISE * answer.floor


@pytest.mark.campaign
def test_an_effect_that_imitates_a_part_of_something_else_is_not_named() -> None:
    found, answer = traced("backlash.inner", 1000, 0.9)
    assert named(found) == set()
    assert found.unexplained.significant
    assert found.after.holdout.rmse() > 1.5 * answer.floor


@pytest.mark.campaign
def test_a_knock_is_named_though_the_window_it_is_in_hardly_stands_out() -> None:
    found, answer = traced("impulse.inner", 1000, 1.0)
    assert named(found) == {hidden.identity for hidden in answer.hidden}


@pytest.mark.campaign
def test_what_rubs_over_a_part_of_the_turn_is_not_called_dry_friction() -> None:
    found, answer = traced("partial_rub.outer", 5001)
    assert [e.certainty for e in found.effects if e.active.effect.name == "coulomb_friction"] == ["acts_like"]
    assert named(found) == set()
    assert found.unexplained.significant
    assert found.unexplained.joint == answer.hidden[0].effect.joint
    assert "something rubs in the outer joint, most at " in found.unexplained.description


def test_what_no_effect_of_the_catalogue_explains_is_said_to_remain() -> None:
    found, answer = traced("partial_rub.outer", 0, 2.6)
    assert found.after.holdout.rmse() > FIT_TO_THE_NOISE * answer.floor
    assert found.unexplained.significant
    assert found.unexplained.joint == answer.hidden[0].effect.joint

"""Trials with something in them that nobody told the package of. The answer sheet is read in the assertions alone."""

import pytest

from cdp_ident.identification.identify import IdentifyOptions, identify
from cdp_ident.tracing.ladder import Ladder, climb
from reference.hidden_truths import FIT_TRIALS, Answer, hidden_truth

FIT_TO_THE_NOISE = 1.2


def traced(kind: str, seed: int, visible: float) -> tuple[Ladder, Answer]:
    trials, answer = hidden_truth(kind, seed, visible)
    identified = identify(trials[:FIT_TRIALS], trials[FIT_TRIALS:], IdentifyOptions())
    return climb(identified.fit, identified.data.holdout), answer


def named(ladder: Ladder) -> set[tuple[str, str]]:
    return {(active.effect.name, active.effect.joint) for active in ladder.after.model.effects}


@pytest.mark.parametrize("seed", [0, 1])
def test_nothing_is_named_where_nothing_is_hidden(seed: int) -> None:
    ladder, answer = traced("none", seed, 0.0)
    assert named(ladder) == set()
    assert ladder.after.holdout.rmse() < FIT_TO_THE_NOISE * answer.floor


@pytest.mark.parametrize("kind", ["coulomb_friction.outer", "air_drag.outer", "encoder_offset.outer"])
def test_what_is_hidden_is_named_and_explains_all_but_the_noise(kind: str) -> None:
    ladder, answer = traced(kind, 0, 3.0)
    assert named(ladder) == {hidden.identity for hidden in answer.hidden}
    assert ladder.before.holdout.rmse() > 1.5 * answer.floor
    assert ladder.after.holdout.rmse() < FIT_TO_THE_NOISE * answer.floor

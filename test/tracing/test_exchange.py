"""Exchanges that whole truths rarely show one by one."""

from unittest.mock import Mock

import numpy as np
import pytest

from cdp_ident.diagnosis.identification import Identification
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.fit.refinement import refine_from_afar
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.pipeline.identify import identify
from cdp_ident.tracing import exchange
from cdp_ident.tracing.evidence import Attempt, Change
from cdp_ident.tracing.exchange import alternatives, exchange_effects, is_better
from cdp_ident.tracing.progress import Progress, attempt_of
from scenarios.hidden_truths import FIT_TRIALS, hidden_truth

pytestmark = pytest.mark.long

BY_KEY = {effect.key: effect for effect in CATALOGUE}


def with_effects(identified: Identification, *keys: str) -> Attempt:
    model, values = identified.fit.model, identified.fit.values
    for key in keys:
        active = ActiveEffect(BY_KEY[key])
        model = model.with_effect(active)
        values = np.concatenate([values, [parameter.typical for parameter in active.fitted]])
    return attempt_of(refine_from_afar(model, values, identified.fit.windows), identified.data.folds)


def test_two_effects_of_a_joint_that_imitate_one_are_exchanged_for_it() -> None:
    trials, answer = hidden_truth("stribeck_friction.inner", 10, 1.0)
    identified = identify(trials[:FIT_TRIALS], trials[FIT_TRIALS:], IdentifyOptions())
    told: list[str] = []
    tried: list[str] = []
    two = with_effects(identified, "quadratic_friction.inner", "coulomb_friction.inner")
    progress = Progress(two, answer.floor, told.append, trying=tried.append)
    assert exchange_effects(progress)
    exchanged = progress.current
    assert told == [
        "stribeck_friction.inner explains the motion better than quadratic_friction.inner and coulomb_friction.inner"
    ]
    assert [active.effect.key for active in exchanged.model.effects] == ["stribeck_friction.inner"]
    assert exchanged.validation.rmse() < two.validation.rmse()
    assert not exchange_effects(progress)
    tried.clear()
    assert not exchange_effects(progress)
    assert tried == [], "compared again in the same model"


@pytest.fixture(scope="module")
def rubbing() -> tuple[Identification, Attempt, float]:
    """A rig with dry friction, fitted with a friction that contains it, and its floor [rad]."""
    trials, answer = hidden_truth("coulomb_friction.outer", 0, 3.0)
    identified = identify(trials[:FIT_TRIALS], trials[FIT_TRIALS:], IdentifyOptions())
    return identified, with_effects(identified, "stribeck_friction.outer"), answer.floor


def test_what_contains_an_effect_is_no_other_possibility_but_the_other_way_round(
    rubbing: tuple[Identification, Attempt, float],
) -> None:
    identified, more, _ = rubbing
    none, dry = with_effects(identified), with_effects(identified, "coulomb_friction.outer")
    assert alternatives(dry.model.effects[0], dry, none, [more]) == ()
    assert alternatives(more.model.effects[0], more, none, [dry]) == ("coulomb_friction outer",)


def test_what_explains_no_more_than_what_it_contains_is_exchanged_for_that(
    rubbing: tuple[Identification, Attempt, float],
) -> None:
    _, more, floor = rubbing
    told: list[str] = []
    progress = Progress(more, floor, told.append)
    assert exchange_effects(progress)
    assert told == ["coulomb_friction.outer explains the motion as well as stribeck_friction.outer, which contains it"]
    assert not exchange_effects(progress)


SMALL_SHARE = Mock(spec=Change, fit=100.0, validation=20.0, bic=-80.0, freedom=2.0)
"""Too much for chance, but a small share of the error."""


@pytest.fixture
def noise_alone(rubbing: tuple[Identification, Attempt, float], monkeypatch: pytest.MonkeyPatch) -> list[Attempt]:
    """A model with a richer form of dry friction, that is said to gain a small share of the error, and a plain one."""
    identified, more, _ = rubbing
    dry = with_effects(identified, "coulomb_friction.outer")
    opposite = Mock(spec=Change, fit=-100.0, validation=-20.0, bic=80.0, freedom=1.0)
    monkeypatch.setattr(exchange, "change", lambda before, after: SMALL_SHARE if after is more else opposite)
    monkeypatch.setattr(exchange, "improves_enough", lambda before, after: False)
    monkeypatch.setattr(exchange, "is_structured", lambda fit: False)
    return [more, dry]


@pytest.mark.parametrize(("of_the_fall", "better"), [(0.4, True), (0.9, False)])
def test_a_richer_form_may_gain_a_small_share_where_nothing_that_is_missing_would_gain_as_much(
    of_the_fall: float, better: bool, noise_alone: list[Attempt], monkeypatch: pytest.MonkeyPatch
) -> None:
    more, dry = noise_alone
    gain = of_the_fall * (dry.fit.squared_error - more.fit.squared_error)
    missing = Mock(**{"ranked.return_value": [Mock(gain=gain)]})
    monkeypatch.setattr(exchange, "ScoreTest", lambda fit, candidates: missing)
    assert is_better(more, dry) == better
    monkeypatch.setattr(exchange, "is_structured", lambda fit: True)
    assert not is_better(more, dry), "more than noise remains"


def test_a_richer_form_that_the_data_prefer_but_not_by_enough_is_another_possibility_where_only_noise_remains(
    noise_alone: list[Attempt], rubbing: tuple[Identification, Attempt, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    more, dry = noise_alone
    monkeypatch.setattr(exchange, "is_accepted", lambda before, after: True)
    assert alternatives(dry.model.effects[0], dry, dry, [more]) == ("stribeck_friction outer",)
    monkeypatch.setattr(exchange, "is_structured", lambda fit: True)
    assert alternatives(dry.model.effects[0], dry, dry, [more]) == ()

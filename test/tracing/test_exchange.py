"""Exchanges that whole truths rarely show one by one."""

import re
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
from cdp_ident.tracing.exchange import alternatives, exchange_effects, try_states, try_without_memory
from cdp_ident.tracing.progress import Progress
from cdp_ident.tracing.refits import attempt_of
from cdp_ident.trial.trial import Trial
from reference.mechanics import Cart, Rig
from reference.pendulum import TABLE_5
from reference.plant import Plant
from reference.sticking import path
from scenarios.hidden_truths import FIT_TRIALS, hidden_truth
from scenarios.twin import as_measured

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


@pytest.mark.parametrize(
    ("hidden", "seed"),
    [("coulomb_friction.inner+air_drag.inner", 1), ("coulomb_friction.inner+quadratic_friction.inner", 0)],
)
def test_one_effect_that_imitates_what_it_contains_beside_another_is_exchanged_for_both(hidden: str, seed: int) -> None:
    trials, answer = hidden_truth(hidden, seed, 1.5)
    identified = identify(trials[:FIT_TRIALS], trials[FIT_TRIALS:], IdentifyOptions())
    one = with_effects(identified, "stribeck_friction.inner")
    assert one.fit.rmse() > 1.1 * answer.floor
    told: list[str] = []
    progress = Progress(one, answer.floor, told.append)
    assert exchange_effects(progress)
    # Drag and quadratic friction of the inner joint are one law.
    names = "coulomb_friction.inner and (air_drag|quadratic_friction).inner"
    assert len(told) == 1
    assert re.fullmatch(f"{names} explain the motion better than stribeck_friction.inner", told[0])
    assert progress.current.fit.rmse() < 1.05 * answer.floor
    assert [step.action for step in progress.steps] == [
        f"exchanged stribeck_friction.inner for {told[0].partition(' explain')[0]}"
    ]


def test_a_light_cart_that_swings_is_found_from_one_that_only_gives_way() -> None:
    frequency = 45.0
    rods = TABLE_5["m1"] + TABLE_5["m2"] + TABLE_5["m0"]
    cart = Cart(rods, 2.0 * rods * frequency**2, 0.1 * rods * frequency)
    times, rng, noise = np.arange(1600) * 0.005, np.random.default_rng(0), 3e-4
    trials = [
        Trial(
            f"swing_{k}",
            times,
            as_measured(path(Plant(Rig(TABLE_5, cart=cart)), start, times).states[:, :2], rng, noise),
        )
        for k, start in enumerate(([np.pi + 0.7, np.pi - 0.5, 0.0, 0.0], [np.pi - 1.1, np.pi + 0.8, 0.0, 0.0]))
    ]
    identified = identify(trials, [], IdentifyOptions())
    progress = Progress(with_effects(identified, "pivot_compliance.base"), noise)
    before = progress.current.fit.rmse()
    assert before > 2.0 * noise
    try_states(progress, lambda effect: effect.swings)
    (active,), values = progress.current.model.effects, progress.current.fit.values
    assert active.effect.key == "pivot_compliance.base.oscillating"
    assert progress.current.fit.rmse() < 1.5 * noise  # of both encoders in theta2
    assert values[-2] == pytest.approx(frequency, rel=0.02)


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


def test_friction_with_a_memory_that_explains_no_more_than_dry_friction_is_exchanged_for_that(
    rubbing: tuple[Identification, Attempt, float],
) -> None:
    identified, more, floor = rubbing
    told: list[str] = []
    progress = Progress(with_effects(identified, "presliding_friction.outer"), floor, told.append)
    try_without_memory(progress)
    assert told == [
        "coulomb_friction.outer explains the motion as well as presliding_friction.outer, which contains it"
    ]
    progress.current = more
    try_without_memory(progress)
    assert progress.current is more, "it has no memory"


def test_a_richer_form_that_the_data_prefer_but_not_by_enough_is_another_possibility_where_only_noise_remains(
    rubbing: tuple[Identification, Attempt, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    identified, more, _ = rubbing
    dry = with_effects(identified, "coulomb_friction.outer")
    monkeypatch.setattr(exchange, "is_accepted", lambda before, after: True)
    monkeypatch.setattr(exchange, "change", lambda before, after: Mock(spec=Change, bic=-80.0))
    for structured, possible in ((False, ("stribeck_friction outer",)), (True, ())):
        monkeypatch.setattr(exchange, "is_structured", lambda fit, structured=structured: structured)
        assert alternatives(dry.model.effects[0], dry, dry, [more]) == possible


def test_a_variant_of_an_effect_is_a_rival_whatever_its_score_test_says(
    plain: Attempt, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(exchange, "promising", lambda *of: [])
    model = plain.model.with_effect(ActiveEffect(BY_KEY["air_drag.outer.rotation"]))
    fit = refine_from_afar(model, np.append(plain.fit.values, 1e-4), plain.fit.windows)
    tried: list[str] = []
    exchange_effects(Progress(attempt_of(fit, plain.folds), 5e-4, trying=tried.append))
    assert {line.split(",")[0] for line in tried} == {"trying air_drag.outer.strips"}

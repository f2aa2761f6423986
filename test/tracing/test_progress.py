"""Candidates are refitted side by side; what cannot be fitted costs itself alone."""

import numpy as np
import pytest

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.parameters import SYMBOLS, groups_of
from cdp_ident.tracing import progress as progress_module
from cdp_ident.tracing import refits
from cdp_ident.tracing.candidates import Candidate
from cdp_ident.tracing.progress import InterruptedSelectionError, Progress
from reference.pendulum import TABLE_5

BY_KEY = {effect.key: effect for effect in CATALOGUE}
TRUTH = groups_of([TABLE_5[symbol] for symbol in SYMBOLS], TABLE_5["L"])


def candidate(key):
    effect = BY_KEY[key]
    return Candidate(ActiveEffect(effect), 0.0, np.array([p.typical for p in effect.parameters if not p.shape]))


SPRING, DRAG = candidate("joint_spring.outer"), candidate("air_drag.inner")


def test_each_addition_is_refitted(plain):
    progress = Progress(plain, 5e-4)
    (((first,), with_spring), ((second,), with_drag)) = progress.tried(plain, ((c,) for c in (SPRING, DRAG)))
    assert (first, second) == (SPRING, DRAG)
    assert [active.effect.key for active in with_spring.model.effects] == ["joint_spring.outer"]
    assert with_spring.fit.rmse() < 0.5 * plain.fit.rmse()
    assert with_spring.validation.rmse() < 0.5 * plain.validation.rmse()
    assert with_spring.fit.rmse() < with_drag.fit.rmse()
    assert progress.failures == []


def test_a_rival_far_behind_what_it_is_to_beat_is_left_out(plain):
    progress = Progress(plain, 5e-4)
    ((_, with_spring),) = progress.tried(plain, [(SPRING,)])
    found = progress.tried(plain, ((c,) for c in (SPRING, DRAG)), to_beat=with_spring)
    assert [candidates for candidates, _ in found] == [(SPRING,)]
    assert progress.failures == []


def test_what_its_fit_rules_out_is_predicted_only_where_that_is_asked_for(plain):
    progress = Progress(plain, 5e-4)
    additions = [(SPRING,), (DRAG,)]
    found = progress.tried(plain, additions, may_win=lambda after: after.fit.rmse() < 0.5 * plain.fit.rmse())
    assert [attempt.is_predicted for _, attempt in found] == [True, False]
    for (_, attempt), (_, predicted) in zip(found, progress.tried(plain, additions), strict=True):
        assert attempt.validation.rmse() == predicted.validation.rmse()


def test_what_cannot_be_fitted_is_reported_and_left_out(plain, monkeypatch):
    real = progress_module.refit_with

    def fails_with_drag(model, values, before, expected):
        if model.effects[-1].effect.key == "air_drag.inner":
            raise IdentificationError("it diverged")
        return real(model, values, before, expected)

    monkeypatch.setattr(progress_module, "refit_with", fails_with_drag)
    told = []
    progress = Progress(plain, 5e-4, told.append)
    found = progress.tried(plain, ((c,) for c in (DRAG, SPRING)))
    assert [candidates for candidates, _ in found] == [(SPRING,)]
    assert progress.failures == told == ["air_drag.inner could not be fitted: it diverged"]


def test_an_accepted_model_is_refined_to_convergence(plain):
    progress = Progress(plain, 5e-4)
    ((_, roughly),) = progress.tried(plain, [(SPRING,)])
    finished = progress.finished(roughly)
    assert finished.fit.converged
    assert finished.fit.squared_error <= roughly.fit.squared_error * (1 + 1e-9)
    assert np.array_equal(progress.finished(finished).fit.values, finished.fit.values) or (
        progress.finished(finished).fit.squared_error == pytest.approx(finished.fit.squared_error, rel=1e-6)
    )


def test_a_balance_of_forces_gives_groups_and_strengths_to_begin_with(plain):
    progress = Progress(plain, 5e-4)
    ((_, expected),) = progress.tried(plain, [(SPRING,)])
    found = progress.from_balance(plain, 1.02 * TRUTH, [SPRING])
    assert [active.effect.key for active in found.model.effects] == ["joint_spring.outer"]
    assert found.fit.rmse() == pytest.approx(expected.fit.rmse(), rel=1e-3)


def test_a_balance_of_forces_that_gives_no_motion_is_told_and_left_out(plain):
    told = []
    assert Progress(plain, 5e-4, told.append).from_balance(plain, np.full(5, 1e150), [SPRING]) is None
    assert "what the balance of forces shows could not be fitted" in told[0]


def test_a_selection_that_is_asked_to_stop_tries_nothing_more(plain):
    progress = Progress(plain, 5e-4, stop=lambda: True)
    with pytest.raises(InterruptedSelectionError):
        progress.tried(plain, [(SPRING,)])


def test_what_is_tried_is_told_with_how_long_it_may_take(plain):
    said = []
    Progress(plain, 5e-4, trying=said.append).tried(plain, [(SPRING,), (DRAG,)])
    assert said[0] == "trying joint_spring.outer, 1 of 2"
    assert said[1].startswith("trying air_drag.inner, 2 of 2, about ")


def test_a_model_without_an_effect_is_fitted_once(plain):
    progress = Progress(plain, 5e-4)
    ((_, with_both),) = progress.tried(plain, [(SPRING, DRAG)])
    without_spring, without_drag = progress.without_each(with_both, [[0], [1]])
    assert [active.effect.key for active in without_spring.model.effects] == ["air_drag.inner"]
    assert [active.effect.key for active in without_drag.model.effects] == ["joint_spring.outer"]
    assert progress.without(with_both, [0]) is without_spring


def test_the_papers_model_stands_for_one_that_cannot_be_fitted_without_an_effect(plain, monkeypatch):
    progress = Progress(plain, 5e-4)
    ((_, with_both),) = progress.tried(plain, [(SPRING, DRAG)])
    real = refits.refine

    def fails_without_spring(model, *rest, **named):
        if [active.effect.key for active in model.effects] == ["air_drag.inner"]:
            raise IdentificationError("it diverged")
        return real(model, *rest, **named)

    monkeypatch.setattr(refits, "refine", fails_without_spring)
    without_spring, without_drag = progress.without_each(with_both, [[0], [1]])
    assert without_spring is plain
    assert [active.effect.key for active in without_drag.model.effects] == ["joint_spring.outer"]
    said = "the model without joint_spring.outer could not be fitted, it is compared with the paper's: it diverged"
    assert progress.failures == [said]


def test_what_fails_aside_is_not_reported_at_once(plain, monkeypatch):
    def fails(model, values, before, expected):
        raise IdentificationError("it diverged")

    monkeypatch.setattr(progress_module, "refit_with", fails)
    told = []
    progress = Progress(plain, 5e-4, told.append)
    aside = progress.aside(lambda: False)
    assert aside.tried(plain, [(SPRING,)]) == []
    assert (aside.failures, told) == (["joint_spring.outer could not be fitted: it diverged"], [])


def test_what_goes_on_aside_is_stopped_with_the_rest_or_by_itself(plain):
    for of_all, own in ((True, False), (False, True)):
        aside = Progress(plain, 5e-4, stop=lambda of_all=of_all: of_all).aside(lambda own=own: own)
        with pytest.raises(InterruptedSelectionError):
            aside.tried(plain, [(SPRING,)])

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The search ends at the most probable model, and says how it came there."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.likelihood.gauss_newton import GaussNewton
from cdp_ident.likelihood.maxima import likelier_maximum
from cdp_ident.tracing.certainty import probabilities
from cdp_ident.tracing.model_search import InterruptedSearchError, ModelSearch
from cdp_ident.tracing.neighbours import Neighbour
from cdp_ident.tracing.over_windows import OverWindows
from scenarios.swings import BEGIN, NOISE, TIME, fitted, known, measured, motion, recorded

DRY, SCALE = "coulomb_friction.outer", "encoder_scale.inner"


def begun(trials, stop=lambda: False, trying=lambda line: None, say=lambda line: None, named_only=True):
    errors = OverWindows(cut_into_windows(trials, 0.6), np.full(2, NOISE))
    return ModelSearch(likelier_maximum(fitted(recorded(trials), values=BEGIN)), named_only, errors, say, stop, trying)


def rubbing(seed=0, size=4e-4):
    return measured(motion(dry=size), np.random.default_rng(seed))


def of_two(rng, moved):
    """Return two trials of 5 s, of motions that come of starts."""
    return [measured(moved(start, k)[:1000], rng, time=TIME[:1000]) for k, start in enumerate(((1.5, 1.2), (1.4, 1.9)))]


def with_effects(search, **of):
    """Return a model with effects of given values, to be tried."""
    model, values = search.paper.model, search.paper.values
    for key, given in of.items():
        model, values = model.with_effect(ActiveEffect(known(key))), np.append(values, given)
    return Neighbour(model, values, tuple(of), search.paper)


@pytest.fixture(scope="module")
def found():
    lines, search = [], begun([rubbing()])
    search._say = lines.append
    search.run()
    return search, lines


def test_nothing_is_added_to_clean_motion():
    search = begun([measured(motion(), np.random.default_rng(1))], named_only=False)
    search.run()
    assert search.best is search.paper
    assert search.scores


def test_autocorrelated_noise_is_not_taken_for_a_torque():
    search = begun([measured(motion(), np.random.default_rng(5), memory=0.8)])
    assert not np.any(search.paper.is_missing)
    assert search.paper.noise.memory == pytest.approx([0.8, 0.8], abs=0.1)


def test_dry_friction_is_found_by_steps_that_say_what_was_tried_and_how_probable_it_is(found):
    search, lines = found
    assert search.best.model.labels == (DRY,)
    assert not np.any(search.best.is_missing)
    assert search.cost(search.paper) > 20.0
    assert min(map(search.cost, search.fitted.values())) == search.cost(search.best) == 0.0
    assert search.without(0) is search.paper
    assert lines[0].startswith(f"added {DRY}: the model is 10^")
    first, last = search.steps[0], search.steps[-1]
    assert first.action == f"added {DRY}"
    assert DRY in [key for tried in first.tried for key in tried.effects]
    assert [tried.misfit for tried in first.tried] == sorted(tried.misfit for tried in first.tried)
    assert first.tried[0].misfit == pytest.approx(first.misfit, abs=1e-6)
    assert last.misfit == -search.cost(search.paper)
    assert last.misfit <= first.misfit


def test_a_superfluous_effect_is_dropped_and_what_is_tried_is_told():
    told = []
    search = begun([rubbing()], trying=told.append)
    search.begin_with([with_effects(search, **{DRY: 5e-3, SCALE: 1e-5})], "confirmed")
    assert search.best.model.labels == (DRY,)
    assert search.steps[0].action == f"confirmed {DRY} and {SCALE}"
    assert search.steps[-1].action == f"dropped {SCALE}"
    assert told[0] == f"{DRY} and {SCALE}"


def test_what_is_suggested_and_does_not_help_is_not_kept():
    search = begun([measured(motion(), np.random.default_rng(1))])
    search.begin_with([with_effects(search, **{SCALE: 1e-3})], "confirmed")
    assert search.best is search.paper
    assert search.steps[-1].action == "nothing more helps"


@pytest.mark.parametrize(("size", "labels"), [(4e-4, ("presliding_friction.outer",)), (0.0, ())])
def test_what_no_score_speaks_for_is_fitted_where_its_first_step_promises_something(size, labels):
    search = begun([rubbing(size=size)])
    presliding = with_effects(search, **{"presliding_friction.outer": (5e-3, 0.02)})
    search.begin_with([replace(presliding, unscored=True)], "added")
    assert {found.model.labels for found in search.fitted.values()} == {(), labels}


@pytest.mark.parametrize(("at_once", "labels", "steps"), [(True, (), 0), (False, (DRY,), 1)])
def test_asked_to_stop_it_ends_and_keeps_the_best_so_far(at_once, labels, steps):
    lines = []
    search = begun([rubbing()], stop=lambda: at_once or bool(lines), say=lines.append)
    with pytest.raises(InterruptedSearchError):
        search.run()
    assert (search.best.model.labels, len(search.steps)) == (labels, steps)
    assert not at_once or len(search.fitted) == 1


class _OneExplainsNothing:
    """Errors over windows by which no effect explains anything while it is alone."""

    def explains(self, found, than):
        return len(found.model.effects) != 1

    def leaves_less(self, found, than):
        return False


@pytest.mark.parametrize(("offset", "effects"), [(0.01, {DRY, "encoder_offset.outer"}), (0.0, set())])
def test_of_several_effects_each_may_explain_little_while_the_others_are_missing(offset, effects):
    trial = rubbing()
    search = begun([replace(trial, theta=trial.theta + offset * np.array([0.0, 1.0]))])
    search._errors = _OneExplainsNothing()
    search.run()
    assert set(search.best.model.labels) == effects
    at_once = [step.action for step in search.steps if step.action.startswith("added")]
    assert [set(action.removeprefix("added ").split(" and ")) for action in at_once] == [effects] * bool(effects)


def test_a_filter_is_as_probable_as_a_delay_that_is_like_it():
    """Its states begin at zero, and no angle of the rods changes with them."""
    angles, late = motion(), 3e-4
    shown = np.column_stack([angles[:, 0], np.interp(TIME - late, TIME, angles[:, 1] - angles[:, 0]) + angles[:, 0]])
    search = begun([measured(shown, np.random.default_rng(4))])
    delay = with_effects(search, **{"time_offset.outer": late})
    (delayed, _), (filtered, _) = search._fit_all(
        [delay, with_effects(search, **{"encoder_filter.outer.first order": late})], np.inf
    )
    assert search.cost(delayed) < -100.0
    assert search.cost(filtered) == pytest.approx(search.cost(delayed), abs=6.0)
    assert filtered.converged


def test_the_same_input_gives_the_same_steps(found):
    search, _ = found
    again = begun([rubbing()])
    again.run()
    assert again.steps == search.steps
    np.testing.assert_array_equal(again.best.values, search.best.values)


def test_what_cannot_be_fitted_is_told_and_left_out(monkeypatch):
    search = begun([rubbing()])

    def fails(search, *others, **rest):
        raise IdentificationError("no motion can be computed")

    monkeypatch.setattr(GaussNewton, "run", fails)
    search.run()
    assert search.best is search.paper
    assert f"{DRY}: no motion can be computed" in search.failures


def test_zeros_that_differ_from_trial_to_trial_are_found():
    search = begun(of_two(np.random.default_rng(3), lambda start, k: motion(start) + (4e-3, -4e-3)[k]))
    search.run()
    assert (search.best.model.zeros, search.best.model.zero_joints) == ((0, 1), ("inner",))
    assert "added inner zeros of each trial" in [step.action for step in search.steps]
    zeros = search.best.values[search.best.model.of_zeros]
    assert zeros == pytest.approx([4e-3, -4e-3], abs=3e-4)
    assert not search.best.model.effects


def test_friction_that_differs_between_trials_is_what_one_has_more():
    search = begun(of_two(np.random.default_rng(6), lambda start, k: motion(start, dry=(4e-4, 8e-4)[k])))
    search.run()
    assert [(a.effect.key, a.trial) for a in search.best.model.effects] == [(DRY, None), (DRY, 1)]
    one, more = search.best.values[-2:]
    assert more == pytest.approx(one, rel=0.1)
    assert not np.any(search.best.is_missing)
    assert all(probability > 0.95 for probability in probabilities(search))


def test_one_trial_has_no_zeros_of_its_own():
    search = begun([measured(motion() + 4e-3, np.random.default_rng(3))])
    search.run()
    assert search.best.model.zeros == ()
    assert search.best.model.effects

"""How sure a name is follows from what the effect explains beside what remains, and from its rivals."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.refinement import Fit
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.effects.curves import CURVES
from cdp_ident.tracing.certainty import certainties, confirmed
from cdp_ident.tracing.evidence import Attempt
from cdp_ident.tracing.final_model import FinalModel
from cdp_ident.tracing.progress import Progress
from cdp_ident.tracing.selection import Selection
from cdp_ident.trial.trial import Trial

NOISE = 1e-3
DRY = next(effect for effect in CATALOGUE if effect.key == "coulomb_friction.outer")
(WINDOW,) = cut_into_windows([Trial("still", np.linspace(0.0, 1.0, 20), np.zeros((20, 2)))])
PLAIN = MotionModel(Mechanism(0.4, 9.81, 0.4, 0.05))
MODEL = PLAIN.with_effect(ActiveEffect(DRY))


def attempt(model: MotionModel, error: float) -> Attempt:
    """Return a model that leaves an error, over the noise."""
    residuals = np.full((len(WINDOW.theta), 2), error * NOISE)
    fit = Fit(model, np.zeros(len(model.names)), (WINDOW,), (residuals,), (), (), 1, 1, True)
    return Attempt(fit, (), fit)


def certainty(left, without, also_possible=(), model=MODEL):
    progress = Progress(attempt(model, left), NOISE)
    return certainties(progress, [attempt(PLAIN, without)], [also_possible])


def test_an_effect_that_explains_far_more_than_remains_is_named():
    assert certainty(2.0, 10.0) == ("named",)


def test_a_name_for_which_the_data_have_others_is_probable():
    assert certainty(2.0, 10.0, ("air_drag outer",)) == ("probable",)


@pytest.mark.parametrize("without", [10.5, 14.0])
def test_an_effect_that_explains_no_more_than_remains_only_acts_like_its_name(without):
    assert certainty(10.0, without) == ("acts_like",)


@pytest.mark.parametrize("without", [3.0, 100.0])
def test_a_torque_without_a_name_has_none_whatever_it_explains(without):
    model = PLAIN.with_effect(ActiveEffect(CURVES[0]))
    assert certainty(1.0, without, model=model) == ("acts_like",)


def held_out(before, after, model=MODEL):
    """Return how sure a name is when held-out motion shows such errors, of a model that leaves the noise in the fit."""
    selection = Selection.nothing(attempt(model, 1.0))
    selection = replace(selection, certainty=("named",))
    finals = [FinalModel(attempt(of, 1.0).fit, attempt(of, e).fit) for of, e in ((PLAIN, before), (model, after))]
    return confirmed(selection, *finals).certainty


@pytest.mark.parametrize(("before", "after"), [(20.0, 1.0), (20.0, 8.0), (1.4, 1.4)])
def test_a_name_stays_where_held_out_motion_is_followed_or_most_of_its_error_explained(before, after):
    assert held_out(before, after) == ("named",)


@pytest.mark.parametrize(("before", "after"), [(20.0, 17.0), (20.0, 30.0)])
def test_a_name_goes_where_held_out_motion_is_followed_no_better_with_it(before, after):
    assert held_out(before, after) == ("acts_like",)


def test_what_happened_at_an_instant_keeps_its_name_whatever_held_out_motion_shows():
    knock = ActiveEffect(next(effect for effect in CATALOGUE if effect.at_an_instant), trial=0)
    assert held_out(20.0, 17.0, PLAIN.with_effect(knock)) == ("named",)

"""Effects are looked for in a share of long recordings; what was found is fitted to all, and judged by all."""

import numpy as np
import pytest

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.parameters import SYMBOLS, groups_of, inertia_about_cart
from cdp_ident.pipeline.identify import identify
from cdp_ident.tracing.candidates import Candidate
from cdp_ident.tracing.progress import Progress
from cdp_ident.tracing.trace import trace
from cdp_ident.tracing.whole import over_all, over_share
from scenarios.hidden_truths import FIT_TRIALS, hidden_truth

pytestmark = pytest.mark.long

SHARE = 8.0
"""Of some 25 s of motion [s]."""


def identified(kind, seed, visible=None):
    """Return an identification whose trace looks for effects in a share, and the answer."""
    trials, answer = hidden_truth(kind, seed, visible)
    options = IdentifyOptions(motion_for_effects=SHARE, named_effects_only=True)
    return identify(trials[:FIT_TRIALS], trials[FIT_TRIALS:], options), answer


def traced(found, stop_after=None):
    """Return a trace, and what was said."""
    said = []
    asked = (lambda: any(stop_after in line for line in said)) if stop_after else lambda: False
    return trace(found, said.append, asked), said


@pytest.fixture(scope="module")
def rubbing():
    return identified("coulomb_friction.outer", 3)


@pytest.fixture(scope="module")
def friction(rubbing):
    before, answer = rubbing
    found, said = traced(before)
    return found, answer, said


def test_what_a_share_shows_is_named_and_fitted_to_all_of_the_motion(friction):
    found, answer, said = friction
    windows = len(found.after.fit.windows)
    assert found.selection.looked_in < windows == len(found.before.fit.windows)
    assert said[0] == (
        f"effects are looked for in {found.selection.looked_in} of {windows} windows, spread evenly over all trials"
    )
    assert [(e.active.effect.key, e.certainty) for e in found.effects] == [("coulomb_friction.outer", "named")]
    assert found.after.holdout.rmse() < 1.2 * answer.floor


def test_values_are_those_of_all_of_the_motion_within_their_intervals(friction):
    found, answer, _ = friction
    truth = groups_of([answer.values[symbol] for symbol in SYMBOLS], answer.values["L"])
    std = np.sqrt(np.diag(found.covariance))[:5]
    assert np.all(np.abs(found.completed.fit.values[:5] - truth) < 4.0 * std)
    ((strength,),) = (effect.parameters for effect in found.effects)
    inertia = inertia_about_cart(np.array([answer.values[symbol] for symbol in SYMBOLS]), answer.values["L"])
    assert strength.shown == pytest.approx(answer.hidden[0].strength / float(inertia), rel=0.01)


@pytest.mark.campaign
def test_an_impulse_outside_the_share_is_found_in_the_end():
    before, answer = identified("impulse.outer", 1, visible=8.0)
    found, said = traced(before)
    in_all = next(k for k, line in enumerate(said) if line.startswith("more effects are looked for in all"))
    assert not any(line.startswith("added") for line in said[:in_all])
    ((_, at),) = (effect.parameters for effect in found.effects)
    assert [effect.active.effect.key for effect in found.effects] == ["impulse.outer"]
    assert answer.hidden[0].effect.trial == found.effects[0].active.trial
    assert found.after.holdout.rmse() < 1.2 * answer.floor
    assert at.std < 0.01


def test_what_all_of_the_motion_does_not_bear_out_is_dropped(plain):
    said = []
    attempt = over_share(plain, (0, 1, 2, 3))
    assert len(attempt.fit.windows) < len(plain.fit.windows)
    progress = Progress(attempt, 5e-4, said.append)
    for key in ("air_drag.outer.rotation", "joint_spring.outer"):
        effect = next(effect for effect in CATALOGUE if effect.key == key)
        typical = np.array([parameter.typical for parameter in effect.parameters])
        ((_, attempt),) = progress.tried(attempt, [(Candidate(ActiveEffect(effect), 0.0, typical),)])
    found = progress.finished(attempt)
    progress = progress.over(plain)
    over_all(progress, found)
    assert "dropped air_drag.outer.rotation: it no longer helps" in said
    assert [active.effect.key for active in progress.current.model.effects] == ["joint_spring.outer"]
    assert len(progress.current.fit.windows) == len(plain.fit.windows)


@pytest.mark.campaign
def test_an_effect_that_took_the_part_of_lost_counts_is_dropped():
    before, _ = identified("encoder_slip.outer", 2, visible=8.0)
    found, said = traced(before)
    assert any(line.startswith("added impulse.outer") for line in said)
    assert [effect.active.effect.key for effect in found.effects] == ["encoder_slip.outer"]


def test_asked_to_stop_it_fits_what_it_has_to_all_of_the_motion(rubbing):
    before, _ = rubbing
    found, said = traced(before, stop_after="added coulomb_friction.outer")
    assert found.selection.interrupted
    assert [effect.active.effect.key for effect in found.effects] == ["coulomb_friction.outer"]
    assert len(found.after.fit.windows) == len(found.before.fit.windows) > found.selection.looked_in
    assert not any(line.startswith("nothing more helps") for line in said)

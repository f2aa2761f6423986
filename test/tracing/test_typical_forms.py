"""Whether a motion would show a richer form of an effect if it were there."""

import numpy as np
import pytest

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.refinement import refine
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.parameters import SYMBOLS, groups_of
from cdp_ident.tracing.evidence import Attempt
from cdp_ident.tracing.exchange import alternatives
from cdp_ident.tracing.progress import Progress
from cdp_ident.tracing.refits import attempt_of
from cdp_ident.tracing.typical_forms import try_typical_forms
from reference.pendulum import TABLE_5
from scenarios.twin import TEN_SECONDS, twin

BY_KEY = {effect.key: effect for effect in CATALOGUE}
NOISE = 5e-4
TURNING = (0.3, 0.5, 20.0, 22.0)
"""A start from which the inner joint turns over and never is slow."""
SWINGING = (1.2, 1.0, 0.0, 0.0)
"""A start from which it turns back again and again."""


def rubbing(time, state):
    torque = 0.1 * np.tanh(state[2] / 0.01)
    return -torque, 0.0


def fitted(start: tuple[float, float, float, float], *keys: str) -> Attempt:
    """Return a model with effects, fitted to a swing of a rig with dry friction in its inner joint."""
    times = TEN_SECONDS[:500]
    trial = twin(np.random.default_rng(0), start=start, times=times, noise=NOISE, torque=rubbing, tolerance=1e-7)
    windows = cut_into_windows([trial], 0.625)
    model = MotionModel(Mechanism.of(Prior()))
    values = groups_of([TABLE_5[symbol] for symbol in SYMBOLS], TABLE_5["L"])
    for key in keys:
        active = ActiveEffect(BY_KEY[key])
        model = model.with_effect(active)
        values = np.concatenate([values, [parameter.typical for parameter in active.fitted]])
    return attempt_of(refine(model, values, windows), tuple(tuple(range(len(windows))[k::2]) for k in range(2)))


@pytest.mark.parametrize(
    ("start", "possible"), [(TURNING, ("stribeck_friction inner",)), (SWINGING, ())], ids=["turning", "swinging"]
)
def test_friction_may_be_larger_near_rest_where_the_joint_is_never_slow_and_not_where_it_is(
    start: tuple[float, float, float, float], possible: tuple[str, ...]
) -> None:
    none, dry = fitted(start), fitted(start, "coulomb_friction.inner")
    progress = Progress(dry, NOISE)
    try_typical_forms(progress)
    assert alternatives(dry.model.effects[0], dry, none, progress.rivals["coulomb_friction.inner"]) == possible


def test_what_has_no_richer_form_gets_no_rival_and_keeps_those_that_it_has() -> None:
    drag = fitted(TURNING, "quadratic_friction.inner")
    progress = Progress(drag, NOISE)
    progress.rivals["quadratic_friction.inner"] = (drag,)
    try_typical_forms(progress)
    assert progress.rivals == {"quadratic_friction.inner": (drag,)}

"""What long windows showed is fitted over short ones, and stays unless something else predicts much better."""

import numpy as np
import pytest

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.refinement import refine
from cdp_ident.fit.windows import split
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.tracing.candidates import Candidate
from cdp_ident.tracing.progress import Progress
from cdp_ident.tracing.refits import attempt_of
from cdp_ident.tracing.selection import Selection
from cdp_ident.tracing.shorter_windows import fitted_over_shorter, preferred

NOISE = 5e-4


@pytest.fixture(scope="module")
def longer(plain):
    """Return a selection with a spring and an offset, over windows of 1.25 s."""
    attempt, progress = plain, Progress(plain, NOISE)
    for key in ("joint_spring.outer", "encoder_offset.inner"):
        effect = next(effect for effect in CATALOGUE if effect.key == key)
        typical = np.array([parameter.typical for parameter in effect.parameters if not parameter.shape])
        ((_, attempt),) = progress.tried(attempt, [(Candidate(ActiveEffect(effect), 0.0, typical),)])
    found = progress.finished(attempt)
    return Selection(
        before=plain,
        after=found,
        steps=(),
        without=tuple(progress.without_each(found, [[0], [1]])),
        also_possible=((), ("gravity_tilt base",)),
        certainty=("named", "acts_like"),
        failures=("something could not be computed",),
        interrupted=False,
        looked_in=len(plain.fit.windows),
    )


@pytest.fixture(scope="module")
def shorter(plain):
    """Return the paper's model over windows of 0.6 s."""
    windows = [piece for window in plain.fit.windows for piece in split(window, 2)]
    fit = refine(plain.model, plain.fit.values, windows)
    return attempt_of(fit, tuple(tuple(range(len(windows))[k::4]) for k in range(4)))


def test_effects_are_fitted_over_shorter_windows_with_names_as_sure_as_they_were(longer, shorter):
    found = fitted_over_shorter(longer, Progress(shorter, NOISE))
    assert found.before is shorter
    assert len(found.after.fit.windows) == 2 * len(longer.after.fit.windows)
    assert found.after.model.labels == longer.after.model.labels
    assert (found.certainty, found.also_possible) == (longer.certainty, longer.also_possible)
    assert found.failures == longer.failures
    assert found.after.fit.rmse() < 1.2 * NOISE
    assert found.without[0].fit.rmse() > 2.0 * found.after.fit.rmse()


def test_what_longer_windows_showed_stays_unless_something_else_predicts_much_better(longer, shorter):
    found = fitted_over_shorter(longer, Progress(shorter, NOISE))
    nothing = Selection.nothing(shorter)
    assert preferred(found, nothing) is found
    assert preferred(found, found) is found
    assert preferred(nothing, found) is found
    assert preferred(None, nothing) is nothing

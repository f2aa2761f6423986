# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From trials to parameters and effects, over windows as long as the motion can be followed."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from cdp_ident.diagnosis.identification import Identification
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.initial_states import fit_initial_states
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.pipeline.identify import identify
from cdp_ident.search.genetic_search import Progress
from cdp_ident.tracing.expected import ExpectedEffect
from cdp_ident.tracing.trace import LongerWindows, Trace, judged, trace
from cdp_ident.trial.trial import Trial

_NOT_FOLLOWED = 15.0
"""A model does not follow a motion that it predicts with more than so many times the encoders' noise. Simulated rigs
are left with less than 3 times, of measured ones that are followed over long windows one with 10 times, and one that is
not with 80 times."""
_LONG = 1.5
"""Windows of more than so many half swings are long."""


def identify_and_trace(
    fit: Sequence[Trial],
    holdout: Sequence[Trial],
    options: IdentifyOptions,
    stop: Callable[[Progress], str | None] = lambda progress: None,
    say: Callable[[str], None] = lambda line: None,
    stop_tracing: Callable[[], bool] = lambda: False,
    trying: Callable[[str], None] = lambda line: None,
    expected: Sequence[ExpectedEffect] = (),
) -> tuple[Identification, Trace]:
    """Identify the paper's model, and trace what it leaves to effects that it lacks.

    Where the model does not follow the motion well, it is judged over windows of half a swing, unless their length is
    given: what no model has, such as friction that varies by chance, adds up along a window.

    Args:
        fit: trials to fit.
        holdout: trials that are held out.
        options: how.
        stop: called after each generation of the search; it ends the search by returning why.
        say: called with a line of text after each step of the tracing.
        stop_tracing: asked repeatedly; true ends the tracing with the effects found so far.
        trying: called with what the tracing tries next.
        expected: effects found on the rig before.

    Raises:
        IdentificationError: the trials do not suffice.
    """
    found = identify(fit, holdout, options, stop)
    traced = trace(found, say, stop_tracing, trying, expected)
    if options.window or stop_tracing() or found.failure or _is_followed(found, traced):
        return found, traced
    half_swing = found.data.scales.half_swing
    longer = LongerWindows(found.data.window, traced.errors["effects"].holdout.rmse)
    say(
        f"windows of {longer.duration:.3g} s are too long for this motion: they leave {1e3 * longer.error:.3g} mrad; "
        f"it is judged over half a swing, {half_swing:.2g} s"
    )
    data = found.data.over_shorter_windows(half_swing)
    try:
        followed = fit_initial_states(found.fit.model, found.fit.values, data.fit)
        shorter = replace(found, data=data, fit=followed)
        over_shorter = judged(shorter, traced.searched, traced.failures, say, longer)
    except (IdentificationError, np.linalg.LinAlgError) as error:
        say(f"it cannot be, the longer ones stand: {error}")
        return found, traced
    if over_shorter.failure:
        say(f"it is not followed over half a swing either: {over_shorter.failure}")
        return found, traced
    return shorter, over_shorter


def _is_followed(found: Identification, traced: Trace) -> bool:
    """Return whether a model follows the motion over its windows, or these are as short as half a swing."""
    if found.data.window <= _LONG * found.data.scales.half_swing:
        return True
    return not traced.failure and traced.errors["effects"].holdout.rmse < _NOT_FOLLOWED * found.data.noise_level

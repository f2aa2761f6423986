# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The whole identification: trials in, parameters with intervals, errors and effects out.

What the paper's model leaves is traced to effects, over windows as long as the motion can be followed.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from cdp_ident.diagnosis.identification import Identification
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.data import Data, noise_over_averages, prepare
from cdp_ident.fit.force_balance import ForceBalance, Pieces, balance_of_forces
from cdp_ident.fit.initial_states import fit_initial_states
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.objective import search_objective
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.roles import assign_roles
from cdp_ident.fit.scales import scales_of
from cdp_ident.fit.thinning import thinned
from cdp_ident.likelihood.gauss_newton import GaussNewton
from cdp_ident.likelihood.maxima import CLOSE_ENOUGH, FEW_STEPS, NEAR, best_of, likelier_maximum
from cdp_ident.likelihood.noise import Noise
from cdp_ident.likelihood.recorded import fitted_recorded, states_of
from cdp_ident.likelihood.whole_swing import WholeSwings
from cdp_ident.model.parameters import groups_of, inertia_about_cart, time_unit
from cdp_ident.search.genetic_search import Progress, SearchResult, genetic_search
from cdp_ident.tracing.select_effects import ExpectedEffect
from cdp_ident.tracing.trace import LongerWindows, Trace, judged, trace
from cdp_ident.trial.trial import Trial

_ANOTHER, _MOST_LEFT = 0.2, 1.0 / 3.0
"""L is not believed where the balance of forces has one that differs by more than the first share, with which at most
the second share of what is unexplained is left."""
_MOST_SAMPLES = 500_000
"""More samples are averaged for the final values, too, where the motion is slower than that: memory grows with them."""
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
        fit: trials to fit jointly, and to choose effects by.
        holdout: trials that are held out; without any, stretches of the others are.
        options: how.
        stop: called after each generation of the search; a sentence that it returns ends the search, of which the
            best so far is then fitted.
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


def identify(
    fit: Sequence[Trial],
    holdout: Sequence[Trial],
    options: IdentifyOptions,
    stop: Callable[[Progress], str | None] = lambda progress: None,
) -> Identification:
    """Identify the paper's model from trials; arguments, and what is raised, are those of `identify_and_trace`."""
    if not fit:
        raise IdentificationError("there is no trial to fit: give at least one bag")
    prior, motors = options.prior, any(trial.torques is not None for trial in fit)
    inertia_free = _weights_differ(fit, holdout)
    if motors and inertia_free:
        raise IdentificationError(
            "motors drive some trials and weights are on the rods of others: each would show A22 by itself, and "
            "they are not fitted together; leave one kind out"
        )
    parted = assign_roles(fit, holdout, time_unit(prior.length, prior.gravity))
    shown = [part.shown for part in parted if part.is_fitted]
    balanced = _balance(shown, prior)
    scales = scales_of(shown, prior.length, prior.gravity)
    averaged = scales.together if sum(len(part.measured.time) for part in parted) > _MOST_SAMPLES else 1
    parted = [
        replace(part, trial=thinned(part.trial, scales.together), measured=thinned(part.measured, averaged))
        for part in parted
    ]
    noise = noise_over_averages(shown, [part.shown for part in parted if part.is_fitted], scales.together)
    data = prepare(parted, options.window or scales.window, scales, noise)
    # A length with which forces balance far worse than with another one is not believed.
    is_another = balanced is not None and balanced.length != prior.length
    model = replace(
        options.model,
        length_std=np.inf if is_another else options.length_std,
        inertia_free=inertia_free or motors,
        motors=motors,
        torque_std=max(options.torque_std, np.finfo(float).eps),
        weight_errors=tuple(dict.fromkeys(e for trial in fit for weight in trial.weights for e in weight.errors)),
    )
    objective = search_objective(data.fit, options.span(data.window), prior)
    search = genetic_search(objective, *prior.box, options.search, np.random.default_rng(options.seed), stop)
    enough = options.motion_for_effects or scales.enough
    whole, lost = _paper_s_model(model, search, balanced, data, prior, enough)
    followed = fit_initial_states(model, whole.values, data.fit)
    return Identification.of(options, data, search, whole, followed, whole.covariance, lost)


def _paper_s_model(
    model: MotionModel, search: SearchResult, balanced: ForceBalance | None, data: Data, prior: Prior, enough: float
) -> tuple[WholeSwings, str]:
    """Return the paper's model fitted to whole swings, from the search's best and from a balance of forces.

    Where no step leads anywhere, it is the model where it begins, which shows how far off the motion is; the second
    value says so, and is empty otherwise. Raises `IdentificationError` where no motion can be computed from either.
    """
    inertia = float(inertia_about_cart(search.best, prior.length))
    begins = [model.initial_values(groups_of(search.best, prior.length), inertia)]
    if balanced:
        begins.insert(0, model.initial_values(balanced.groups, balanced.inertia, balanced.length))
    recorded = fitted_recorded(data, NEAR, enough)
    states = states_of(recorded, model)
    noise = Noise.white(recorded.encoders, recorded.large_torque)
    searches = [GaussNewton(model, values, recorded, states, noise, CLOSE_ENOUGH) for values in begins]
    found, failures = best_of(searches[:1], most_steps=FEW_STEPS)
    if found and found.converged and not np.any(found.leaves_more):
        return found, ""  # from elsewhere it would be no likelier
    found, failures = best_of(searches)
    lost = ""
    if found is None:
        lost = f"the fit failed: {failures[0]}; check L, g and what the angles mean"
        found, failures = best_of(searches, most_steps=0)
    if found is None:
        raise IdentificationError(
            f"the paper's model cannot be fitted ({failures[0]}): check L, g and the nominal values"
        )
    return likelier_maximum(found), lost


def _weights_differ(fit: Sequence[Trial], holdout: Sequence[Trial]) -> bool:
    """Return whether weights show A22; raise `IdentificationError` where they would have to, but do not."""
    fitted, others = ({trial.weights for trial in trials} for trials in (fit, holdout))
    if len(fitted) == 1 and (fitted | others) != {()}:
        raise IdentificationError(
            "a weight shows A22 only beside a trial to fit without it, or with another one: give such a trial too, or "
            "leave those with the weight out"
        )
    return len(fitted) > 1


def _balance(trials: Sequence[Trial], prior: Prior) -> ForceBalance | None:
    """Return the balance of forces, with another L where the given one is not believed; None with too little motion."""
    try:
        pieces = Pieces.of(trials, prior.length, prior.gravity)
        given, free = (balance_of_forces(pieces, length_free) for length_free in (False, True))
    except (IdentificationError, np.linalg.LinAlgError):
        return None
    explains = free.unexplained.max() < _MOST_LEFT * given.unexplained.max()
    return free if explains and abs(free.length / prior.length - 1.0) > _ANOTHER else given

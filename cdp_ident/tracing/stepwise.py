"""Stepwise selection of the effects that a fitted model lacks: addition, exchange and pruning in turn."""

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from cdp_ident.diagnosis.cross_validation import Folds
from cdp_ident.diagnosis.failure import refuse_a_failed_fit
from cdp_ident.errors import FitFailedError, IdentificationError
from cdp_ident.fit.force_balance import ForceBalance
from cdp_ident.fit.noise import NO_STEPS
from cdp_ident.fit.refinement import Fit
from cdp_ident.fit.share import share_of
from cdp_ident.tracing.acceptance import fits_of
from cdp_ident.tracing.addition import add_balanced, add_effects
from cdp_ident.tracing.certainty import certainties
from cdp_ident.tracing.evidence import Attempt
from cdp_ident.tracing.exchange import alternatives, exchange_effects, try_states, try_without_states
from cdp_ident.tracing.expected import ExpectedEffect, begin_with
from cdp_ident.tracing.progress import InterruptedSelectionError, Progress
from cdp_ident.tracing.pruning import drop_repeated_impulses, drop_superfluous, drop_without_strength
from cdp_ident.tracing.refits import attempt_of
from cdp_ident.tracing.selection import Selection
from cdp_ident.tracing.typical_forms import try_typical_forms
from cdp_ident.tracing.unknown_torques import add_unknown_torques
from cdp_ident.tracing.whole import over_all, over_share
from cdp_ident.tracing.zeros import drop_superfluous_zeros, fit_zeros_by_trial, fit_zeros_by_trial_again

Array = npt.NDArray[np.float64]

_MOST_ROUNDS = 3
"""How often effects are added after others were exchanged."""


def stepwise_selection(
    fit: Fit,
    folds: Folds,
    noise: float,
    say: Callable[[str], None] = lambda line: None,
    stop: Callable[[], bool] = lambda: False,
    balances: Sequence[ForceBalance] = (),
    encoder_steps: Array = NO_STEPS,
    named_only: bool = False,
    trying: Callable[[str], None] = lambda line: None,
    expected: Sequence[ExpectedEffect] = (),
    enough: float = np.inf,
) -> Selection:
    """Add to a fitted model the effects that it lacks.

    Args:
        fit: the paper's model, fully fitted.
        folds: of its windows; effects are chosen by cross-validation over them.
        noise: root mean square of what the encoders add to both angles [rad].
        say: called with a line of text after each step.
        stop: asked between refits; true ends the selection with the effects found so far.
        encoder_steps: of the inner and the outer encoder [rad], 0 where none shows.
        balances: balances of forces of the trials; the selection begins with their dry friction and coupling.
        named_only: whether torques without a name are left out.
        trying: called with what is tried next.
        expected: effects found on the rig before, which are tried first.
        enough: motion in which effects are looked for, where there is more [s]; see `share`.

    Raises:
        FitFailedError: the model does not follow the motion with the effects either.
    """
    before, chosen = attempt_of(fit, folds), share_of(fit.windows, enough)
    is_share = len(chosen) < len(fit.windows)
    if is_share:
        say(f"effects are looked for in {len(chosen)} of {len(fit.windows)} windows, spread evenly over all trials")
    first = over_share(before, chosen) if is_share else before
    progress = Progress(first, noise, say, stop, encoder_steps, trying)

    def over_windows() -> None:
        begin_with(progress, expected)
        if progress.current is first:
            add_balanced(progress, balances)
        fit_zeros_by_trial(progress)
        progress.reweigh()
        _refuse_what_fails(progress)
        _select(progress)
        if not named_only:
            add_unknown_torques(progress)

    interrupted = _until_stopped(progress, over_windows)
    without = _without_each(progress)
    others = _others(progress, without)
    if is_share:
        found, progress = progress.current, progress.over(before)
        interrupted = _until_stopped(progress, lambda: over_all(progress, found)) or interrupted
        without = _without_each(progress)
        others |= _others(progress, without)
    after = progress.current
    also_possible = tuple(others.get(label, ()) for label in after.model.labels)
    return Selection(
        before=before,
        after=after,
        steps=tuple(progress.steps),
        without=tuple(without),
        also_possible=also_possible,
        certainty=certainties(progress, without, also_possible),
        failures=tuple(progress.failures),
        interrupted=interrupted,
        looked_in=len(chosen),
    )


def _refuse_what_fails(progress: Progress) -> None:
    """Raise `FitFailedError` where the model does not follow the motion, with richer forms of its effects either."""
    try:
        refuse_a_failed_fit(fits_of(progress.current), progress.noise)
    except FitFailedError:
        try_without_states(progress)
        refuse_a_failed_fit(fits_of(progress.current), progress.noise)


def _until_stopped(progress: Progress, work: Callable[[], None]) -> bool:
    """Work on a selection; return whether it was asked to stop. What cannot be computed ends it early.

    Raises:
        FitFailedError: the model does not follow the motion.
    """
    try:
        work()
    except InterruptedSelectionError:
        return True
    except FitFailedError:
        raise
    except (IdentificationError, np.linalg.LinAlgError) as error:
        progress.fail(f"the selection ended early: {error}")
    return False


def _others(progress: Progress, without: Sequence[Attempt]) -> dict[str, tuple[str, ...]]:
    """Return by the labels of effects what the data do not distinguish from each of those that had rivals."""
    current = progress.current
    return {
        label: alternatives(active, current, removed, progress.rivals[label])
        for active, label, removed in zip(current.model.effects, current.model.labels, without, strict=True)
        if label in progress.rivals
    }


def _without_each(progress: Progress) -> list[Attempt]:
    current = progress.current
    return progress.without_each(current, [[index] for index in range(len(current.model.effects))])


def _select(progress: Progress) -> None:
    try_states(progress, lambda effect: effect.remembers)
    for _ in range(_MOST_ROUNDS):
        add_effects(progress)
        progress.reweigh()
        progress.current = found = drop_superfluous(progress, progress.current, also_last=True)
        fit_zeros_by_trial_again(progress)
        exchange_effects(progress)
        if progress.current is found:
            break
        progress.current = drop_superfluous(progress, progress.current)
        drop_without_strength(progress)
        drop_superfluous_zeros(progress)
        progress.reweigh()
    drop_without_strength(progress)
    drop_repeated_impulses(progress)
    try_typical_forms(progress)

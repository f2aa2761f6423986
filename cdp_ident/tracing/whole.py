"""What a share of the motion showed, fitted to all of it, and what only all of it shows."""

from cdp_ident.diagnosis.cross_validation import Folds
from cdp_ident.fit.refinement import refine
from cdp_ident.tracing.addition import add_weak_effects
from cdp_ident.tracing.evidence import Attempt
from cdp_ident.tracing.progress import Progress
from cdp_ident.tracing.pruning import drop_superfluous
from cdp_ident.tracing.refits import attempt_of


def over_share(whole: Attempt, chosen: tuple[int, ...]) -> Attempt:
    """Return a model refitted over some windows, by their indices; those of a fold stay together.

    Raises:
        IdentificationError: it cannot be fitted.
    """
    place = {index: order for order, index in enumerate(chosen)}
    folds: Folds = tuple(tuple(place[index] for index in fold if index in place) for fold in whole.folds)
    fit = refine(whole.model, whole.fit.values, [whole.fit.windows[index] for index in chosen])
    return attempt_of(fit, tuple(fold for fold in folds if fold))


def over_all(progress: Progress, found: Attempt) -> None:
    """Fit what a share of the motion showed to all of it, drop what all of it does not bear out, and look for more.

    Args:
        progress: of the selection over all windows, with the paper's model.
        found: the model that the share showed.

    Raises:
        InterruptedSelectionError: the selection is asked to stop; what was found is fitted to all nevertheless.
        IdentificationError, LinAlgError: it cannot be fitted.
    """
    windows = len(progress.current.fit.windows)
    progress.say(f"what was found is fitted to all {windows} windows")
    progress.current = progress.adopted(found)
    progress.reweigh()
    progress.current = drop_superfluous(progress, progress.current, also_last=True)
    progress.go_on()
    progress.say(f"more effects are looked for in all {windows} windows, by one score test")
    known = progress.current
    try:
        _leave_out_events(progress)
        add_weak_effects(progress)
    finally:
        if progress.current.validation.squared_error > known.validation.squared_error:
            progress.current = known  # events that were not found again, or not yet


def _leave_out_events(progress: Progress) -> None:
    """Leave out what happened at an instant: it may have been between the share's windows, and is looked for again."""
    current = progress.current
    events = [index for index, active in enumerate(current.model.effects) if active.effect.at_an_instant]
    if events:
        progress.current = progress.finished(progress.without(current, events))

"""Backward steps: effects that no longer improve the model are dropped."""

from cdp_ident.tracing import thresholds
from cdp_ident.tracing.acceptance import is_accepted, still_helps
from cdp_ident.tracing.evidence import Attempt
from cdp_ident.tracing.instants import instants
from cdp_ident.tracing.progress import Progress

_NO_STRENGTH = 1.0
"""Standard deviations within which an effect's strength is none."""


def drop_superfluous(progress: Progress, attempt: Attempt, also_last: bool = False) -> Attempt:
    """Return a model without the effects that do not help, beside its last one unless that is tested too."""
    others = list(reversed(range(len(attempt.model.effects) - (0 if also_last else 1))))
    progress.without_each(attempt, [[index] for index in others if attempt.strength(index) <= thresholds.SAFE])
    for index in others:
        if attempt.strength(index) > thresholds.SAFE:
            continue
        removed = progress.without(attempt, [index])
        effect = attempt.model.effects[index].effect
        rounding = _is_rounding(progress, attempt, index)
        if rounding or not still_helps(attempt, removed, effect):
            attempt = removed
            _note(progress, effect.key, attempt, "it is rounding" if rounding else "it no longer helps")
    return progress.finished(attempt) if attempt.is_condensed else attempt


def _is_rounding(progress: Progress, attempt: Attempt, index: int) -> bool:
    """Return whether counts that an encoder lost are less than one, beside the other effects."""
    effect, place = attempt.model.effects[index].effect, attempt.model.places(index)
    lost = not effect.moves and effect.at_an_instant
    return lost and progress.is_rounding(effect.joint, float(attempt.fit.values[place][0]))


def without_superfluous_ones(progress: Progress, attempt: Attempt) -> Attempt:
    """Return a model with only those of its effects that are accepted beside the others; the weakest go first."""
    for index in sorted(range(len(attempt.model.effects)), key=attempt.strength):
        removed = progress.without(attempt, [index])
        if not is_accepted(removed, attempt, [index]):
            return without_superfluous_ones(progress, removed)
    return attempt


def drop_without_strength(progress: Progress) -> None:
    """Drop effects with states of their own that have no strength: the initial values of these may gain still.

    Raises:
        InterruptedSelectionError: the selection is asked to stop.
    """
    for index in reversed(range(len(progress.current.model.effects))):
        effect = progress.current.model.effects[index].effect
        if effect.brings_states and progress.current.strength(index) < _NO_STRENGTH:
            progress.current = progress.finished(progress.without(progress.current, [index]))
            _note(progress, effect.key, progress.current, "it has no strength")


def drop_repeated_impulses(progress: Progress) -> None:
    """Drop an impulse where others at other instants would help, too: it imitates a lasting effect."""
    for index in reversed(range(len(progress.current.model.effects))):
        current = progress.current
        effect = current.model.effects[index].effect
        if not (effect.moves and effect.at_an_instant):
            continue
        removed = progress.without(current, [index])
        gain = removed.fit.squared_error - current.fit.squared_error
        if any(gain < thresholds.IMPULSE_ALONE * another.gain for another in instants(current.fit)):
            progress.current = removed
            _note(progress, effect.key, removed, "impulses at other instants would explain something, too")


def _note(progress: Progress, key: str, after: Attempt, reason: str) -> None:
    progress.note(f"dropped {key}", after, f"dropped {key}: {reason}")

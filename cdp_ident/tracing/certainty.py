"""How sure the names of effects are; whether they predict motion was tested when they were added.

A model of a real rig always leaves an error, and an effect may only imitate a part of one that is not in the catalogue.
So a name is the surer the more the effect explains relative to the error that remains, and the fewer other effects
could be in its place.
"""

from collections.abc import Sequence
from dataclasses import replace

from cdp_ident.tracing import thresholds
from cdp_ident.tracing.acceptance import share_explained
from cdp_ident.tracing.evidence import Attempt
from cdp_ident.tracing.final_model import FinalModel
from cdp_ident.tracing.progress import Progress
from cdp_ident.tracing.selection import Certainty, Selection

_AS_WELL = 1.5
"""Held-out motion with at most so many times the fit's error is followed as well as that which was fitted."""


def certainties(
    progress: Progress, without: Sequence[Attempt], also_possible: Sequence[Sequence[str]]
) -> tuple[Certainty, ...]:
    """Return how sure the name of each effect of a model is.

    Args:
        progress: where the selection of the effects has ended.
        without: the model without each of them.
        also_possible: others that could be in each one's place.
    """
    current = progress.current
    explained = [share_explained(current, removed, progress.noise) for removed in without]
    effects = [active.effect for active in current.model.effects]
    lasting = [k for k, effect in enumerate(effects) if not (effect.at_an_instant or effect.curve)]
    weak = [k for k in lasting if explained[k] < thresholds.NAMED]
    together = 0.0
    if len(weak) > 1:
        together = share_explained(current, progress.without(current, weak), progress.noise)
    found: list[Certainty] = []
    for k, (effect, share) in enumerate(zip(effects, explained, strict=True)):
        if effect.curve:
            found.append("acts_like")  # it has no name
            continue
        with_others = together > thresholds.NAMED and share > thresholds.NAMED_WITH_OTHERS
        if effect.at_an_instant or share >= thresholds.NAMED or with_others:
            # An effect of an instant was tested by its window when it was added.
            found.append("probable" if also_possible[k] else "named")
        else:
            found.append("acts_like")
    return tuple(found)


def confirmed(selection: Selection, before: FinalModel, after: FinalModel) -> Selection:
    """Return a selection with names as sure as they are when held-out motion has been looked at.

    Effects that imitate something else over the fitted motion need not do so elsewhere. So where held-out motion is
    followed much worse than the fitted one, they must explain more of its error than remains to keep their names. An
    effect of an instant is not in held-out motion.

    Args:
        selection: where it ended.
        before: the paper's model.
        after: the model with the effects.
    """
    explained = before.holdout.rmse() ** 2 - after.holdout.rmse() ** 2
    remaining = after.holdout.rmse() ** 2 - after.fit.rmse() ** 2
    if not (after.holdout.rmse() > _AS_WELL * after.fit.rmse() and explained < thresholds.NAMED * remaining):
        return selection
    effects = (active.effect for active in after.model.effects)
    pairs = zip(effects, selection.certainty, strict=True)
    return replace(
        selection, certainty=tuple(found if effect.at_an_instant else "acts_like" for effect, found in pairs)
    )

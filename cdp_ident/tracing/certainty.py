"""How sure the names of effects are; whether they predict motion was tested when they were added.

A model of a real rig always leaves an error, and an effect may only imitate a part of one that is not in the catalogue.
So a name is the surer the more the effect explains relative to the error that remains, and the fewer other effects
could be in its place.
"""

from collections.abc import Sequence

from cdp_ident.tracing import thresholds
from cdp_ident.tracing.acceptance import share_explained
from cdp_ident.tracing.evidence import Attempt
from cdp_ident.tracing.progress import Progress
from cdp_ident.tracing.selection import Certainty


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

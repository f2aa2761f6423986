"""How sure the names of effects are, apart from whether they predict motion: that was asked when they were added.

A real rig always leaves something, and an effect may be no more than the part of it that the effect can imitate. So a
name is the surer the more the effect explains beside what remains, and the fewer others could stand in its place.
"""

from collections.abc import Sequence

from cdp_ident.tracing.acceptance import share_explained
from cdp_ident.tracing.evidence import Attempt
from cdp_ident.tracing.progress import Progress, without_effects
from cdp_ident.tracing.selection import Certainty

NAMED, _NAMED_WITH_OTHERS = 1.5, 0.5
"""What an effect must explain over what remains to be named; less, where it explains so much together with others."""


def certainties(
    progress: Progress, without: Sequence[Attempt], also_possible: Sequence[Sequence[str]]
) -> tuple[Certainty, ...]:
    """Return how sure the name of each effect of a model is.

    Args:
        progress: where the selection of the effects has ended.
        without: the model without each of them.
        also_possible: others that could stand in each one's place.
    """
    current = progress.current
    explained = [share_explained(current, removed, progress.noise) for removed in without]
    effects = [active.effect for active in current.model.effects]
    judged = [k for k, effect in enumerate(effects) if not (effect.at_an_instant or effect.curve)]
    weak = [k for k in judged if explained[k] < NAMED]
    together = 0.0
    if len(weak) > 1:
        together = share_explained(current, without_effects(current, weak), progress.noise)
    found: list[Certainty] = []
    for k, (effect, share) in enumerate(zip(effects, explained, strict=True)):
        if effect.curve:
            found.append("acts_like")  # it has no name
            continue
        with_others = together > NAMED and share > _NAMED_WITH_OTHERS
        if effect.at_an_instant or share >= NAMED or with_others:
            # What happened once has its window, which was looked at when it was added.
            found.append("probable" if also_possible[k] else "named")
        else:
            found.append("acts_like")
    return tuple(found)

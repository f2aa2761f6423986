# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From a fitted paper's model to the effects that it lacks."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.diagnosis.identification import Identification
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.fit.windows import shared
from cdp_ident.likelihood.scores import Score
from cdp_ident.likelihood.whole_swing import WholeSwings
from cdp_ident.model.effects.effect import Effect
from cdp_ident.tracing.certainty import certainties, not_distinguished, probabilities
from cdp_ident.tracing.model_search import InterruptedSearchError, ModelSearch
from cdp_ident.tracing.neighbours import Neighbour
from cdp_ident.tracing.over_windows import OverWindows
from cdp_ident.tracing.selection import Selection, Step
from cdp_ident.tracing.suggestions import suggestions


@dataclass(frozen=True)
class ExpectedEffect:
    """An effect that was found on the rig before."""

    effect: Effect
    values: Array
    """(k,) of its fitted parameters, torques over A22."""
    std: Array
    """(k,) their standard deviations."""


def select_effects(
    found: Identification,
    say: Callable[[str], None] = lambda line: None,
    stop: Callable[[], bool] = lambda: False,
    trying: Callable[[str], None] = lambda line: None,
    expected: Sequence[ExpectedEffect] = (),
) -> Selection:
    """Return the effects that make a paper's model the most probable one.

    Args:
        found: the paper's model, identified.
        say: called with a line of text after each step.
        stop: asked repeatedly; true ends the search with the effects found so far.
        trying: called with what is tried next.
        expected: effects found on the rig before, which are tried first.
    """
    data = found.data.over_shorter_windows(found.data.scales.half_swing)
    errors = OverWindows(shared(data.fit, found.enough), data.noise)
    search = ModelSearch(found.whole, found.options.named_effects_only, errors, say, stop, trying)
    interrupted = False
    try:
        search.begin_with(_expected(found, expected), "confirmed")
        search.run([*suggestions(search.paper)] if search.best is search.paper else ())
    except InterruptedSearchError:
        interrupted = True
    except (IdentificationError, np.linalg.LinAlgError) as error:
        search.failures.append(f"the search ended early: {error}")
    best, count = search.best, len(search.best.model.effects)
    without = tuple[WholeSwings | None, ...]()
    try:
        without = () if interrupted else tuple(map(search.without, range(count)))
    except InterruptedSearchError:
        interrupted = True
    except (IdentificationError, np.linalg.LinAlgError) as error:
        search.failures.append(f"the model without each effect: {error}")
    scored = _scored(search)
    probability, also_possible = probabilities(search), not_distinguished(search)
    return Selection(
        before=search.paper,
        after=best,
        steps=tuple(search.steps),
        without=without or (None,) * count,
        probability=probability,
        also_possible=also_possible,
        certainty=certainties(search, probability, also_possible),
        scores=scored,
        failures=tuple(search.failures),
        interrupted=interrupted,
        looked_in=float(sum(swing.time[-1] for swing in found.whole.recorded.swings)),
    )


def _scored(search: ModelSearch) -> tuple[Score, ...]:
    """Return what other effects would do for the best model of a search; nothing where that cannot be computed."""
    try:
        return tuple(search.scores)
    except (IdentificationError, np.linalg.LinAlgError) as error:
        search.failures.append(f"what other effects would do: {error}")
        return ()


def withdrawn_from(selection: Selection, index: int | None, options: IdentifyOptions) -> Selection:
    """Return a selection from which an effect is withdrawn, or all of them (None): the others are as sure as before.

    Raises:
        IdentificationError: the model without it cannot be computed.
    """
    effects = selection.after.model.effects
    after = selection.before if index is None else selection.without[index]
    if after is None:
        raise IdentificationError("the model without that effect cannot be fitted")
    kept = [k for k in range(len(effects)) if index not in (None, k)]
    what = " and ".join(active.key for k, active in enumerate(effects) if k not in kept)
    step = Step(f"withdrawn, as held-out motion is predicted worse: {what}", after.misfit - selection.before.misfit, ())
    search = ModelSearch(selection.before, options.named_effects_only, begin=after)
    without = tuple(search.without(place) for place in range(len(kept)))
    scored = _scored(search)
    return replace(
        selection,
        after=after,
        steps=(*selection.steps, step),
        without=without,
        probability=tuple(selection.probability[k] for k in kept),
        also_possible=tuple(selection.also_possible[k] for k in kept),
        certainty=tuple(selection.certainty[k] for k in kept),
        scores=scored,
        failures=(*selection.failures, *search.failures),
    )


def _expected(found: Identification, expected: Sequence[ExpectedEffect]) -> Iterator[Neighbour]:
    """Yield the model with the effects that are expected."""
    if expected:
        model, values = found.whole.model, found.whole.values
        for one in expected:
            model, values = model.with_effect(ActiveEffect(one.effect)), np.concatenate([values, one.values])
        yield Neighbour(model, values, tuple(one.effect.key for one in expected), found.whole)

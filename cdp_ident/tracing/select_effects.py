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
from cdp_ident.fit.windows import shared
from cdp_ident.likelihood.whole_swing import WholeSwings
from cdp_ident.model.effects.effect import Effect
from cdp_ident.tracing.certainty import certainties, not_distinguished, probabilities
from cdp_ident.tracing.model_search import InterruptedSearchError, ModelSearch
from cdp_ident.tracing.neighbours import Neighbour, scores_of
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
    search = ModelSearch(found.whole, say, stop, trying, found.options.named_effects_only, errors)
    interrupted, without = False, tuple[WholeSwings | None, ...]()
    try:
        search.begin_with(_expected(found, expected), "confirmed")
        search.run([*suggestions(search.paper)] if search.best is search.paper else ())
        without = tuple(search.without(index) for index in range(len(search.best.model.effects)))
    except InterruptedSearchError:
        interrupted = True
    except (IdentificationError, np.linalg.LinAlgError) as error:
        search.failures.append(f"the search ended early: {error}")
    without = without or (None,) * len(search.best.model.effects)
    try:
        scored = tuple(search.scores)
    except (IdentificationError, np.linalg.LinAlgError) as error:
        search.failures.append(f"what other effects would do: {error}")
        scored = ()
    probability, also_possible = probabilities(search), not_distinguished(search)
    return Selection(
        before=search.paper,
        after=search.best,
        steps=tuple(search.steps),
        without=without,
        probability=probability,
        also_possible=also_possible,
        certainty=certainties(search, probability, also_possible),
        scores=scored,
        failures=tuple(search.failures),
        interrupted=interrupted,
        looked_in=float(sum(swing.time[-1] for swing in found.whole.recorded.swings)),
    )


def withdrawn_from(selection: Selection, named_only: bool) -> Selection:
    """Return a selection whose effects are withdrawn: it ends where it began.

    Args:
        selection: with effects.
        named_only: whether nonparametric torques are left out.
    """
    paper = selection.before
    last = Step("withdrawn, as held-out motion is predicted worse", 0.0, ())
    return replace(
        selection, after=paper, steps=(*selection.steps, last), without=(), probability=(), also_possible=(),
        certainty=(), scores=tuple(scores_of(paper, named_only)),
    )  # fmt: skip


def _expected(found: Identification, expected: Sequence[ExpectedEffect]) -> Iterator[Neighbour]:
    """Yield the model with the effects that are expected."""
    if expected:
        model, values = found.whole.model, found.whole.values
        for one in expected:
            model, values = model.with_effect(ActiveEffect(one.effect)), np.concatenate([values, one.values])
        yield Neighbour(model, values, tuple(one.effect.key for one in expected), found.whole)

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which effects carry over to the motion that was held out: what does not is not in the model."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cdp_ident.diagnosis.identification import Identification
from cdp_ident.tracing.final_model import FinalModel, is_worse
from cdp_ident.tracing.select_effects import withdrawn_from
from cdp_ident.tracing.selection import Selection


@dataclass(frozen=True)
class Withdrawn:
    """Effects that were found, and with which what was held out is predicted worse."""

    effects: tuple[str, ...]
    """Their keys."""
    holdout: float
    """Error over what was held out of the model with all that was found [rad]."""


def what_carries_over(
    before: FinalModel, after: FinalModel, selection: Selection, found: Identification
) -> tuple[FinalModel, Selection, Sequence[float], Withdrawn | None]:
    """Return a model without the effects with which held-out motion is predicted worse, and its selection.

    Beside nothing but noise the effects are to carry over together. Where torques are missing that no law gives, each
    is to: it may follow a part of what is missing in what was fitted.

    The others are the errors over what was held out without each effect [rad], not a number where one cannot be
    computed, and what was withdrawn.

    Raises:
        IdentificationError, LinAlgError: a model cannot be evaluated.
    """
    keys, holdout = list[str](), after.holdout.rmse()
    while True:
        effects, error = selection.after.model.effects, after.holdout.rmse()
        without = [after.error_of(other) if other else float("nan") for other in selection.without]
        least = np.nanmin([*without, np.inf])
        each_is_to = len(effects) > 1 and np.any(selection.after.is_missing)
        index = without.index(least) if each_is_to and is_worse(error, least) else None
        if index is None and not (effects and is_worse(error, before.holdout.rmse())):
            return after, selection, without, Withdrawn(tuple(keys), holdout) if keys else None
        keys += [active.key for active in (effects if index is None else [effects[index]])]
        selection = withdrawn_from(selection, index, found.options)
        after = before if index is None else FinalModel.of(selection.after, found.data)

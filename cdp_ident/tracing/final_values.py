# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The final values of a chosen model: those of everything that was measured, once what was held out has judged it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.data import Data
from cdp_ident.likelihood.gauss_newton import GaussNewton
from cdp_ident.likelihood.maxima import (
    CLOSE_ENOUGH,
    ENOUGH_STEPS,
    NEAR,
    most_likely,
    values_with_less_torque,
)
from cdp_ident.likelihood.noise import Noise
from cdp_ident.likelihood.recorded import all_recorded, states_of
from cdp_ident.likelihood.whole_swing import Recorded, WholeSwings
from cdp_ident.tracing.final_model import FinalModel


@dataclass(frozen=True)
class FinalValues:
    """Values given all that was measured."""

    values: Array
    """(unknowns,)"""
    covariance: Array
    """(unknowns, unknowns)"""
    whole: WholeSwings | None
    """Whole swings, fitted; None where that failed."""
    failures: tuple[str, ...]
    """What could not be computed, in words."""


def final_values(after: FinalModel, chosen: WholeSwings, data: Data, say: Callable[[str], None]) -> FinalValues:
    """Return the values given all that was measured, what was held out among it.

    With less unknown torque they are uncertain by how far they are from the most likely ones, too. Where trials differ
    from one another, nobody knows by how much those do that were held out, and values are those of what was fitted.

    Args:
        after: the chosen model, as it was judged.
        chosen: the same, as it was chosen.
        data: what was measured.
        say: called with a line of text.
    """
    others = set(range(len(data.trials))) - set(chosen.recorded.trials)
    if others and any(active.is_difference for active in after.model.effects):
        say("trials differ from one another: the final values are those of the trials that were fitted")
        return FinalValues(after.fit.values, chosen.covariance, chosen, ())
    try:
        whole = _whole_swings(after, chosen, data)
        values = values_with_less_torque(whole) if after.less_torque else whole.values
    except (IdentificationError, np.linalg.LinAlgError) as error:
        return FinalValues(after.fit.values, chosen.covariance, None, (f"values from whole swings: {error}",))
    say(f"{len(whole.states)} whole swings are fitted in {whole.steps} steps")
    if after.less_torque:
        say("values with less unknown torque predict what was held out better: they are the final ones")
    return FinalValues(values, whole.covariance + np.outer(values - whole.values, values - whole.values), whole, ())


def _whole_swings(after: FinalModel, chosen: WholeSwings, data: Data) -> WholeSwings:
    """Return a model's most likely values given whole swings.

    Raises:
        IdentificationError, LinAlgError: they are not found.
    """

    def with_nodes(spacing: float) -> tuple[Recorded, Sequence[Array]]:
        recorded = all_recorded(data, spacing)
        return recorded, states_of(recorded, after.model)

    if np.any(chosen.is_missing):
        recorded, states = with_nodes(NEAR)
        noise = replace(Noise.white(recorded.encoders, 0.0), torque=chosen.noise.torque, of_base=chosen.noise.of_base)
        found = GaussNewton(after.model, after.fit.values, recorded, states, noise).run().found()
        if not found.converged:  # where joints stick now here and now there, steps may stay larger than they need be
            again = GaussNewton(found.model, found.values, recorded, found.states, found.noise, CLOSE_ENOUGH)
            found = again.run(ENOUGH_STEPS).found()
        return found
    return most_likely(after.model, after.fit.values, with_nodes)

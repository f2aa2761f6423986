# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A chosen model, evaluated by the motion that was held out, and its values given all that was measured."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.data import Data
from cdp_ident.fit.initial_states import Fit, fit_initial_states
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.likelihood.gauss_newton import MOST_STEPS, GaussNewton
from cdp_ident.likelihood.maxima import (
    CLOSE_ENOUGH,
    NEAR,
    best_of,
    most_likely,
    with_less_torque,
)
from cdp_ident.likelihood.noise import Noise
from cdp_ident.likelihood.recorded import all_recorded, states_of
from cdp_ident.likelihood.whole_swing import Recorded, WholeSwings

_CLEARLY = 0.9
"""Values with less unknown torque are taken where their error is at most this share of that of the most likely ones:
by chance either predicts somewhat better, and the most likely ones are the more exact."""
_WORSE = 1.02
"""From so many times the error on, a model is worse than another one beyond chance."""


def is_worse(error: float, other: float) -> bool:
    """Return whether an error is larger than another one beyond chance, or not a number."""
    return not error <= _WORSE * other


@dataclass(frozen=True)
class FinalModel:
    """A model as it is reported."""

    fit: Fit
    """Over the windows that were fitted, its values held."""
    holdout: Fit
    """Over those that were held out, likewise."""
    less_torque: bool
    """Whether its values are not the most likely ones, but those with less unknown torque: they predict better."""

    @property
    def model(self) -> MotionModel:
        """The model that was fitted."""
        return self.fit.model

    @classmethod
    def of(cls, found: WholeSwings, data: Data, followed: Fit | None = None) -> "FinalModel":
        """Evaluate a model; where torques are missing, what was held out judges which values predict better.

        Args:
            found: given whole swings.
            data: windows, fitted and held out.
            followed: the windows that were fitted under the model's values, where they were followed before.

        Raises:
            IdentificationError, LinAlgError: no motion can be computed.
        """
        likely = cls._with(found, found.values, False, data, followed)
        if not np.any(found.is_missing):
            return likely
        try:
            other = cls._with(found, with_less_torque(found).values, True, data)
        except (IdentificationError, np.linalg.LinAlgError):
            return likely
        return other if other.holdout.rmse() < _CLEARLY * likely.holdout.rmse() else likely

    @classmethod
    def _with(
        cls, found: WholeSwings, values: Array, less_torque: bool, data: Data, followed: Fit | None = None
    ) -> "FinalModel":
        followed = followed or fit_initial_states(found.model, values, data.fit)
        return cls(followed, fit_initial_states(found.model, values, data.holdout), less_torque)

    def error_of(self, found: WholeSwings) -> float:
        """Return the error of another model, with values of the same kind, over what was held out [rad].

        Not a number where it cannot be computed.
        """
        try:
            less = self.less_torque and bool(np.any(found.is_missing))
            values = with_less_torque(found).values if less else found.values
            return fit_initial_states(found.model, values, self.holdout.windows).rmse()
        except (IdentificationError, np.linalg.LinAlgError):
            return float("nan")


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
        values = with_less_torque(whole).values if after.less_torque else whole.values
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

    found = None
    if np.any(chosen.is_missing):
        recorded, states = with_nodes(NEAR)
        noise = replace(Noise.white(recorded.encoders, 0.0), torque=chosen.noise.torque, of_base=chosen.noise.of_base)
        begun = GaussNewton(after.model, after.fit.values, recorded, states, noise)
        found, _ = best_of([begun], most_steps=MOST_STEPS)
        if found and not found.converged:  # where joints stick now here and now there, steps may stay large
            again = GaussNewton(found.model, found.values, recorded, found.states, found.noise, CLOSE_ENOUGH)
            found = best_of([again])[0] or found
        if found and found.converged:
            return found
    try:
        return most_likely(after.model, after.fit.values, with_nodes)
    except (IdentificationError, np.linalg.LinAlgError):
        if found is None:
            raise
        return found

"""The final values of a chosen model: those of everything that was measured, once what was held out has judged it.

There are two estimates of the values. That of whole swings is the efficient one: where nothing is missing, or torques
that go up and down by chance, no other is as exact. Where something is missing that is the same each time, the values
may make up for a part of it over some seconds, and those fitted over windows predict better.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.diagnosis.uncertainty import covariance
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.data import Data
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.refinement import Fit, fit_initial_states_near, refine, with_all_derivatives
from cdp_ident.fit.windows import Window
from cdp_ident.likelihood.noise import Noise
from cdp_ident.likelihood.whole_swing import NEAR, Recorded, WholeSwings, likely_near, most_likely
from cdp_ident.tracing.final_model import FinalModel
from cdp_ident.tracing.recorded import all_recorded, states_of

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class FinalValues:
    """Values given all that was measured."""

    values: Array
    """(unknowns,)"""
    covariance: Array
    """(unknowns, unknowns)"""
    whole: WholeSwings | None
    """Whole swings, fitted; None where that failed."""
    by_windows: bool
    """Whether the values are not these, but were fitted over windows."""
    failures: tuple[str, ...]
    """What could not be computed, in words."""


def final_values(
    after: FinalModel, chosen: WholeSwings, data: Data, by_windows: bool, say: Callable[[str], None]
) -> FinalValues:
    """Return the values given all that was measured, what was held out among it.

    Args:
        after: the chosen model, as it was judged.
        chosen: the same, as it was chosen.
        data: what was measured.
        by_windows: whether values fitted over windows predict better.
        say: called with a line of text.
    """
    windows, failures = (*after.fit.windows, *after.holdout.windows), list[str]()
    values, spread, whole = after.fit.values, chosen.covariance, None
    try:
        whole = _whole_swings(after, chosen, data, windows)
        values, spread = whole.values, whole.covariance
        say(f"{len(whole.states)} whole swings are fitted in {whole.steps} steps")
    except (IdentificationError, np.linalg.LinAlgError) as error:
        failures.append(f"values from whole swings: {error}")
    if by_windows or whole is None:
        by_windows = True
        try:
            fit, held = over_windows(after.model, after.fit.values, windows), _held(after.model)
            values, spread = fit.values, covariance(fit, held)
            spread[np.ix_(held, held)] = chosen.covariance[np.ix_(held, held)]
            say("values fitted over windows predict what was held out better: they are the final ones")
        except (IdentificationError, np.linalg.LinAlgError) as error:
            by_windows = whole is None
            failures.append(f"values from all windows: {error}")
    return FinalValues(values, spread, whole, by_windows, tuple(failures))


def _whole_swings(after: FinalModel, chosen: WholeSwings, data: Data, windows: Sequence[Window]) -> WholeSwings:
    """Return a model's most likely values given whole swings.

    Raises:
        IdentificationError, LinAlgError: they are not found.
    """

    def with_nodes(spacing: float) -> tuple[Recorded, Sequence[Array]]:
        recorded = all_recorded(data, spacing)
        return recorded, states_of(recorded, after.model, after.fit.values, windows)

    if np.any(chosen.is_missing):
        recorded, states = with_nodes(NEAR)
        noise = Noise.white(recorded.encoders, 0.0).with_torque_of_at_least(chosen.noise.torque)
        found = likely_near(after.model, after.fit.values, recorded, states, noise)
        if found.converged:
            return found
    return most_likely(after.model, after.fit.values, with_nodes)


def over_windows(model: MotionModel, values: Array, windows: Sequence[Window]) -> Fit:
    """Return a model fitted over windows; curves and what happens at an instant keep their values.

    Windows alone do not determine these.

    Args:
        model: gives the motion.
        values: (unknowns,) to begin with.
        windows: with initial states of this model or another one.

    Raises:
        IdentificationError, LinAlgError: it cannot be fitted.
    """
    begun = fit_initial_states_near(model, values, windows, np.inf)
    return with_all_derivatives(refine(model, values, begun.windows, held=_held(model)))


def _held(model: MotionModel) -> list[int]:
    """Return which unknowns keep their values over windows."""
    return [
        place
        for index, active in enumerate(model.effects)
        if active.effect.curve or active.effect.at_an_instant
        for place in range(*model.places(index).indices(len(model.names)))
    ]


def at_values(model: MotionModel, values: Array, windows: Sequence[Window]) -> Fit:
    """Return a model with given values (unknowns,) over windows, all initial states fitted anew.

    Args:
        model: gives the motion.
        values: (unknowns,) near those that the windows' initial states belong to.
        windows: with initial states of this model or another one.

    Raises:
        IdentificationError, LinAlgError: no motion can be computed.
    """
    return with_all_derivatives(fit_initial_states_near(model, values, windows, np.inf))

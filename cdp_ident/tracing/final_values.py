"""The final values of a chosen model: those of everything that was measured, once what was held out has judged it."""

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.data import Data
from cdp_ident.fit.refinement import Fit, fit_initial_states_near, with_all_derivatives
from cdp_ident.likelihood.noise import Noise
from cdp_ident.likelihood.whole_swing import NEAR, Recorded, WholeSwings, likely_near, most_likely
from cdp_ident.tracing.final_model import FinalModel
from cdp_ident.tracing.recorded import all_recorded, states_of

Array = npt.NDArray[np.float64]


def final_values(
    after: FinalModel, chosen: WholeSwings, data: Data, say: Callable[[str], None]
) -> tuple[WholeSwings | None, tuple[str, ...]]:
    """Return the most likely values given whole swings, those held out among them.

    With them comes why there are none, in words, where they were not found.

    Args:
        after: the chosen model, as it was judged.
        chosen: the same, as it was chosen.
        data: what was measured.
        say: called with a line of text.
    """
    windows = (*after.fit.windows, *after.holdout.windows)

    def with_nodes(spacing: float) -> tuple[Recorded, Sequence[Array]]:
        recorded = all_recorded(data, spacing)
        return recorded, states_of(recorded, after.model, after.fit.values, windows)

    try:
        found = None
        if np.any(chosen.is_missing):
            recorded, states = with_nodes(NEAR)
            noise = Noise.white(recorded.encoders, 0.0).with_torque_of_at_least(chosen.noise.torque)
            found = likely_near(after.model, after.fit.values, recorded, states, noise)
        if found is None or not found.converged:
            found = most_likely(after.model, after.fit.values, with_nodes)
    except (IdentificationError, np.linalg.LinAlgError) as error:
        return None, (f"values from whole swings: {error}",)
    say(f"the values are those of {len(found.states)} whole swings, found in {found.steps} steps")
    return found, ()


def with_values(fit: Fit, values: Array) -> Fit:
    """Return a fit with other values (unknowns,) near its own, all initial states fitted anew."""
    return with_all_derivatives(fit_initial_states_near(fit.model, values, fit.windows, np.inf))

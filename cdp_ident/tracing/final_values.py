"""The final values of a chosen model: those of everything that was measured, once what was held out has judged it."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.data import Data
from cdp_ident.fit.refinement import Fit, fit_initial_states_near, with_all_derivatives
from cdp_ident.likelihood.swing import Swing
from cdp_ident.likelihood.whole_swing import Recorded, WholeSwings, most_likely
from cdp_ident.tracing.final_model import FinalModel

Array = npt.NDArray[np.float64]

_LEAST_SHARE = 0.3
"""The outer encoder's noise is at least so much of the inner one's."""


def final_values(
    after: FinalModel, data: Data, say: Callable[[str], None]
) -> tuple[WholeSwings | None, tuple[str, ...]]:
    """Return the most likely values given whole swings, those held out among them.

    With them comes why there are none, in words, where they were not found.

    Args:
        after: the chosen model, as it was judged.
        data: what was measured.
        say: called with a line of text.
    """
    windows = (*after.fit.windows, *after.holdout.windows)

    def recorded_with(spacing: float) -> tuple[Recorded, list[Array]]:
        recorded = _recorded(data, spacing)
        return recorded, [swing.states(after.model, after.fit.values, windows) for swing in recorded.swings]

    try:
        found = most_likely(after.model, after.fit.values, recorded_with)
    except (IdentificationError, np.linalg.LinAlgError) as error:
        return None, (f"values from whole swings: {error}",)
    say(f"the values are those of {len(found.states)} whole swings, found in {found.steps} steps")
    return found, ()


def _recorded(data: Data, spacing: float) -> Recorded:
    """Return everything as it was measured, with nodes of a spacing in time units."""
    scales = data.scales
    nodes = spacing * scales.time_unit
    swings = [
        swing
        for index, (trial, of_fit) in enumerate(zip(data.measured, data.trials, strict=True))
        for swing in Swing.of(
            trial, index, scales.step, nodes, scales.half_width, scales.encoder_steps, trial.start - of_fit.start
        )
    ]
    inner, both = data.noise**2
    encoders = np.sqrt([inner, max(both - inner, _LEAST_SHARE**2 * inner)])
    return Recorded(tuple(swings), encoders, scales.time_unit)


def with_values(fit: Fit, values: Array) -> Fit:
    """Return a fit with other values (unknowns,) near its own, all initial states fitted anew."""
    return with_all_derivatives(fit_initial_states_near(fit.model, values, fit.windows, np.inf))

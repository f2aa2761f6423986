"""The final values of a chosen model: those of whole swings, once what was held out has judged it."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.data import Data
from cdp_ident.fit.refinement import Fit, fit_initial_states_near, with_all_derivatives
from cdp_ident.likelihood.swing import Swing
from cdp_ident.likelihood.whole_swing import WholeSwings, most_likely
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
    fit, scales = after.fit, data.scales
    windows = (*fit.windows, *after.holdout.windows)

    def swings_with(spacing: float) -> tuple[list[Swing], list[Array]]:
        swings = [
            swing
            for index, (trial, of_fit) in enumerate(zip(data.measured, data.trials, strict=True))
            for swing in Swing.of(
                trial, index, scales.step, spacing, scales.half_width, scales.encoder_steps, trial.start - of_fit.start
            )
        ]
        return swings, [swing.states(fit.model, fit.values, windows) for swing in swings]

    try:
        found = most_likely(fit.model, fit.values, swings_with, _of_encoders(data.noise), scales.time_unit)
    except (IdentificationError, np.linalg.LinAlgError) as error:
        return None, (f"values from whole swings: {error}",)
    say(f"the values are those of {len(found.states)} whole swings, found in {found.steps} steps")
    return found, ()


def with_values(fit: Fit, values: Array) -> Fit:
    """Return a fit with other values (unknowns,) near its own, all initial states fitted anew."""
    return with_all_derivatives(fit_initial_states_near(fit.model, values, fit.windows, np.inf))


def _of_encoders(noise: Array) -> Array:
    """Return the standard deviations (2,) of both encoders' noise, given those of theta1 and theta2 [rad]."""
    inner, both = noise**2
    return np.sqrt([inner, max(both - inner, _LEAST_SHARE**2 * inner)])

"""Effects that are expected because they were found on the rig before: confirmed, fitted again, or withdrawn.

They are fitted together before other effects are tried, and each must be accepted as any other effect.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.model.effects.effect import Effect
from cdp_ident.tracing.candidates import Candidate
from cdp_ident.tracing.progress import Progress
from cdp_ident.tracing.pruning import without_superfluous_ones

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class ExpectedEffect:
    """An effect that was found on the rig before."""

    effect: Effect
    values: Array
    """(k,) of its fitted parameters, torques over A22."""
    std: Array
    """(k,) their standard deviations."""


class _Known(Candidate):
    """A candidate whose values are all known."""

    @property
    def values(self) -> Array:
        return self.strengths


def begin_with(progress: Progress, expected: Sequence[ExpectedEffect]) -> None:
    """Begin with those of the expected effects that are accepted.

    Raises:
        InterruptedSelectionError: the selection is asked to stop.
    """
    candidates = tuple(_Known(ActiveEffect(known.effect), 0.0, known.values) for known in expected)
    for _, together in progress.tried(progress.current, [candidates] if candidates else []):
        attempt = without_superfluous_ones(progress, together)
        if attempt.model.effects:
            progress.current = progress.finished(attempt)
            keys = " and ".join(active.effect.key for active in attempt.model.effects)
            errors = f"{1e3 * progress.before.validation.rmse():.3g} -> {1e3 * attempt.validation.rmse():.3g} mrad"
            progress.note(f"added {keys}", progress.current, f"confirmed {keys}: {errors} in cross-validation")

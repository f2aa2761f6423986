# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What effects explain of a motion that is predicted over windows, where torques are missing that no law gives.

Evidence is of predictions from node to node. Impulses of a missing torque count as independent there, which they are
not: a torque that goes with the state has few degrees of freedom, and any effect imitates a part of it. Over half a
swing what is imitated adds up to nothing (output error beside prediction error: Ljung, System Identification, 1999,
chapters 7 and 16). Over longer windows chaos makes of a little much.
"""

from collections.abc import Sequence

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.errors import IdentificationError
from cdp_ident.fit.initial_states import fit_initial_states
from cdp_ident.fit.windows import Window
from cdp_ident.likelihood.whole_swing import LARGER, WholeSwings
from cdp_ident.tracing.odds import size_of

_LEFT = 0.9
"""Share of the square of a model's error over windows, beyond noise, that what another one has more may leave; of two
models the one that leaves less than that of what the other one does explains more of the motion."""


class OverWindows:
    """Errors of models over windows."""

    def __init__(self, windows: Sequence[Window], noise: Array) -> None:
        """Take windows that were fitted, and the noise (2,) that samples show of theta1 and theta2 [rad]."""
        self._windows, self._noise = windows, noise
        self._known: dict[int, tuple[WholeSwings, float]] = {}

    def explains(self, found: WholeSwings, than: WholeSwings) -> bool:
        """Return whether what a model has more than another one explains a share of what that one leaves.

        One that has no more is not to leave more. Nothing is asked where no torque is missing beside it.
        """
        if not np.any(found.is_missing):
            return True
        if size_of(found.model) <= size_of(than.model):
            return not self.leaves_less(than, found)
        return self._error_of(than) <= LARGER * than.noise_level(self._noise) or self.leaves_less(found, than)

    def leaves_less(self, found: WholeSwings, than: WholeSwings) -> bool:
        """Return whether a model leaves less than a share of what another one leaves, if that is more than noise."""
        before, noise = self._error_of(than), than.noise_level(self._noise)
        if before <= LARGER * noise:
            return False
        return self._error_of(found) ** 2 - noise**2 < _LEFT * (before**2 - noise**2)

    def _error_of(self, found: WholeSwings) -> float:
        """Return the error of a model [rad], infinite where it has no motion, and nothing without windows."""
        if not self._windows:
            return 0.0
        if id(found) not in self._known:
            try:
                error = fit_initial_states(found.model, found.values, self._windows).rmse()
            except (IdentificationError, np.linalg.LinAlgError):
                error = np.inf
            self._known[id(found)] = found, error
        return self._known[id(found)][1]

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects that are expected because they were found on the rig before: confirmed, fitted again, or withdrawn."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.model.effects.effect import Effect

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class ExpectedEffect:
    """An effect that was found on the rig before."""

    effect: Effect
    values: Array
    """(k,) of its fitted parameters, torques over A22."""
    std: Array
    """(k,) their standard deviations."""

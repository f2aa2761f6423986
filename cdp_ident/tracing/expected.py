# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects that are expected because they were found on the rig before: confirmed, fitted again, or withdrawn."""

from dataclasses import dataclass

from cdp_ident.arrays import Array
from cdp_ident.model.effects.effect import Effect


@dataclass(frozen=True)
class ExpectedEffect:
    """An effect that was found on the rig before."""

    effect: Effect
    values: Array
    """(k,) of its fitted parameters, torques over A22."""
    std: Array
    """(k,) their standard deviations."""

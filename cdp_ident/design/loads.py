# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the rods may carry in a next trial."""

from collections.abc import Iterable

import numpy as np

from cdp_ident.design.knowledge import Knowledge
from cdp_ident.model.weights import STANDARD_PLACE_STD, STANDARD_RELATIVE_STD, Weight

Loads = tuple[tuple[Weight, ...], ...]
"""What the rods may carry: each is tried at each start."""
UNLOADED: Loads = ((),)
_SHARE = 0.1
"""Of A22 that a weight adds which is to show it: it changes the base parameters by about as much."""


def loads_of(weights: Iterable[tuple[Weight, ...]]) -> Loads:
    """Return nothing, and each of the given sets of weights once."""
    return tuple(dict.fromkeys((*UNLOADED, *weights)))


def telling_weight(knowledge: Knowledge) -> Weight:
    """Return a weight that would show A22: at the end of the outer rod, and adding a tenth of A22 by d L^2 there.

    Mass and place are rounded to what one can have, and as well known as where a user says nothing of it.
    """
    length, _ = knowledge.model.constants(knowledge.values)
    mass = _rounded(_SHARE * knowledge.model.mechanism.inertia / length**2)
    place = _rounded(knowledge.model.mechanism.outer_length)
    return Weight("outer", mass, place, 0.0, STANDARD_RELATIVE_STD * mass, STANDARD_PLACE_STD)


def _rounded(value: float) -> float:
    """Return a number to its two leading digits."""
    return float(np.format_float_scientific(value, precision=1))

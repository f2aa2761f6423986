# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Pendulums and starts of all kinds, for properties that hold for every one of them."""

import numpy as np
from hypothesis import strategies as st

from reference.pendulum import TABLE_2, Array


@st.composite
def pendulums(draw: st.DrawFn, friction: bool = True) -> dict[str, float]:
    """Draw physical values around the paper's, each within a factor of two, friction of ten, or without it."""
    values = {symbol: nominal * draw(st.floats(0.5, 2.0)) for symbol, nominal in TABLE_2.items()}
    for symbol in ("c1", "c2"):
        values[symbol] = TABLE_2[symbol] * draw(st.floats(0.1, 10.0)) if friction else 0.0
    return values


@st.composite
def starts(draw: st.DrawFn, speed: float = 10.0) -> Array:
    """Draw a start (4,): angles anywhere in a turn [rad], velocities up to `speed` [rad/s]."""
    angles = [draw(st.floats(-np.pi, np.pi)) for _ in range(2)]
    return np.array(angles + [draw(st.floats(-speed, speed)) for _ in range(2)])

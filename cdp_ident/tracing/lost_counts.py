# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The sample at which counts were lost: no derivative by time leads there, but residuals say it at once."""

import numpy as np
import numpy.typing as npt

from cdp_ident.likelihood.whole_swing import WholeSwings
from cdp_ident.model.effects.effect import JOINTS

Array = npt.NDArray[np.float64]

_NEAR = 2.0
"""They are looked for within so many nodes."""
_FEWEST = 4


def with_better_instants(found: WholeSwings) -> Array | None:
    """Return a model's values with counts lost where they were lost; None where they are there already."""
    values, moved = found.values.copy(), False
    for index, active in enumerate(found.model.effects):
        if not active.effect.at_an_instant or active.effect.moves:
            continue
        place, joint = found.model.places(index), JOINTS.index(active.effect.joint)
        size, time = values[place]
        for swing, linear in zip(found.recorded.swings, found.linear, strict=True):
            times = swing.begin + swing.time
            near = np.flatnonzero(np.abs(times - time) < _NEAR * swing.spacing)
            if swing.trial != active.trial or len(near) < _FEWEST:
                continue
            rest = linear.residuals[near, joint] - size * (times[near] >= time)
            before, after = np.cumsum(rest**2), np.cumsum((rest + size)[::-1] ** 2)[::-1]
            last = int(np.argmin(before[:-1] + after[1:]))
            if not times[near[last]] < time <= times[near[last + 1]]:
                values[place.start + 1], moved = 0.5 * (times[near[last]] + times[near[last + 1]]), True
    return values if moved else None

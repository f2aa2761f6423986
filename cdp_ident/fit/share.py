# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A share of long recordings, for what need not be done with all of them.

Looking for effects takes hundreds of fits, whose time grows with the motion. Of what an hour shows, a minute or two
show most; so effects are looked for there, and what was found is fitted to all of the motion.

Pieces are spread evenly by the golden ratio: its multiples, modulo one, are nowhere dense, nowhere sparse, and never in
step with anything that repeats, such as the beginnings of trials (Weyl, Math. Ann. 77, 1916).
"""

from collections.abc import Sequence

import numpy as np

_GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0


def share_of(durations: Sequence[float], enough: float) -> tuple[int, ...]:
    """Return the indices of pieces, ascending, that are spread evenly over all and last for enough [s] together.

    They are all pieces where these last no longer, and at least one.
    """
    order = np.argsort(np.arange(len(durations)) * _GOLDEN % 1.0, kind="stable")
    motion = np.cumsum(np.asarray(durations)[order])
    count = len(durations) if motion[-1] <= enough else max(int(np.searchsorted(motion, enough)), 1)
    return tuple(sorted(order[:count].tolist()))

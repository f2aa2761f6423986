"""A share of the windows of long recordings, for what need not be done with all of them.

Looking for effects takes hundreds of fits, whose time grows with the motion. Of what an hour shows, a minute or two
show most; so effects are looked for there, and what was found is fitted to all of the motion.

The windows are spread evenly by the golden ratio: its multiples, modulo one, are nowhere dense, nowhere sparse, and
never in step with anything that repeats, such as the beginnings of trials (Weyl, Math. Ann. 77, 1916).
"""

from collections.abc import Sequence

import numpy as np

from cdp_ident.fit.windows import Window

_FEWEST = 8
"""Windows that a share has at least: two for each fold."""
_GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0


def share_of(windows: Sequence[Window], enough: float) -> tuple[int, ...]:
    """Return the indices of windows, ascending, that are spread evenly over all and hold enough motion [s].

    They are all windows where these hold no more.
    """
    order = np.argsort(np.arange(len(windows)) * _GOLDEN % 1.0, kind="stable")
    motion = np.cumsum([windows[index].duration for index in order])
    count = len(windows) if motion[-1] <= enough else max(int(np.searchsorted(motion, enough)), _FEWEST)
    return tuple(sorted(order[:count].tolist()))

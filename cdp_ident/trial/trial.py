"""A trial: one stretch of zero-input motion, in the angles that the model uses."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cdp_ident.bag.diagnostics import ClockRate

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Trial:
    """One zero-input motion of the pendulum, as measured.

    `theta` holds the paper's theta1 (inner rod) and theta2 (outer rod): both absolute, zero upright, pi hanging,
    positive towards +x, continuous. Samples keep the spacing at which they were measured; nothing is resampled.
    """

    name: str
    """What people call it: the bag's name."""
    time: Array
    """(n,) time of each sample since the first one [s], strictly increasing."""
    theta: Array
    """(n, 2) measured angles theta1, theta2 [rad]."""
    cart: Array | None = None
    """(n,) measured cart position x [m], or None where it was not measured: then the cart is taken to be at rest."""
    start: float = 0.0
    """Time of the first sample since the beginning of the bag [s]."""
    notes: tuple[str, ...] = ()
    """What was dropped, cut or noticed on the way from the bag to here, in words, with numbers."""
    clock: ClockRate | None = None
    """How fast the device's clock ran whose times these are, None where they are stamps."""

    @property
    def duration(self) -> float:
        """Time from the first to the last sample [s]."""
        return float(self.time[-1] - self.time[0])

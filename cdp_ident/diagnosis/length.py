# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whether the given length between the joints agrees with the balance of forces.

The coupling of the rods, A23, over the outer rod's moment of gravity, m2 l2, is L: as it is taken for exact, a small
error in it makes everything else slightly wrong, and false effects explain the rest.
"""

from dataclasses import dataclass

import numpy as np

from cdp_ident.fit.force_balance import CLEARLY_BETTER, MOMENT, ForceBalance

_OFF = 3e-3
"""Relative error of L that matters: it changes every frequency by half of that, as much as friction does in a few
swings."""
_CLEARLY = 4.0
"""Standard deviations."""
_ANOTHER = 0.2
"""Relative difference from which on the given length must be wrong."""
_MOST_LEFT = 1.0 / 3.0
"""With the right length at most this share of what the wrong one leaves of gravity's torque is unexplained."""
_BESIDE_NOISE = 2.0
"""The unexplained share counts only where it is so many times that of noise."""


@dataclass(frozen=True)
class LengthByBalance:
    """L by the balance of forces, where it differs clearly from the given one."""

    given: float
    """[m]"""
    found: float
    """[m]"""
    std: float
    """[m]"""
    balances: bool
    """Whether much less of gravity's torque is unexplained with it than with the given one."""

    @property
    def words(self) -> str:
        """It in words."""
        share = 100.0 * (self.found / self.given - 1.0)
        found = f"{self.found:.4g} ± {self.std:.2g} m"
        return f"by the balance of forces L is {found}, {share:+.2g} % from the {self.given:g} m given"


def length_by_balance(given: ForceBalance, free: ForceBalance, length: float) -> LengthByBalance | None:
    """Compare a balance of forces with L as given [m] to the same with L free; None where they agree about L."""
    place = [free.names.index(name) for name in ("A23_over_A22", MOMENT)]
    coupling, moment = free.values[place]
    spread = free.covariance[np.ix_(place, place)]
    if not (coupling > 0.0 and moment > 0.0 and np.all(np.isfinite(spread))):
        return None
    slope = np.array([1.0 / coupling, -1.0 / moment])
    std = free.length * float(np.sqrt(slope @ spread @ slope))
    off = abs(free.length - length)
    better = free.criterion < given.criterion - CLEARLY_BETTER
    if off < max(_OFF * length, _CLEARLY * std) or not better:
        return None
    balances = float(free.unexplained.max()) < _MOST_LEFT * given.unexplained.max()
    return LengthByBalance(length, free.length, std, balances)


def says_another_length(balance: ForceBalance, length: LengthByBalance | None) -> str:
    """Return in words that the motion is that of a double pendulum, but of one of quite another length, if it is.

    Motion that does not balance with any length may still be that of a pendulum whose joints stick, or whose encoders
    have play.
    """
    if length is None or not length.balances or abs(length.found / length.given - 1.0) < _ANOTHER:
        return ""
    if np.any(balance.unexplained > _BESIDE_NOISE * balance.noise_share):
        return (
            f"the fit failed: gravity, friction and inertia do not balance; {length.words}. Check L, g and what the "
            "angles mean (zero, outer_angle, inner_sign and outer_sign below trial), and that all bags are of one rig"
        )
    return ""

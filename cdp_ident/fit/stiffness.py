"""Penalties on the coefficients of curves, which keep them smooth in a fit.

A curve may be large and sharp at one place and zero elsewhere, such as a magnet's torque. So the size of its
coefficients is penalised part by part, each part with a weight of its own.
"""

from functools import cache

import numpy as np
import numpy.typing as npt

from cdp_ident.model.effects.effect import Curve

Array = npt.NDArray[np.float64]
Stiffness = tuple[float, ...]
"""Weight of each penalty of a curve [rad^2]."""

_PART = 8
"""Coefficients in a part."""


@cache
def penalties(curve: Curve) -> tuple[Array, ...]:
    """Return the forms (count, count) whose weighted sum is a curve's penalty: its smoothness, then parts' sizes."""
    identity = np.eye(curve.count)
    if curve.over == "angle":
        bends = np.roll(identity, -1, axis=0) - 2.0 * identity + np.roll(identity, 1, axis=0)
    else:
        bends = np.diff(identity, 2, axis=0)
    parts = np.arange(curve.count) // _PART
    sizes = (np.diag((parts == part).astype(float)) for part in range(curve.count // _PART))
    return bends.T @ bends, *sizes


def penalty(curve: Curve, stiffness: Stiffness) -> Array:
    """Return the quadratic form (count, count) that a curve's coefficients add to the cost of a fit [rad^2]."""
    return np.asarray(sum(weight * form for weight, form in zip(stiffness, penalties(curve), strict=True)))

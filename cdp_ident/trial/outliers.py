"""Single samples that stand out from their neighbours: a bag without checksums may be damaged."""

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

_NEIGHBOURS = np.array([-1.0, 4.0, 0.0, 4.0, -1.0]) / 6.0
"""What the two samples on either side of one say of it, by the cubic through them."""
_DEVIATIONS, _STEPS = 8.0, 4.0
"""A sample stands out by more than so many robust standard deviations, and so many steps of the encoder."""
_EVEN = 1.5
"""Beside a gap of so many usual spacings, neighbours say nothing."""


def outliers(time: Array, angles: Array) -> tuple[Array, Array]:
    """Return when single samples stand out from their neighbours [s], and by how much [rad].

    Args:
        time: (n,) strictly increasing [s].
        angles: (n, 2) continuous angles [rad].
    """
    if len(time) < 2 * len(_NEIGHBOURS):
        return np.empty(0), np.empty(0)
    found = np.zeros(len(time))
    spacing = np.diff(time)
    uneven = spacing > _EVEN * np.median(spacing)
    trusted = np.convolve(uneven, np.ones(len(_NEIGHBOURS) - 1), mode="valid") == 0
    for column in angles.T:
        off = np.abs(column[2:-2] - np.convolve(column, _NEIGHBOURS, mode="valid"))
        changes = np.abs(np.diff(column))
        step = float(np.min(changes[changes > 0.0], initial=np.inf))
        # Of numbers that are no encoder's the smallest change is next to nothing.
        limit = max(_DEVIATIONS * 1.4826 * float(np.median(off)), _STEPS * step if np.isfinite(step) else 0.0)
        stands_out = trusted & (off > limit) & (off >= _neighbouring(off))
        found[2:-2] = np.maximum(found[2:-2], np.where(stands_out, off, 0.0))
    return time[found > 0.0], found[found > 0.0]


def outlier_notes(time: Array, size: Array) -> list[str]:
    """Say what was found, in words."""
    if not len(time):
        return []
    places = ", ".join(f"{at:.3f}" for at in time[:3]) + (" …" if len(time) > 3 else "")
    return [
        f"{len(time)} samples stand out from their neighbours by up to {np.max(size):.2g} rad (at {places} s): a "
        "slipped count, or a damaged recording? They are kept"
    ]


def _neighbouring(off: Array) -> Array:
    """Return the larger of the values before and after each."""
    padded = np.pad(off, 1)
    return np.maximum(padded[:-2], padded[2:])

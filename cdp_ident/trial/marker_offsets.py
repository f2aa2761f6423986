"""Where markers on a film are off the joints: by the distances between them, which rods keep constant.

A marker that is off its joint makes the distance to its neighbour change with the direction of the rod, and turns the
angle that is read from the film by as much. What stands still in the picture (the pivot's marker, or a tracker that
sees markers of one colour beside where they are) goes with the rod's own direction, a joint's marker that is fixed
beside the joint with the angle between the rods.
"""

from collections.abc import Sequence

import numpy as np

from cdp_ident.arrays import Array, Mask

_BLOCKS = 20
"""In so many parts of the film the offsets' standard deviations are found, each left out in turn (jackknife)."""
_FEWEST_FRAMES = 10 * _BLOCKS
_CERTAIN = 25.0
"""An offset is believed if its square over its variance is above this: five standard deviations."""
_FEWEST_DIRECTIONS = 0.2
"""What an offset goes with (a cosine and a sine) varies by this standard deviation at least: over a shorter arc, what
else changes the distance a little, as a lens does, would be a large offset."""
_ROUNDS = 4
_OUTLIER = 4.0
"""Distances further off than so many standard deviations do not count."""


def without_offsets(points: Array) -> tuple[Array, tuple[str, ...]]:
    """Return the rods without what is certain to be an offset of a marker.

    Args:
        points: (n, 3, 2) x and y of pivot, joint and tip in each frame [any unit].

    Returns:
        (n, 2, 2) x and y from pivot to joint and from joint to tip, and what was put right, in words.
    """
    rods = np.diff(points, axis=1)
    if len(points) < _FEWEST_FRAMES:
        return rods, ()
    lengths = np.linalg.norm(rods, axis=2)
    inner, outer = np.moveaxis(rods / lengths[:, :, None], 1, 0)
    beside = np.column_stack([inner[:, 1], -inner[:, 0]])
    of_joint = -np.column_stack([np.sum(inner * outer, axis=1), np.sum(beside * outer, axis=1)])
    (pivot,) = _certain_offsets(lengths[:, 0], [inner])
    tip, joint = _certain_offsets(lengths[:, 1], [outer, of_joint])
    off_joint = joint[0] * inner + joint[1] * beside
    corrected = np.stack([rods[:, 0] - pivot - off_joint, rods[:, 1] - tip + off_joint], axis=1)
    found = (
        (pivot, "the pivot's marker is {:.2g} off the centre of the joint's circle: put right"),
        (tip, "the tip's marker is seen {:.2g} beside where it is: put right"),
        (joint, "the joint's marker is {:.2g} off the joint: put right"),
    )
    return corrected, tuple(words.format(np.linalg.norm(offset)) for offset, words in found if np.any(offset))


def _certain_offsets(lengths: Array, regressors: Sequence[Array]) -> list[Array]:
    """Return offsets (2,) of markers that explain how a rod's length (n,) changes; zero where they are not certain.

    Each has its derivatives of the length, (n, 2). The least certain one is left out first.
    """
    chosen = list(range(len(regressors)))
    offsets: list[Array] = [np.zeros(2) for _ in regressors]
    while chosen:
        directions = np.column_stack([regressors[k] for k in chosen])
        tells = np.linalg.eigvalsh(np.cov(directions.T))[0] > _FEWEST_DIRECTIONS**2
        found, variances = _regression(lengths, directions)
        parts = [slice(2 * place, 2 * place + 2) for place in range(len(chosen))]
        certainty = [found[p] @ np.linalg.pinv(variances[p, p], hermitian=True) @ found[p] for p in parts]
        least = int(np.argmin(certainty))
        if tells and certainty[least] > _CERTAIN:
            for k, part in zip(chosen, parts, strict=True):
                offsets[k] = found[part]
            break
        del chosen[least]
    return offsets


def _regression(lengths: Array, regressors: Array) -> tuple[Array, Array]:
    """Return by least squares without outliers the coefficients (k,) of regressors (n, k), and their covariance.

    The covariance holds for errors that go together within a part of the film.
    """
    design = np.column_stack([regressors, np.ones(len(lengths))])
    part = np.arange(len(lengths)) * _BLOCKS // len(lengths)
    usable: Mask = np.ones(len(lengths), dtype=bool)

    def fit(chosen: Mask) -> Array:
        return np.asarray(np.linalg.lstsq(design[chosen], lengths[chosen], rcond=None)[0][:-1])

    for _ in range(_ROUNDS):
        error = lengths - regressors @ fit(usable)
        error = np.abs(error - np.median(error))
        usable = error <= _OUTLIER * 1.4826 * np.median(error)
    without = np.array([fit(usable & (part != k)) for k in range(_BLOCKS)])
    return fit(usable), (_BLOCKS - 1) * np.cov(without.T, bias=True)

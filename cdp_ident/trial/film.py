# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""From markers on a film to the angles of the rods.

A camera that looks along the joints' axes sees the pivot, the joint between the rods and the tip (or any other point of
the outer rod). The distance from pivot to joint is constant, by which exchanged and lost markers are recognised; that
from joint to tip is, too, and both show which markers are off their joints.

A marker that is off its joint makes the distance to its neighbour change with the direction of the rod, and turns the
angle that is read from the film by as much. What stands still in the picture (the pivot's marker, or a tracker that
sees markers of one colour beside where they are) goes with the rod's own direction, a joint's marker that is fixed
beside the joint with the angle between the rods.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from cdp_ident.arrays import Array, Mask
from cdp_ident.errors import TrialError
from cdp_ident.trial.kinematics import MEDIAN_OF_SIZE

_TOLERANCE = 0.03
"""How far a distance may be off at least, as a share of it: a lens that distorts, a tracker's noise."""
_SIGMAS = 6.0
_FEWEST_RIGHT = 0.5
"""Share of the frames that must show the joint where it can be."""
_RIGID = 0.1
"""Standard deviation of the distance between the joints, as a share of it, above which they are not on a rod."""
_AT_REST = 0.02
"""A pivot that moves less than this [distances between the joints, standard deviation] is at rest."""
_LEVEL = 0.1
"""A pivot on a cart moves up and down less than this [distances between the joints, standard deviation]."""
_CIRCLE_ROUNDS = 20
_REST = 1.5
"""Of markers that step by so many of their least steps, something moved."""
_BLOCKS = 20
"""In so many parts of the film the offsets' standard deviations are found, each left out in turn (jackknife)."""
_FEWEST_FRAMES = 10 * _BLOCKS
_CERTAIN = 25.0
"""An offset is believed if its square over its variance is above this: five standard deviations."""
_DISTORTS = 100.0
"""The same of a lens: without one it was 28 at most in 60 films, with 1 % at the edge of the picture 300."""
_FEWEST_DIRECTIONS = 0.2
"""What an offset goes with (a cosine and a sine) varies by this standard deviation at least: over a shorter arc, what
else changes the distance a little, as a lens does, would be a large offset."""
_LEAST_STRETCH = 0.005
"""A smaller distortion is left to `identify`: it turns angles by half of it [rad]."""
_ROUNDS = 4
_OUTLIER = 4.0
"""Distances further off than so many standard deviations do not count."""


@dataclass(frozen=True)
class Film:
    """The motion of the rods on a film."""

    kept: Mask
    """(n,) the frames that show it."""
    angles: Array
    """(k, 2) theta1, theta2 of those frames: absolute, zero upright, positive towards +x, wrapped [rad]."""
    pivot: Array | None
    """(k,) position of the pivot along x [the film's unit]; None where it is at rest."""
    length: float
    """Distance between the joints [the film's unit]."""
    notes: tuple[str, ...]
    """What was corrected and left out, in words."""


def rods_on_film(points: Array, y_down: bool, tried: int = 0) -> Film:
    """Find the angles of the rods from positions of the markers. Raises TrialError where these are no rods'.

    `points` (n, 3, 2) are x and y of pivot, joint and tip in each frame, or (n, 2, 2) of joint and tip if the pivot was
    not tracked; it is then the centre of the joint's circle. NaN where a marker was not found. `y_down` says that y
    counts downwards, as in pictures, and so many of the distortions of a picture are `tried` already.
    """
    points = points * (1.0, -1.0 if y_down else 1.0)
    as_seen = points.copy()
    seen = np.all(np.isfinite(points), axis=(1, 2))
    if not np.any(seen):
        raise TrialError("no frame has numbers for all markers")
    notes = []
    if points.shape[1] == 2:
        centre = _centre(points[seen, 0])
        points = np.concatenate([np.broadcast_to(centre, (len(points), 1, 2)), points], axis=1)
        notes.append(f"the pivot is the centre of the joint's circle, x {centre[0]:.4g}, y {abs(centre[1]):.4g}")
    length, tolerance = _length(points[seen])
    pivot = points[seen, 0]
    spread = np.median(np.abs(pivot - np.median(pivot, axis=0)), axis=0) / (MEDIAN_OF_SIZE * length)
    if spread[1] > _LEVEL:
        raise TrialError("the pivot moves up and down: check which columns are pivot, joint and tip")
    is_at_rest = bool(np.all(spread < _AT_REST))
    if is_at_rest:
        points[:, 0] = np.median(pivot, axis=0)
        length, tolerance = _length(points[seen])
    exchanged, lost = _exchanged(points, seen, length, tolerance)
    in_order = np.where(exchanged[:, None, None], points[:, [0, 2, 1]], points)
    repeated = _repeated(np.where(lost[:, None, None], np.nan, in_order))
    for rod in (0, 1) if not tried and np.any(lost) else ():
        # Of a stretched circle, parts are not where the joint can be.
        if stretch := _stretch(points[seen], rod):
            with suppress(TrialError):
                film = rods_on_film(stretch[0](as_seen), y_down=False, tried=1)
                if np.count_nonzero(film.kept) > np.count_nonzero(seen & ~lost & ~repeated):
                    return replace(film, notes=(stretch[1], *film.notes))
    points[exchanged, 1:] = points[exchanged, :0:-1]
    kept = seen & ~lost & ~repeated
    if np.count_nonzero(seen & ~lost) < _FEWEST_RIGHT * np.count_nonzero(seen):
        raise TrialError(
            f"in {np.count_nonzero(lost)} of {np.count_nonzero(seen)} frames neither marker is {length:.4g} from the "
            "pivot, as the joint must be: check which columns are pivot, joint and tip"
        )
    told = (
        (~seen, "{} frames lack a marker and are left out"),
        (
            seen & repeated,
            "{} frames repeat the one before and are left out: they show it once more, not a later moment",
        ),
        (exchanged & kept, "joint and tip are exchanged in {} frames: put right"),
        (lost, "in {} frames the joint is not where it can be: left out"),
    )
    notes += [words.format(np.count_nonzero(frames)) for frames, words in told if np.any(frames)]
    for number, distortion in enumerate((_stretch, _lens)[tried:], tried + 1):
        if found := distortion(points[kept]):
            straight, note = found
            film = rods_on_film(straight(as_seen), y_down=False, tried=number)
            return replace(film, notes=(note, *film.notes))
    rods, put_right = without_offsets(points[kept])
    notes.extend(put_right)
    angles = np.arctan2(rods[:, :, 0], rods[:, :, 1])
    return Film(kept, angles, None if is_at_rest else points[kept, 0, 0], length, tuple(notes))


def _stretch(points: Array, rod: int = 0) -> tuple[Callable[[Array], Array], str] | None:
    """Return what takes a certain stretch out of markers (n, 3, 2), and that in words; None without one.

    Where pixels are not square, or the camera looks from the side, the joint's circle is an ellipse: the inverse square
    of its distance from the pivot varies with twice the rod's direction. A pivot that is off goes with the direction.
    The outer rod (1) tells it likewise where the inner one turns little, but for a joint's marker that is off.
    """
    rods = points[:, rod + 1] - points[:, rod]
    rods = rods[np.any(rods, axis=1)]
    lengths = np.linalg.norm(rods, axis=1)
    x, y = (rods / lengths[:, None]).T
    inverse, twice = (np.median(lengths) / lengths) ** 2, np.column_stack([x * x - y * y, 2.0 * x * y])
    _, found = _certain_offsets(inverse, [np.column_stack([x, y]), twice])
    c, s = found / np.median(inverse - twice @ found)
    if not _LEAST_STRETCH < np.hypot(c, s) < 1.0:
        return None
    values, axes = np.linalg.eigh([[1.0 + c, s], [s, 1.0 - c]])
    straight = axes * np.sqrt(values / np.sqrt(values[0] * values[1])) @ axes.T
    ratio = f"{np.sqrt(values[1] / values[0]):.4g} times as long one way as across"
    return lambda of: np.asarray(of @ straight), f"the picture is {ratio} (pixels, a camera to one side?): put right"


def _lens(points: Array) -> tuple[Callable[[Array], Array], str] | None:
    """Return what takes a certain distortion by a lens out of markers (n, 3, 2), and that in words; None without one.

    A lens moves what it shows along the radius from the picture's centre, by the cube of that (Brown, Photogrammetric
    Engineering 32, 1966). The centre is not known: it is found with the distortion, by which rods are as long
    everywhere, whatever markers that are off their joints and a stretch do to them.
    """
    rods = np.diff(points, axis=1)
    origin, scale = np.median(points[:, 0], axis=0), float(np.median(np.linalg.norm(rods[:, 0], axis=1)))
    moved: Array = np.zeros(3)
    if len(points) < _FEWEST_FRAMES:
        return None
    seen = (points - origin) / scale
    for _ in range(_ROUNDS):
        straight = rods / scale + np.diff(_of_lens(seen), axis=1) @ moved
        lengths = np.linalg.norm(straight, axis=2)
        units = straight / lengths[..., None]
        # Where rods of constant lengths are seen: with the noise of a length itself, less of both would be left.
        constant = np.concatenate(
            [seen[:, :1] + _of_lens(seen[:, :1]) @ moved, np.median(lengths, axis=0)[:, None] * units], axis=1
        )
        seen = np.cumsum(constant, axis=1) - _of_lens(seen) @ moved
        fields = np.diff(_of_lens(seen), axis=1)
        x, y = np.moveaxis(units, 2, 0)
        beside = np.sum(units[:, 0, ::-1] * [1.0, -1.0] * units[:, 1], axis=1)
        none = np.zeros((len(points), 2))
        offsets = np.stack(
            [
                np.column_stack([units[:, 0], none, none]),
                np.column_stack([none, units[:, 1], np.sum(units[:, 0] * units[:, 1], axis=1), beside]),
            ],
            axis=1,
        )
        stretch = lengths[..., None] * np.stack([x * x - y * y, 2.0 * x * y], axis=2)
        is_outer = np.broadcast_to([[0.0], [1.0]], (len(points), 2, 1))
        columns = np.concatenate([-np.sum(units[..., None] * fields, axis=2), offsets, stretch, is_outer], axis=2)
        change, covariance = _regression(lengths.ravel(), columns.reshape(-1, columns.shape[2]))
        moved = moved + change[:3]
        if moved @ np.linalg.pinv(covariance[:3, :3], hermitian=True) @ moved < _DISTORTS:
            return None
    reach = np.linalg.norm(_of_lens((points[:, 1:] - origin) / scale) @ moved, axis=2)
    note = f"a lens distorts the picture, by {float(np.max(reach)):.2g} of the inner rod's length at most: put right"
    return lambda of: np.asarray(of + scale * (_of_lens((of - origin) / scale) @ moved)), note


def _of_lens(at: Array) -> Array:
    """Return how positions (..., 2) move (..., 2, 3) by a lens, and by that times x and y of its centre."""
    square = np.sum(at**2, axis=-1, keepdims=True)
    centres = [-2.0 * at[..., k : k + 1] * at - square * np.eye(2)[k] for k in range(2)]
    return np.stack([square * at, *centres], axis=-1)


def _repeated(points: Array) -> Mask:
    """Return which frames (n,) have every marker where the frame before has it, but for those at rest.

    At rest the next frame that differs does so by no more than the least step, as of markers in whole pixels.

    In a film that was compressed and tracked anew, markers are nearly there: the step is less than half of what it
    would be evenly over the frames about it, and of the next one. A tracker's noise may look so in slow motion; hence
    one frame in `_BLOCKS` or more of the faster half must be such.
    """
    steps = np.abs(np.diff(points, axis=0))
    least = np.min(steps[steps > 0], initial=np.inf)
    steps = np.append(np.inf, np.nan_to_num(np.max(steps, axis=(1, 2)), nan=np.inf))
    exactly = steps == 0
    nearly, fast = exactly.copy(), np.zeros(len(points), dtype=bool)
    while True:
        kept = np.flatnonzero(~nearly)
        step, about = (
            np.max(np.abs(points[kept[k:]] - points[kept[:-k]]), axis=(1, 2)) / (kept[k:] - kept[:-k]) for k in (1, 3)
        )
        again = kept[2:-1][step[1:-1] < about / 2]
        if not len(again):
            break
        if not np.any(fast):
            fast[kept[2:-1]] = about > np.nanmedian(about)
        nearly[again] = True
    is_such = np.count_nonzero(fast & nearly) * _BLOCKS > np.count_nonzero(fast)
    changes = ~nearly if is_such else ~exactly
    after = np.append(steps[changes], 0.0)[np.cumsum(changes)]
    return np.asarray(~changes & (after > _REST * least) & (steps < after / 2))


def _length(points: Array) -> tuple[float, float]:
    """Return how far the joint is from the pivot in most frames, and how far off a frame may be.

    The middle of the shortest interval with a third of the distances: frames in which the tip stands for the joint, or
    nothing was found, are far from it, and may be most.
    """
    distances = np.sort(np.linalg.norm(points[:, 1] - points[:, 0], axis=1))
    third = max(1, len(distances) // 3)
    widths = distances[third:] - distances[:-third]
    at = int(np.argmin(widths)) if len(widths) else 0
    length = float(np.median(distances[at : at + third]))
    if not length > 0:
        raise TrialError("pivot and joint are the same point: check which columns are pivot, joint and tip")
    # A third of a normal distribution lies within 0.431 of its standard deviation.
    deviation = float(widths[at]) / 0.861 if len(widths) else 0.0
    if deviation > _RIGID * length:
        raise TrialError(
            f"the joint is {length:.4g} from the pivot, but {deviation:.2g} more or less in many frames: check which "
            "columns are pivot, joint and tip"
        )
    return length, max(_SIGMAS * deviation, _TOLERANCE * length)


def _exchanged(points: Array, seen: Mask, length: float, tolerance: float) -> tuple[Mask, Mask]:
    """Return in which frames joint and tip are exchanged, and in which neither is where the joint can be.

    Where both are, the order is that in which the markers move less since the frame before.
    """
    joint, tip = (np.abs(np.linalg.norm(points[:, k] - points[:, 0], axis=1) - length) for k in (1, 2))
    as_is, other_way = seen & (joint <= tolerance), seen & (tip <= tolerance)
    exchanged = other_way & ~as_is
    lost = seen & ~as_is & ~other_way
    last = None
    order = np.flatnonzero(seen & ~lost)
    # Before the first frame that is certain, go backwards from it.
    first = order[np.argmax(as_is[order] != other_way[order])] if len(order) else 0
    order = np.concatenate([order[order <= first][::-1], order[order > first]])
    for i in order:
        markers = points[i, 1:]
        if as_is[i] and other_way[i] and last is not None:
            exchanged[i] = np.sum((markers[::-1] - last) ** 2) < np.sum((markers - last) ** 2)
        last = markers[::-1] if exchanged[i] else markers
    return exchanged, lost


def _centre(joint: Array) -> Array:
    """Return the centre (2,) of the circle on which most positions (n, 2) lie: Kasa's fit without outliers."""
    chosen = np.ones(len(joint), dtype=bool)
    centre = np.median(joint, axis=0)
    for _ in range(_CIRCLE_ROUNDS):
        x, y = (joint[chosen] - centre).T
        found = np.linalg.lstsq(np.column_stack([2 * x, 2 * y, np.ones(len(x))]), x**2 + y**2, rcond=None)[0]
        centre = centre + found[:2]
        radius = np.sqrt(max(0.0, found[2] + found[0] ** 2 + found[1] ** 2))
        error = np.abs(np.linalg.norm(joint - centre, axis=1) - radius)
        chosen = error <= 3 * np.median(error) + 1e-12
    return np.asarray(centre)


def without_offsets(points: Array) -> tuple[Array, tuple[str, ...]]:
    """Return the rods without what is certain to be an offset of a marker, and what was put right, in words.

    Of x and y of pivot, joint and tip (n, 3, 2), rods are those from pivot to joint and from joint to tip (n, 2, 2).
    """
    rods = np.diff(points, axis=1)
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


def _certain_offsets(lengths: Array, regressors: Sequence[Array]) -> Array:
    """Return offsets (k, 2) of markers that explain how a rod's length (n,) changes; zero where they are not certain.

    Each of the k has its derivatives of the length, (n, 2). The least certain one is left out first.
    """
    chosen = list(range(len(regressors) if len(lengths) >= _FEWEST_FRAMES else 0))
    offsets: Array = np.zeros((len(regressors), 2))
    while chosen:
        directions = np.column_stack([regressors[k] for k in chosen])
        tells = np.linalg.eigvalsh(np.cov(directions.T))[0] > _FEWEST_DIRECTIONS**2
        found, covariance = _regression(lengths, directions)
        parts = np.arange(len(found)).reshape(-1, 2)
        certainty = [found[p] @ np.linalg.pinv(covariance[np.ix_(p, p)], hermitian=True) @ found[p] for p in parts]
        if tells and min(certainty) > _CERTAIN:
            offsets[chosen] = found[parts]
            break
        del chosen[int(np.argmin(certainty))]
    return offsets


def _regression(lengths: Array, regressors: Array) -> tuple[Array, Array]:
    """Return by least squares without outliers the coefficients (k,) of regressors (n, k), and their covariance.

    The covariance holds for errors that go together within a part of the film.
    """
    design = np.column_stack([regressors, np.ones(len(lengths)), lengths])
    part = np.arange(len(lengths)) * _BLOCKS // len(lengths)
    usable: Mask = np.ones(len(lengths), dtype=bool)

    def fit(products: Array) -> Array:
        return np.asarray(np.linalg.lstsq(products[:-1, :-1], products[:-1, -1], rcond=None)[0][:-1])

    for _ in range(_ROUNDS):
        error = lengths - regressors @ fit(design[usable].T @ design[usable])
        error = np.abs(error - np.median(error))
        usable = error <= _OUTLIER / MEDIAN_OF_SIZE * np.median(error)
    of_parts = np.array([of.T @ of for of in (design[usable & (part == k)] for k in range(_BLOCKS))])
    whole = np.sum(of_parts, axis=0)
    without = np.array([fit(whole - of_part) for of_part in of_parts])
    return fit(whole), (_BLOCKS - 1) * np.cov(without.T, bias=True)

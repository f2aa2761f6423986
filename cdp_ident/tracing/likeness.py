# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Known shapes that a nonparametric torque is similar to; other causes may have the same shape."""

from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

_ALIKE, _ALIKE_BY_MORE = 0.8, 0.03
"""A known shape is mentioned if it explains at least so much of a curve's mean square, and by so much more than a
simpler one."""
_PLACES = 41
"""Number of places where known shapes are tried, over the range that the motion covers."""
_WIDTHS = np.geomspace(0.04, 0.6, 12)
"""How wide they may be [rad]."""
_MOST_PER_TURN = 16
_REST = 0.1
"""Speed within which dry friction changes its sign [rad/s]."""

Shape = tuple[float | None, Array]
"""Where it is [rad], if anywhere, and the columns (n, k) that it is made of."""


def likeness(over: str, dry: bool, at: Array, torque: Array) -> str:
    """Return in words what could cause such a torque; empty where no known shape is similar.

    Args:
        over: what the torque depends on, the joint's angle or its speed.
        dry: whether it is the size of dry friction.
        at: (n,) angles from hanging [rad] or speeds [rad/s], evenly over the range that the motion covers.
        torque: (n,) there.
    """
    found, most = "", _ALIKE - _ALIKE_BY_MORE
    for words, shapes in (_of_speed if over == "speed" else _of_friction if dry else _of_angle)(at):
        share, place = max(
            ((_explained(torque, columns), place) for place, columns in shapes), key=lambda pair: pair[0]
        )
        if share > most + _ALIKE_BY_MORE:
            found, most = words if place is None else f"{words} at {place:.2g} rad", share
    return found


def _explained(torque: Array, columns: Array) -> float:
    left = torque - columns @ np.linalg.lstsq(columns, torque, rcond=1e-10)[0]
    return 1.0 - float(left @ left) / max(float(torque @ torque), 1e-300)


def _of_angle(at: Array) -> Iterator[tuple[str, list[Shape]]]:
    """Yield kinds of torques, the simplest first, each with its possible shapes."""
    yield "a spring or a cable", [(None, np.stack([np.ones_like(at), at], axis=1))]
    harmonics = [
        (turns, np.stack([np.sin(turns * at), np.cos(turns * at)], axis=1)) for turns in range(1, _MOST_PER_TURN)
    ]
    yield "an unbalance", [(None, harmonics[0][1])]
    yield (
        "an end stop",
        [
            (place, np.maximum(side * (at - place), 0.0)[:, None])
            for place in np.linspace(at[0], at[-1], _PLACES)[1:-1]
            for side in (1.0, -1.0)
        ],
    )
    for turns, columns in harmonics[1:]:
        yield f"detents, {turns} a turn,", [(None, columns)]
    yield (
        "a magnet",
        [
            (place, ((at - place) * np.exp(-0.5 * ((at - place) / width) ** 2))[:, None])
            for width in _WIDTHS
            for place in np.arange(at[0], at[-1], 0.25 * width)
        ],
    )


def _of_friction(at: Array) -> Iterator[tuple[str, list[Shape]]]:
    yield "dry friction over the whole turn", [(None, np.ones((len(at), 1)))]
    yield (
        "a part of the turn that rubs",
        [
            (place, (np.abs(at - place) <= half).astype(float)[:, None])
            for place in np.linspace(at[0], at[-1], _PLACES)
            for half in _WIDTHS
        ],
    )


def _of_speed(at: Array) -> Iterator[tuple[str, list[Shape]]]:
    yield "viscous friction", [(None, at[:, None])]
    yield "dry friction", [(None, np.tanh(at / _REST)[:, None])]
    yield "drag", [(None, (at * np.abs(at))[:, None])]

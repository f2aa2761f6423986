# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Thinning: neighbouring samples are averaged where there are more of them than the motion needs.

Averaging over a span h also takes h^2 / 24 of the motion's second derivative off; that is put back by the second
difference of the averages, after which the error is 3/640 h^4 of the fourth derivative and the noise of neighbours
stays nearly independent (the correction that finite-volume methods make from averages to points: LeVeque, Finite
Volume Methods, 2002).
"""

from dataclasses import replace

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.trial.trial import Trial


def thinned(trial: Trial, together: int) -> Trial:
    """Return a trial with so many samples averaged into one, fewer at its ends and at gaps; its notes say so."""
    if together < 2 or len(trial.time) < 3 * together:
        return trial
    span = together * float(np.median(np.diff(trial.time)))
    inputs = [of for of in (trial.cart, trial.torques) if of is not None]
    measured = np.column_stack([trial.theta, *inputs])
    stretches = [_averaged(trial.time[a:b], measured[a:b], span) for a, b in trial.bounds]
    time, average = (np.concatenate(parts) for parts in zip(*stretches, strict=True))
    note = (
        f"{len(trial.time)} samples were averaged into {len(time)}, {together} into one: the motion is slower than that"
    )
    return replace(
        trial,
        time=time - time[0],
        theta=np.ascontiguousarray(average[:, :2]),
        cart=None if trial.cart is None else average[:, 2],
        torques=None if trial.torques is None else average[:, -2:],
        start=trial.start + float(time[0]),
        breaks=tuple(int(end) for end in np.cumsum([len(own) for own, _ in stretches])[:-1]),
        notes=(*trial.notes, note),
    )


def _averaged(time: Array, measured: Array, span: float) -> tuple[Array, Array]:
    """Return the mean time (m,) of the samples in each span, and what was measured (m, k) at that time."""
    place = np.floor((time - time[0]) / span).astype(np.int64)
    first = np.flatnonzero(np.diff(place, prepend=-1))
    count = np.diff(np.append(first, len(place)))

    def mean(values: Array) -> Array:
        return np.asarray(np.add.reduceat(values, first, axis=0).T / count).T

    own = mean(time)
    uneven = 0.5 * (mean(time**2) - own**2)[:, None]
    return own, mean(measured) - uneven * _second_derivative(own, mean(measured))


def _second_derivative(time: Array, values: Array) -> Array:
    """Return the second derivative (n, k) of values (n, k) by their neighbours; at the ends that of the next inside."""
    if len(time) < 3:
        return np.zeros_like(values)
    slopes = np.diff(values, axis=0) / np.diff(time)[:, None]
    second = 2.0 * np.diff(slopes, axis=0) / (time[2:] - time[:-2])[:, None]
    return np.concatenate([second[:1], second, second[-1:]])

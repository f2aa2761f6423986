# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""An encoder's noise and steps, from differences of neighbouring samples."""

import numpy as np

from cdp_ident.arrays import Array

SAMPLES = 5
"""Samples in a fourth divided difference, to which the pendulum's motion hardly contributes: at 200 Hz a swing at 10
rad/s of 1 rad leaves 6 microradians in it."""
SAME = 1e-9
"""Angles that differ by less are one reading [rad]."""
MEDIAN_OF_SIZE = 0.6745
"""Median of the size of a standard normal number."""


def fourth_differences(time: Array, values: Array, apart: int = 1) -> Array:
    """Return the fourth divided differences (m, ...) of values (n, ...) at times (n,), strictly increasing.

    They are of samples so many apart, n - 4 of them where these are neighbours, and scaled so that white noise of
    standard deviation 1 gives 1.
    """
    count, places = len(time) - apart * (SAMPLES - 1), apart * np.arange(SAMPLES)
    stamps = np.stack([time[k : k + count] for k in places], axis=1)
    later = stamps[:, :, None] - stamps[:, None, :]
    later[:, range(SAMPLES), range(SAMPLES)] = 1.0
    weights = 1.0 / later.prod(axis=2)
    weights /= np.linalg.norm(weights, axis=1, keepdims=True)
    columns = values.reshape(len(time), -1)
    differences = sum(weights[:, k, None] * columns[at : at + count] for k, at in enumerate(places))
    return np.asarray(differences).reshape(count, *values.shape[1:])


_OTHERS = 0.02
"""Least share of the changes that are not of one step: none, or of several."""


def encoder_step(angles: Array) -> float:
    """Return the step of the encoder that measured angles (n,) [rad], or 0 where none shows.

    All changes between samples are whole multiples of the step if there is one. Where all of them are about the same,
    as of a rod that turns evenly, none shows.
    """
    every = np.abs(np.diff(angles))
    changes = every[every > SAME]
    if len(changes) == 0:
        return 0.0
    smallest = float(changes.min())
    near = changes[changes < 1.5 * smallest]
    step = float(near.mean())
    multiples = changes[changes < 50 * step] / step
    whole = np.abs(multiples - np.round(multiples)) < 0.1
    others = np.mean(np.round(every / step) != 1.0)
    return step if len(near) >= 3 and np.mean(whole) > 0.95 and others > _OTHERS else 0.0

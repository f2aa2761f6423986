# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The noise of the measured angles, estimated from them alone.

White noise is what differences of neighbouring samples show. Noise that is remembered from sample to sample is what is
left about a smooth motion: a quintic regression spline with knots every few samples, which takes samples of any spacing
and does not distort motion that is slow relative to its knots. How many samples there are to a knot is chosen by the
Bayesian information criterion (Schwarz, Ann. Stat. 6, 1978), the noise being a first-order autoregressive process:
generalised cross-validation takes such noise for motion (Hart, J. R. Stat. Soc. B 53, 1991).
"""

from inspect import signature

import numpy as np
import numpy.typing as npt
from scipy.interpolate import BSpline, make_lsq_spline

from cdp_ident.fit.autocorrelation import correlation_length
from cdp_ident.trial.differences import MEDIAN_OF_SIZE, encoder_step, fourth_differences
from cdp_ident.trial.trial import Trial

Array = npt.NDArray[np.float64]

_STANDS_OUT = 4.0
"""Differences beyond so many standard deviations are not noise but impulses or outliers."""
DEGREE = 5
FEWEST = 4 * (DEGREE + 1)
"""Fewest samples that can be smoothed."""
_PER_KNOT = (1.2, 1.4, 1.7, 2.0, 2.5, 3.2, 4, 5, 6.4, 8, 10, 12.8, 16, 20, 25.6, 32, 40, 50, 64, 80, 100, 128)
"""Numbers of samples per knot that are tried."""
_REMEMBERED = 0.2
"""Noise is remembered clearly above this correlation of neighbouring samples: what a spline leaves of white noise has
up to 0.16, in 110 trials of hidden truths."""
_FORGOTTEN = 8.0
"""It is forgotten within so many distances of knots, where a vibration lasts. Seen: 4.2 at most."""
_ROUNDING = 1e-12
"""What a spline leaves of samples without noise, over their size."""
_TRIED = 4000
"""The knots are chosen by so many samples, of the stretch with the fastest motion."""
_NORMAL_EQUATIONS = {"method": "norm-eq"} if "method" in signature(make_lsq_spline).parameters else {}
"""SciPy before 1.15 solves these anyway, and has no such argument."""
_NOTHING = 1e-12
"""A difference that is rounding error [rad]."""


def noise_of(trial: Trial) -> Array:
    """Return the standard deviation of the noise of theta1 and theta2 [rad].

    It is that of fourth divided differences, scaled so that white noise of standard deviation 1 gives 1, without those
    that are not noise. Where the motion is slow, an encoder repeats its readings and the differences are zero;
    therefore the noise is never estimated below that of quantisation, the step over the square root of 12, of which
    theta2 has both encoders'. Nor is it below that about a smooth motion where it is remembered from one sample to the
    next, which differences do not show.
    """
    sizes = np.abs(fourth_differences(trial.time, trial.theta))
    longest = max(trial.stretches, key=lambda stretch: len(stretch.time))
    least = np.maximum(_rounding(encoder_steps(trial)), remembered_noise(longest.time, longest.theta))
    return np.maximum([_trimmed_deviation(column) for column in sizes.T], least)


def rounding_of_averages(trial: Trial, together: int) -> Array:
    """Return a lower limit (2,) of the root mean square error that rounding leaves in averages [rad].

    Where an encoder repeats its reading over two averages, both have its whole error, and their differences do not show
    it; where readings change, errors average out, and differences show the rest.

    Args:
        trial: as it was measured.
        together: how many of its samples are averaged into one.
    """
    span = 2 * together
    count = len(trial.time) // span
    angles = _encoder_angles(trial)[: count * span].reshape(count, span, 2)
    repeats = np.all(np.abs(np.diff(angles, axis=1)) <= _NOTHING, axis=1)
    return _rounding(encoder_steps(trial) * np.sqrt(np.mean(repeats, axis=0)))


def encoder_steps(trial: Trial) -> Array:
    """Return the steps (2,) of the inner and the outer encoder, 0 where none shows [rad]."""
    return np.array([encoder_step(angle) for angle in _encoder_angles(trial).T])


def _encoder_angles(trial: Trial) -> Array:
    """Return the angles (n, 2) of the inner and the outer encoder [rad]."""
    theta1, theta2 = trial.theta.T
    return np.column_stack([theta1, theta2 - theta1])


def _rounding(steps: Array) -> Array:
    """Return the root mean square error (2,) of theta1 and theta2 by encoders' steps (2,): theta2 has both [rad]."""
    return np.asarray(np.sqrt(np.cumsum(steps**2) / 12.0))


def _trimmed_deviation(sizes: Array) -> float:
    """Return the root mean square of differences of which the sizes are given, without those that stand out.

    Where an encoder mostly repeats its reading, the differences that are not zero are single steps, not outliers.
    """
    shown = sizes[sizes > _NOTHING]
    usual = float(np.median(shown)) / MEDIAN_OF_SIZE if len(shown) else 0.0
    return float(np.sqrt(np.mean(sizes[sizes <= _STANDS_OUT * usual + _NOTHING] ** 2)))


def remembered_noise(time: Array, samples: Array) -> Array:
    """Return the standard deviation (k,) of noise that is clearly remembered from sample to sample, or 0.

    Differences of neighbouring samples show less of it.

    Args:
        time: (n,) times of the samples [s], strictly increasing, of any spacing.
        samples: (n, k) measured angles [rad].
    """
    nothing = np.zeros(samples.shape[1])
    if len(time) < FEWEST:
        return nothing
    time, samples = _liveliest(time, samples)
    count, tried = len(time), list[tuple[float, float, float]]()
    smallest = (_ROUNDING * np.max(np.abs(samples))) ** 2 + np.finfo(float).tiny
    for per_knot in _PER_KNOT:
        unknowns = _unknowns(count, per_knot)
        if not DEGREE + 2 <= unknowns < count:
            continue
        left = samples - _fit(time, samples, per_knot)(time)
        variance = np.maximum(np.mean(left**2, axis=0), smallest)
        # What is remembered for longer than from knot to knot is motion.
        memory = float(np.clip(np.mean(np.mean(left[1:] * left[:-1], axis=0) / variance), 0.0, np.exp(-1 / per_knot)))
        fresh = np.maximum(np.mean((left[1:] - memory * left[:-1]) ** 2, axis=0), smallest)
        tried.append((float(np.sum(count * np.log(fresh) + unknowns * np.log(count))), per_knot, memory))
    _, per_knot, memory = min(tried)
    left = samples - _fit(time, samples, per_knot)(time)
    if memory <= _REMEMBERED or correlation_length([left]) >= _FORGOTTEN * per_knot:
        return nothing
    return np.asarray(np.sqrt(np.sum(left**2, axis=0) / (count - _unknowns(count, per_knot))))


def _liveliest(time: Array, samples: Array) -> tuple[Array, Array]:
    """Return the stretch of at most `_TRIED` samples with the fastest motion."""
    changes = np.concatenate([[0.0], np.cumsum(np.sum(np.diff(samples, axis=0) ** 2, axis=1))])
    count = min(_TRIED, len(time))
    first = int(np.argmax(changes[count - 1 :] - changes[: len(changes) - count + 1]))
    return time[first : first + count], samples[first : first + count]


def _unknowns(samples: int, per_knot: float) -> int:
    return int((samples - 1) / per_knot) + DEGREE


def _fit(time: Array, samples: Array, per_knot: float) -> BSpline:
    places = np.linspace(0, len(time) - 1, _unknowns(len(time), per_knot) - DEGREE + 1)[1:-1]
    inner = np.interp(places, np.arange(len(time)), time)
    knots = np.concatenate([np.full(DEGREE + 1, time[0]), inner, np.full(DEGREE + 1, time[-1])])
    return make_lsq_spline(time, samples, knots, DEGREE, **_NORMAL_EQUATIONS)

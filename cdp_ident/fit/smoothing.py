"""Smooth motion through noisy angles; the degree of smoothing follows from the data.

A quintic regression spline is fitted to the samples, with knots every few of them. It does not distort motion that is
slow relative to its knots, to sixth order, has smooth velocities, and takes samples of any spacing. The number of
samples per knot is chosen by generalised cross-validation (Craven and Wahba, Numer. Math. 31, 1979), so that neither
the noise nor the rig's time scale need be known. It takes noise that is remembered from sample to sample for motion
(Hart, J. R. Stat. Soc. B 53, 1991). So the number is sought by the Bayesian information criterion (Schwarz, Ann. Stat.
6, 1978), too, with noise that is a first-order autoregressive process, and that one is taken where the noise is found
to be remembered clearly.

The effect of the noise on anything computed from the smooth motion is found by simulated measurements: noise like that
of the samples is added, and the same spline is fitted (Cook and Stefanski, J. Am. Stat. Assoc. 89, 1994).
"""

from dataclasses import dataclass
from inspect import signature

import numpy as np
import numpy.typing as npt
from scipy.interpolate import BSpline, make_lsq_spline

from cdp_ident.errors import TrialError
from cdp_ident.fit.autocorrelation import correlation_length
from cdp_ident.fit.linear_filter import carried_on

Array = npt.NDArray[np.float64]
Mask = npt.NDArray[np.bool_]

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
_LONGEST_GAP = 2.0
"""Gap between neighbouring samples, in distances of knots, over which the motion counts as unknown."""

_END = 3.0
"""Distance from either end, in distances of knots, within which a spline's slopes are inaccurate."""


@dataclass(frozen=True)
class SmoothMotion:
    """A motion on an even grid of times, and copies of it with simulated noise."""

    time: Array
    """(m,) times of the grid [s]."""
    values: Array
    """(1 + copies, m, k) smoothed angles [rad] and whatever else was measured; the copies have more noise."""
    rates: Array
    """(1 + copies, m, k) their rates of change [1/s]."""
    known: Mask
    """(m,) where samples are near enough."""
    noise: Array
    """(k, k) covariance of the samples about the smooth motion."""
    per_knot: float
    """Samples per knot."""

    @property
    def spacing(self) -> float:
        """Distance of the grid's times [s]."""
        return float(self.time[1] - self.time[0])


def smooth(time: Array, samples: Array, spacing: float, copies: int, rng: np.random.Generator) -> SmoothMotion:
    """Smooth samples and give them on a grid, as measured and as if measured again.

    Args:
        time: (n,) times of the samples [s], strictly increasing, of any spacing.
        samples: (n, k) what was measured: angles [rad], a cart's position [m].
        spacing: of the grid [s].
        copies: number of copies with simulated noise.
        rng: where the noise of the copies comes from.

    Raises:
        TrialError: there are too few samples.
    """
    if len(time) < FEWEST:
        raise TrialError(f"there are only {len(time)} samples; a smooth motion needs at least {FEWEST}")
    per_knot, memory = _samples_per_knot(*_liveliest(time, samples))
    spline = _fit(time, samples, per_knot)
    fitted = spline(time)
    freedom = len(time) - _unknowns(len(time), per_knot)
    noise = np.atleast_2d((samples - fitted).T @ (samples - fitted)) / freedom
    at = np.arange(time[0], time[-1], spacing)
    again = rng.multivariate_normal(np.zeros(len(noise)), noise, (copies, len(time)), method="svd")
    if memory:
        new = np.sqrt(1.0 - memory**2) * np.moveaxis(again, 1, 0)
        again = np.moveaxis(carried_on(np.array([memory]), new), 0, 1)
    sheets = [spline] if copies == 0 else [spline, _fit(time, np.moveaxis(again, 0, 1), per_knot)]
    at_grid = [(sheet(at), sheet.derivative()(at)) for sheet in sheets]
    values, rates = (own[None] for own in at_grid[0])
    for noisy_values, noisy_rates in at_grid[1:]:
        values = np.concatenate([values, values + np.moveaxis(noisy_values, 1, 0)])
        rates = np.concatenate([rates, rates + np.moveaxis(noisy_rates, 1, 0)])
    gap = np.diff(time)
    knots = per_knot * float(np.median(gap))
    index = np.clip(np.searchsorted(time, at, side="right") - 1, 0, len(gap) - 1)
    inside = (at > time[0] + _END * knots) & (at < time[-1] - _END * knots)
    return SmoothMotion(at, values, rates, inside & (gap[index] <= _LONGEST_GAP * knots), noise, per_knot)


def remembered_noise(time: Array, samples: Array) -> Array:
    """Return the standard deviation (k,) of samples' noise where it is clearly remembered from one to the next, or 0.

    Differences of neighbouring samples show less of it. Arguments as in `smooth`.
    """
    if len(time) < FEWEST:
        return np.zeros(samples.shape[1])
    time, samples = _liveliest(time, samples)
    per_knot, memory = _samples_per_knot(time, samples)
    if not memory:
        return np.zeros(samples.shape[1])
    left = samples - _fit(time, samples, per_knot)(time)
    return np.sqrt(np.sum(left**2, axis=0) / (len(time) - _unknowns(len(time), per_knot)))


def _liveliest(time: Array, samples: Array) -> tuple[Array, Array]:
    """Return the stretch of at most `_TRIED` samples with the fastest motion."""
    changes = np.concatenate([[0.0], np.cumsum(np.sum(np.diff(samples, axis=0) ** 2, axis=1))])
    count = min(_TRIED, len(time))
    first = int(np.argmax(changes[count - 1 :] - changes[: len(changes) - count + 1]))
    return time[first : first + count], samples[first : first + count]


@dataclass(frozen=True)
class _Tried:
    """A spline with so many samples a knot."""

    per_knot: float
    cross_validated: Array
    """(k,) generalised cross-validation of each angle, for white noise."""
    criterion: float
    """The Bayesian information criterion, for a first-order autoregressive process."""
    memory: float
    """Correlation of neighbouring samples in that process."""


def _samples_per_knot(time: Array, samples: Array) -> tuple[float, float]:
    """Return the samples a knot, and the correlation of the noise of neighbouring samples where that is clear, or 0."""
    count = len(time)
    smallest = (_ROUNDING * np.max(np.abs(samples))) ** 2 + np.finfo(float).tiny
    tried = list[_Tried]()
    for per_knot in _PER_KNOT:
        unknowns = _unknowns(count, per_knot)
        if unknowns < DEGREE + 2:
            break
        if unknowns >= count:
            continue  # it leaves nothing, whatever the samples are
        left = samples - _fit(time, samples, per_knot)(time)
        variance = np.maximum(np.mean(left**2, axis=0), smallest)
        # What is remembered for longer than from knot to knot is motion.
        memory = float(np.clip(np.mean(np.mean(left[1:] * left[:-1], axis=0) / variance), 0.0, np.exp(-1 / per_knot)))
        fresh = np.maximum(np.mean((left[1:] - memory * left[:-1]) ** 2, axis=0), smallest)
        criterion = float(np.sum(count * np.log(fresh) + unknowns * np.log(count)))
        tried.append(_Tried(per_knot, variance / (1 - unknowns / count) ** 2, criterion, memory))
    best = min(tried, key=lambda one: one.criterion)
    if best.memory > _REMEMBERED:
        left = samples - _fit(time, samples, best.per_knot)(time)
        if correlation_length([left]) < _FORGOTTEN * best.per_knot:
            return best.per_knot, best.memory
    return min(tried, key=lambda one: float(np.sum(one.cross_validated / tried[0].cross_validated))).per_knot, 0.0


def _unknowns(samples: int, per_knot: float) -> int:
    return int((samples - 1) / per_knot) + DEGREE


def _fit(time: Array, samples: Array, per_knot: float) -> BSpline:
    places = np.linspace(0, len(time) - 1, _unknowns(len(time), per_knot) - DEGREE + 1)[1:-1]
    inner = np.interp(places, np.arange(len(time)), time)
    knots = np.concatenate([np.full(DEGREE + 1, time[0]), inner, np.full(DEGREE + 1, time[-1])])
    return make_lsq_spline(time, samples, knots, DEGREE, **_NORMAL_EQUATIONS)

"""How much noise the encoders' angles carry, estimated from the angles alone."""

import numpy as np
import numpy.typing as npt

from cdp_ident.trial.trial import Trial

Array = npt.NDArray[np.float64]

_SAMPLES = 5
"""Samples in a fourth divided difference, which a motion of the pendulum hardly enters: at 200 Hz a swing at 10 rad/s
of 1 rad leaves 6 microradians in it."""
_MEDIAN_OF_SIZE = 0.6745
"""Median of the size of a standard normal number."""


def noise_of(trial: Trial) -> Array:
    """Return the standard deviation of the noise of theta1 and theta2 [rad].

    It is that of fourth divided differences, scaled so that white noise of standard deviation 1 gives 1, by the
    median of their size, so that knocks and wild samples do not count. Where the motion is slow, an encoder's steps
    repeat and hide from differences; therefore the noise is never put below that of the steps themselves, their
    size over the square root of 12.
    """
    time, theta = trial.time, trial.theta
    count = len(time) - _SAMPLES + 1
    stamps = np.stack([time[k : k + count] for k in range(_SAMPLES)], axis=1)
    apart = stamps[:, :, None] - stamps[:, None, :]
    apart[:, range(_SAMPLES), range(_SAMPLES)] = 1.0
    weights = 1.0 / apart.prod(axis=2)
    weights /= np.linalg.norm(weights, axis=1, keepdims=True)
    differences = sum(weights[:, k, None] * theta[k : k + count] for k in range(_SAMPLES))
    sizes = np.abs(np.asarray(differences))
    spread = np.median(sizes, axis=0) / _MEDIAN_OF_SIZE
    # With more steps repeated than not, the median itself is a step; the mean square is the better of the two then.
    coarse = np.mean(sizes < 1e-12, axis=0) > 0.1
    spread = np.where(coarse, np.sqrt(np.mean(sizes**2, axis=0)), spread)
    return np.maximum(spread, [encoder_step(theta[:, k]) / np.sqrt(12.0) for k in range(theta.shape[1])])


def encoder_steps(trial: Trial) -> Array:
    """Return the steps (2,) of the inner and the outer encoder, 0 where none shows [rad]."""
    theta1, theta2 = trial.theta.T
    return np.array([encoder_step(theta1), encoder_step(theta2 - theta1)])


def encoder_step(angles: Array) -> float:
    """Return the step of the encoder that measured angles (n,) [rad], or 0 where none shows.

    All changes between samples are whole multiples of the step if there is one.
    """
    changes = np.abs(np.diff(angles))
    changes = changes[changes > 1e-9]
    if len(changes) == 0:
        return 0.0
    smallest = float(changes.min())
    near = changes[changes < 1.5 * smallest]
    step = float(near.mean())
    multiples = changes[changes < 50 * step] / step
    whole = np.abs(multiples - np.round(multiples)) < 0.1
    return step if len(near) >= 3 and np.mean(whole) > 0.95 else 0.0

"""How much noise the encoders' angles carry, estimated from the angles alone."""

import numpy as np
import numpy.typing as npt

from cdp_ident.trial.differences import MEDIAN_OF_SIZE, encoder_step, fourth_differences
from cdp_ident.trial.trial import Trial

Array = npt.NDArray[np.float64]


def noise_of(trial: Trial) -> Array:
    """Return the standard deviation of the noise of theta1 and theta2 [rad].

    It is that of fourth divided differences, scaled so that white noise of standard deviation 1 gives 1, by the
    median of their size, so that knocks and wild samples do not count. Where the motion is slow, an encoder's steps
    repeat and hide from differences; therefore the noise is never put below that of the steps themselves, their
    size over the square root of 12.
    """
    theta = trial.theta
    sizes = np.abs(fourth_differences(trial.time, theta))
    spread = np.median(sizes, axis=0) / MEDIAN_OF_SIZE
    # With more steps repeated than not, the median itself is a step; the mean square is the better of the two then.
    coarse = np.mean(sizes < 1e-12, axis=0) > 0.1
    spread = np.where(coarse, np.sqrt(np.mean(sizes**2, axis=0)), spread)
    return np.maximum(spread, [encoder_step(theta[:, k]) / np.sqrt(12.0) for k in range(theta.shape[1])])


def encoder_steps(trial: Trial) -> Array:
    """Return the steps (2,) of the inner and the outer encoder, 0 where none shows [rad]."""
    theta1, theta2 = trial.theta.T
    return np.array([encoder_step(theta1), encoder_step(theta2 - theta1)])

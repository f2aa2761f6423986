# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where gravity pulls, by the motion: it tells whether a camera leans, and where a counter of a few bits began."""

from dataclasses import replace

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.errors import TrialError
from cdp_ident.trial.joints import Samples, in_radians, model_angles
from cdp_ident.trial.lumped import gravity_directions
from cdp_ident.trial.meaning import balance_of
from cdp_ident.trial.options import TrialOptions
from cdp_ident.trial.recorded_motion import recorded_motion


def gravity_of(samples: Samples, options: TrialOptions) -> Array | None:
    """Return how far gravity is from where each rod's angle takes it to be (2,) [rad]; None with too little motion.

    Raises TrialError where no stretch of samples is long enough.
    """
    recorded = recorded_motion(samples, options)
    balance = balance_of(recorded, options)
    return gravity_directions(balance.trusted) if balance else None


def in_right_ranges(samples: Samples, options: TrialOptions) -> Samples:
    """Return samples whose counters of a few bits began in the range in which gravity pulls down.

    They are left as they are where the motion is too little to tell.
    """
    if not any(samples.ranges):
        return samples
    try:
        off = gravity_of(samples, options)
    except TrialError:  # it is told where the motion is looked for
        return samples
    if off is None:
        return samples
    still, added = model_angles(np.zeros((1, 2)), options), np.asarray(np.zeros((1, 2)))
    sizes = in_radians(np.array([samples.ranges]), options)[0]
    for joint in np.flatnonzero(sizes):
        most = max(1, round(np.pi / sizes[joint]))
        tried = np.repeat(added, 2 * most + 1, axis=0)
        tried[:, joint] = np.arange(-most, most + 1) * samples.ranges[joint]
        turned = (model_angles(in_radians(tried, options), options) - still)[:, joint]
        added = tried[[np.argmin(np.abs(np.angle(np.exp(1j * (turned - off[joint])))))]]
    return replace(samples, angles=samples.angles + added)

"""The paper's model, fitted to a pendulum with a spring in its outer joint."""

import numpy as np
import pytest

from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.refinement import refine
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.parameters import SYMBOLS, groups_of
from cdp_ident.tracing.refits import attempt_of
from reference.pendulum import TABLE_5
from scenarios.twin import TEN_SECONDS, twin

STIFFNESS = 0.02
"""Of the spring [N m/rad]."""


def sprung(time, state):
    torque = -STIFFNESS * (state[1] - state[0])
    return -torque, torque


@pytest.fixture(scope="session")
def plain():
    start = (2.2, 2.6, 0.0, 0.0)
    trial = twin(np.random.default_rng(0), start=start, times=TEN_SECONDS, noise=5e-4, torque=sprung, tolerance=1e-8)
    windows = cut_into_windows([trial], 1.25)
    model = MotionModel(Mechanism.of(Prior()))
    truth = groups_of([TABLE_5[symbol] for symbol in SYMBOLS], TABLE_5["L"])
    return attempt_of(refine(model, truth, windows), tuple(tuple(range(len(windows))[k::4]) for k in range(4)))

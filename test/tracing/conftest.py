# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The paper's model, fitted to whole swings of a pendulum with nothing hidden and with friction in its outer joint."""

import numpy as np
import pytest

from scenarios.swings import fitted, measured, motion, recorded

FRICTION = 4e-4
"""In the outer joint [N m]."""


@pytest.fixture(scope="session")
def clean():
    return fitted(recorded([measured(motion(), np.random.default_rng(1))]))


@pytest.fixture(scope="session")
def rubbing():
    return fitted(recorded([measured(motion(dry=FRICTION), np.random.default_rng(0))]))

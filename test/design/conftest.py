# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A rig of which one swing is recorded, for all that a next one is asked of."""

import numpy as np
import pytest

from scenarios.next_swing import Swings, swing


@pytest.fixture(scope="session")
def swings(made_once):
    return made_once("swings", lambda: Swings.of([swing(3.6, 3.9, np.random.default_rng(0))]))


@pytest.fixture(scope="session")
def known(swings):
    return swings.knowledge

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rigs, their encoders and how they are let go, drawn at random: the ground that hidden truths stand on."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from reference.encoders import Counter
from reference.pendulum import SYMBOLS, TABLE_2, TABLE_3, TABLE_5

Array = npt.NDArray[np.float64]

TRIALS = 3
SIZES = (0.3, 3.0)
"""Of the rigs, over the paper's."""
RATES = (100, 200, 500, 1000)
"""Samples a second [Hz]."""
COUNTS = (2000, 4000, 8000, 20_000)
"""Counts of an encoder's turn."""
NOISE = (0.05e-3, 2e-3)
"""Standard deviation of what is added to an encoder's angle before it is counted [rad]."""
DURATIONS = (10.0, 15.0)
"""Of a trial [s]."""
NOMINAL_ERROR = 0.3
"""Nominal values are off by up to so much."""
RULER = 0.5e-3
"""Standard deviation of the distance between the joints, as it is measured [m]."""
GRAVITY = (9.78, 9.83)
"""What g is taken for, anywhere; it is 9.81 m/s^2."""
_CORRELATED = 0.2
"""In so many settings the noise is correlated."""


@dataclass(frozen=True)
class Setting:
    """A rig, its encoders, and its trials."""

    size: float
    """Of the rig over the paper's."""
    values: Mapping[str, float]
    """The rig's physical values."""
    nominal: Mapping[str, float]
    """What a user would know beforehand: L as measured with a ruler, g of some place, and estimates of the rest."""
    rate: int
    """Samples a second [Hz]."""
    counter: Counter
    """Both encoders."""
    starts: tuple[Array, ...]
    """(4,) start of each trial: theta1, theta2 [rad], omega1, omega2 [rad/s]."""
    times: tuple[Array, ...]
    """(n,) time of each sample since the first one, of each trial [s]."""


def draw_setting(rng: np.random.Generator) -> Setting:
    """Return a setting."""
    size = float(np.exp(rng.uniform(*np.log(SIZES))))
    values = _rig(size, rng)
    nominal = {
        symbol: value * rng.uniform(1.0 - NOMINAL_ERROR, 1.0 + NOMINAL_ERROR) for symbol, value in values.items()
    }
    measuring = rng.spawn(1)[0]
    nominal |= {"L": values["L"] + measuring.normal(0.0, RULER), "g": float(measuring.uniform(*GRAVITY))}
    rate = int(rng.choice(RATES))
    counter = Counter(
        int(rng.choice(COUNTS)),
        float(np.exp(rng.uniform(*np.log(NOISE)))),
        rng.uniform(0.5, 0.9) if rng.random() < _CORRELATED else 0.0,
    )
    starts = tuple(_start(size, rng) for _ in range(TRIALS))
    times = tuple(np.arange(round(rng.uniform(*DURATIONS) * rate)) / rate for _ in range(TRIALS))
    return Setting(size, values, nominal, rate, counter, starts, times)


def _rig(size: float, rng: np.random.Generator) -> dict[str, float]:
    """Return physical values of a rig so many times the size of the paper's, all others changed by up to 30 %."""
    values = dict(TABLE_5 if rng.random() < 0.5 else TABLE_2)
    heavier = size ** rng.uniform(1.5, 3.0)
    inertia = heavier * size**2
    # A motion's own time goes with the root of the length, and friction is to damp it as much as the paper's.
    scales = dict.fromkeys(SYMBOLS, 1.0) | dict.fromkeys(("m1", "m2", "m0"), heavier)
    scales |= dict.fromkeys(("J1", "J2"), inertia) | dict.fromkeys(("c1", "c2"), inertia / math.sqrt(size))
    scales |= dict.fromkeys(("l1", "l2", "L"), size)
    for symbol in SYMBOLS:
        spread = {"l1": 0.15, "l2": 0.15, "L": 0.0, "g": 0.0}.get(symbol, 0.3)
        values[symbol] *= scales[symbol] * rng.uniform(1.0 - spread, 1.0 + spread)
    return values


def _start(size: float, rng: np.random.Generator) -> Array:
    """Return a start (4,): let go at rest far from hanging, or on its way as the paper's was."""
    if rng.random() < 0.7:
        sides = rng.choice([-1.0, 1.0], 2)
        return np.array([*(math.pi + sides * rng.uniform(0.6, 2.5, 2)), 0.0, 0.0])
    moving = np.array(TABLE_3) * rng.uniform(0.8, 1.2, 4)
    moving[2:] /= math.sqrt(size)
    return moving

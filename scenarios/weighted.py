# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Trials of one rig without and with a weight on its outer rod, as the package's own."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from cdp_ident.model.weights import Weight
from cdp_ident.trial.trial import Trial
from reference.pendulum import TABLE_5, Array, Torque
from reference.weights import with_weight
from scenarios.paper_rig import A22
from scenarios.twin import TEN_SECONDS, twin

WEIGHT = Weight("outer", 0.05, 0.3, mass_std=1e-5, place_std=1e-4)
"""50 g, weighed to 10 mg and clamped to 0.1 mm."""
STARTS = ((2.2, 2.0, 0.0, 0.0), (2.4, 2.5, 0.0, 0.0))
INERTIA = A22
"""Of the rig without the weight [kg m^2]."""
FRICTION = 2e-3
"""Of `dry_friction` [N m]."""


def dry_friction(_time: float, state: Array) -> tuple[float, float]:
    """Return the torques on the rods of dry friction in the outer joint."""
    size = FRICTION * float(np.tanh((state[3] - state[2]) / 0.02))
    return size, -size


def plain_and_weighted(
    rng: np.random.Generator,
    weight: Weight = WEIGHT,
    actual: Weight | None = None,
    values: Mapping[str, float] = TABLE_5,
    times: Array = TEN_SECONDS,
    torque: Torque | None = None,
    noise: float = 2e-3,
) -> list[Trial]:
    """Return a trial without and one with a weight.

    Args:
        rng: where the noise comes from.
        weight: what the trial says of it.
        actual: what it is, where that is something else.
        values: physical values of the rig without it.
        times: (n,) of the samples [s].
        torque: a hidden effect [N m]; see `reference.pendulum.motion`.
        noise: of the angles [rad].
    """
    actual = actual or weight
    heavier = with_weight(values, actual.rod, actual.mass, actual.place, actual.inertia)
    plain, weighted = (
        twin(rng, of, start, times, torque=torque, noise=noise, tolerance=1e-8, name=name)
        for name, of, start in zip(("one", "two"), (values, heavier), STARTS, strict=True)
    )
    return [plain, replace(weighted, weights=(weight,))]

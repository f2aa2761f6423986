# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Motors in the joints, whose torques are recorded: known inputs, not an effect that is looked for."""

from cdp_ident.model.effects.effect import Effect, EffectParameter, Law

_LATE = 0.05
"""No motor is later, or its record, than this [s]."""

MOTORS = Effect(
    "motors",
    "base",
    "the motors' torques, as they were recorded",
    Law(
        torques=("inner - outer", "outer"),
        where=(
            ("inner", "gain*(drive_inner - lag_inner*(drive_rate_inner - 0.5*lag_inner*drive_curvature_inner))"),
            ("late", "drive_outer - lag_outer*(drive_rate_outer - 0.5*lag_outer*drive_curvature_outer)"),
            ("outer", "gain*(1 + imbalance)*late"),
        ),
    ),
    (
        EffectParameter("gain", "1", 0.0, float("inf"), 1.0, inertia_power=1),
        EffectParameter("imbalance", "1", -0.5, 1.0, 0.0, shape=True),
        EffectParameter("lag_inner", "s", -_LATE, _LATE, 0.0, width=0.005, shape=True),
        EffectParameter("lag_outer", "s", -_LATE, _LATE, 0.0, width=0.005, shape=True),
    ),
    "a current-controlled motor's torque follows its command with a small lag: Siciliano et al., Robotics, 2009, 8",
)
"""What acts is the recorded torque, a lag later to second order in that. Its gain is 1 / A22 where the record is in
N m; `imbalance` says by how much the gain of the outer joint's motor is larger."""

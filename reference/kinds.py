# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which effects truths have: a kind is `none`, or names with joints, `name.joint+name.joint`."""

from collections.abc import Sequence

import numpy as np

_IN_BOTH = ("coulomb_friction", "stribeck_friction", "quadratic_friction", "load_friction", "air_drag", "joint_spring",
            "cogging_torque", "impulse", "encoder_offset", "encoder_scale", "encoder_eccentricity",
            "encoder_slip", "backlash", "constant_torque", "varying_viscosity", "encoder_harmonic",
            "encoder_compliance", "magnet", "end_stop", "drifting_viscosity", "drifting_encoder_offset",
            "encoder_interpolation", "eddy_brake")  # fmt: skip
SINGLE = (*(f"{name}.{joint}" for name in _IN_BOTH for joint in ("inner", "outer")), "gravity_tilt.base",
          "pivot_compliance.base", "heavy_cart.base", "time_offset.outer", "rod_flex.inner",
          "oblique_view.base", "side_force.base", "bob_drag.outer")  # fmt: skip
"""One effect that has a name in the package."""
SEVERAL = (
    "coulomb_friction.outer+air_drag.outer",
    "coulomb_friction.inner+coulomb_friction.outer",
    "coulomb_friction.inner+encoder_offset.outer",
    "encoder_offset.inner+encoder_offset.outer",
    "air_drag.outer+time_offset.outer",
    "coulomb_friction.inner+air_drag.outer",
    "gravity_tilt.base+coulomb_friction.inner",
    "joint_spring.inner+coulomb_friction.outer",
    "coulomb_friction.outer+encoder_eccentricity.outer",
    "coulomb_friction.outer+air_drag.outer+encoder_offset.outer",
    "coulomb_friction.inner+coulomb_friction.outer+encoder_offset.outer",
    "coulomb_friction.inner+air_drag.inner+encoder_eccentricity.inner",
    "cogging_torque.outer+cogging_torque.outer",
    "coulomb_friction.inner+constant_torque.inner",
    "coulomb_friction.outer+constant_torque.outer",
)
"""Two or three of them."""
STICKING = (
    "stopping.inner",
    "stopping.outer",
    "stopping.inner+stopping.outer",
    "breakaway.inner",
    "breakaway.outer",
    "stopping.inner+encoder_offset.outer",
    "stopping.outer+air_drag.outer+encoder_offset.outer",
    "stopping.outer+joint_spring.inner",
)
"""Dry friction that stops a joint within seconds: Coulomb's, or Stribeck's with its larger torque at rest."""
BEYOND = ("partial_rub.inner", "presliding_friction.outer",
          "partial_rub.outer", "rotor_inertia.outer", "presliding_friction.inner",
          "drifting_friction.inner", "drifting_friction.outer", "encoder_filter.inner",
          "encoder_filter.outer")  # fmt: skip
"""What has no name in the package."""
GROUPS = {"none": ("none",), "single": SINGLE, "several": SEVERAL, "sticking": STICKING, "beyond": BEYOND}
KINDS = tuple(kind for kinds in GROUPS.values() for kind in kinds)

_THREE = 0.3
"""Share of combined truths that have three effects."""

_ALIKE = (
    {"gravity_tilt.base", "side_force.base", "encoder_offset.inner", "drifting_encoder_offset.inner"},
    {"encoder_offset.outer", "drifting_encoder_offset.outer"},
    {"heavy_cart.base", "pivot_compliance.base"},
    {"quadratic_friction.inner", "air_drag.inner"},
    {"bob_drag.outer", "air_drag.outer"},
    {"eddy_brake.inner", "varying_viscosity.inner"},
    {"eddy_brake.outer", "varying_viscosity.outer"},
    {"coulomb_friction.inner", "stribeck_friction.inner"},
    {"coulomb_friction.outer", "stribeck_friction.outer"},
)
"""Of these, which are the same motion or a special case of it, a combined truth has one."""

_IN_MUJOCO = ("none", "coulomb_friction", "stopping", "joint_spring", "gravity_tilt", "pivot_compliance", "heavy_cart",
              "rotor_inertia", "encoder_offset", "encoder_scale", "encoder_eccentricity", "encoder_slip", "time_offset",
              "backlash", "rod_flex", "encoder_harmonic", "encoder_compliance", "oblique_view",
              "drifting_encoder_offset", "encoder_interpolation")  # fmt: skip


def group_of(kind: str) -> str:
    """Return the name of a kind's group; one that is in no list is of several effects, or a single one."""
    listed = next((group for group, kinds in GROUPS.items() if kind in kinds), None)
    return listed or ("several" if "+" in kind else "single")


def in_mujoco(kind: str) -> bool:
    """Return whether the rigid-body engine has elements for all of a kind; encoders are added to any motion."""
    return all(part.split(".")[0] in _IN_MUJOCO for part in kind.split("+"))


def spread(count: int, engines: Sequence[str], first: int = 0) -> list[tuple[str, int, str]]:
    """Return kind, seed and engine of so many truths of all groups: a sixth of them have nothing in them.

    Args:
        count: how many.
        engines: "equations", "mujoco"; of both, they take turns where the rigid-body engine can move a kind.
        first: the first seed.
    """
    others = _in_turns([kinds for group, kinds in GROUPS.items() if group != "none"])
    if "equations" not in engines:
        others = [kind for kind in others if in_mujoco(kind)]
    chosen: list[tuple[str, int, str]] = []
    moved = 0
    for index in range(count):
        empty, number = index % 6 == 0, index - (index + 5) // 6
        kind = "none" if empty else others[number % len(others)]
        seed = first + (index // 6 if empty else number // len(others))
        engine = "equations"
        if in_mujoco(kind):
            engine = engines[moved % len(engines)]
            moved += 1
        chosen.append((kind, seed, engine))
    return chosen


def combined(count: int, engines: Sequence[str], first: int = 0) -> list[tuple[str, int, str]]:
    """Return kind, seed and engine of so many truths of two or three effects each, drawn of all single ones.

    Arguments are those of `spread`.
    """
    rng = np.random.default_rng(first)
    chosen = list[tuple[str, int, str]]()
    for seed in range(first, first + count):
        drawn = set[str](rng.choice(SINGLE, 3 if rng.random() < _THREE else 2, replace=False).tolist())
        for alike in _ALIKE:
            drawn -= set(sorted(drawn & alike)[1:])
        kind = "+".join(sorted(drawn))
        possible = [engine for engine in engines if engine == "equations" or in_mujoco(kind)]
        chosen.append((kind, seed, possible[seed % len(possible)] if possible else "equations"))
    return chosen


def _in_turns(groups: Sequence[Sequence[str]]) -> list[str]:
    """Return all kinds, one of each group in turns; a group that is through is left out."""
    return [kinds[k] for k in range(max(map(len, groups))) for kinds in groups if k < len(kinds)]

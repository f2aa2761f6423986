# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The same pendulum as a rigid-body engine moves it: MuJoCo knows bodies and joints, and nothing of our equations.

Its dry friction is a constraint that it solves for in every step: a joint that holds creeps by some 1e-7 rad/s.
"""

import math
from collections.abc import Sequence

import mujoco
import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicHermiteSpline

from reference.dry_friction import DryFriction
from reference.mechanics import Rig
from reference.plant import Path, Plant
from reference.torques import SPRING, Joint, Torque

Array = npt.NDArray[np.float64]

_STEP = 1.5e-3
"""Step over the root of the inner rod's length, which the motion's own time goes with [s / m^0.5]."""
_FINE = 1.0 / 128.0
"""A step in which a joint with dry friction turns round is so much shorter."""
_STILL = 1e-6
"""A joint of this rate is stuck [rad/s]."""
_IMPEDANCE = "0.99999 0.99999 1e-3 0.5 2"
"""How little a joint that sticks gives way (`solimp` in MuJoCo's terms)."""
_POINT = 1e-12
"""Inertia of what is a point, which the engine does not take as 0 [kg m^2]."""


def can_move(plant: Plant) -> bool:
    """Return whether the engine has elements for all that is in a plant."""
    frictions, springs = (plant.inner, plant.outer), [torque for torque in plant.torques if torque.kind == SPRING]
    plain = all(friction == DryFriction(torque=friction.torque) for friction in frictions)
    return plain and len(springs) == len(plant.torques) == len({torque.joint for torque in springs})


def path(plant: Plant, start: Sequence[float] | Array, times: Array) -> Path:
    """Return a motion as `sticking.path` does, to about 1e-6 rad; the events are not told.

    Raises:
        ValueError: the engine has no element for something in the plant.
        ArithmeticError: the motion could not be followed.
    """
    if not can_move(plant):
        raise ValueError(f"MuJoCo has no element for all of {plant}")
    step = _STEP * math.sqrt(plant.rig.values["L"])
    model = mujoco.MjModel.from_xml_string(description(plant, step))
    data = mujoco.MjData(model)
    cart = plant.rig.cart is not None
    theta1, theta2, omega1, omega2 = start
    data.qpos[:] = [0.0] * cart + [theta1, theta2 - theta1]
    data.qvel[:] = [0.0] * cart + [omega1, omega2 - omega1]
    dry = np.array([plant.inner.any, plant.outer.any])
    moments, rows = [float(times[0])], []
    while True:
        mujoco.mj_forward(model, data)
        rows.append(np.stack([data.qpos, data.qvel, data.qacc]))
        if moments[-1] >= times[-1]:
            break
        # Near rest; longer steps also make the engine spread a turn of the friction over higher rates.
        rates, changes = np.abs(data.qvel[-2:]), np.abs(data.qacc[-2:])
        turning = dry & (rates > _STILL) & (rates < 2.0 * step * changes)
        model.opt.timestep = step * _FINE if turning.any() else step
        mujoco.mj_step(model, data)
        moments.append(moments[-1] + model.opt.timestep)
    places, speeds, changes = np.moveaxis(np.array(rows), 1, 0)
    if not np.all(np.isfinite(changes)):
        raise ArithmeticError("MuJoCo's motion diverged")
    spline = CubicHermiteSpline(moments, places, speeds)
    positions, speeds = spline(times), spline(times, 1)
    accelerations = np.stack([np.interp(times, moments, column) for column in changes.T], axis=1)
    absolute = [np.cumsum(joints[:, -2:], axis=1) for joints in (positions, speeds, accelerations)]
    return Path(
        times, np.concatenate(absolute[:2], axis=1), absolute[2], positions[:, 0] if cart else np.zeros(len(times))
    )


def description(plant: Plant, step: float) -> str:
    """Return MuJoCo's description of a plant, for steps of so many seconds."""
    rig, v = plant.rig, plant.rig.values
    pull_x, pull_z = -v["g"] * math.sin(rig.tilt), -v["g"] * math.cos(rig.tilt)
    joints = {
        "inner": _hinge("inner", v["c1"], 0.0, plant.inner, plant.torques, math.pi, step),
        "outer": _hinge("outer", v["c2"], rig.rotor, plant.outer, plant.torques, 0.0, step),
    }
    return f"""
    <mujoco>
      <compiler angle="radian" balanceinertia="false" inertiafromgeom="false"/>
      <option timestep="{step:.17g}" integrator="RK4" solver="Newton" tolerance="1e-14" iterations="50"
              ls_tolerance="1e-6" gravity="{pull_x:.17g} 0 {pull_z:.17g}">
        <flag contact="disable"/>
      </option>
      <worldbody>
        <body>
          {_rail(rig)}
          <body>
            {joints["inner"]}
            {_mass(v["m1"], v["l1"], v["J1"])}
            <body pos="0 0 {v["L"]:.17g}">{_mass(v["m0"], 0.0, _POINT)}</body>
            <body pos="0 0 {v["L"]:.17g}">
              {joints["outer"]}
              {_mass(v["m2"], v["l2"], v["J2"])}
            </body>
          </body>
        </body>
      </worldbody>
    </mujoco>"""


def _mass(mass: float, along: float, inertia: float) -> str:
    inertias = f"{inertia:.17g} {inertia:.17g} {inertia:.17g}"
    return f'<inertial pos="0 0 {along:.17g}" mass="{max(mass, _POINT):.17g}" diaginertia="{inertias}"/>'


def _rail(rig: Rig) -> str:
    if rig.cart is None:
        return _mass(1.0, 0.0, 1.0)
    slide = (
        f'<joint type="slide" axis="1 0 0" stiffness="{rig.cart.stiffness:.17g}" damping="{rig.cart.damping:.17g}"/>'
    )
    return slide + _mass(rig.cart.mass, 0.0, 1.0)


def _hinge(
    joint: Joint, damping: float, armature: float, dry: DryFriction, torques: Sequence[Torque], rest: float, step: float
) -> str:  # fmt: skip
    stiffness, at_ease = next((torque.numbers for torque in torques if torque.joint == joint), (0.0, 0.0))
    return (
        f'<joint type="hinge" axis="0 1 0" damping="{damping:.17g}" armature="{armature:.17g}" '
        f'stiffness="{stiffness:.17g}" springref="{rest + at_ease:.17g}" frictionloss="{dry.torque:.17g}" '
        f'solreffriction="{2.0 * step * _FINE:.17g} 1" solimpfriction="{_IMPEDANCE}"/>'
    )

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a user of MuJoCo would take: the rig as its bodies and joints, its rollout, and its system identification."""

import contextlib
import io
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any

import mujoco
import mujoco.rollout
import numpy as np
import numpy.typing as npt

from cdp_ident.model.parameters import SYMBOLS

try:
    from mujoco import sysid
except ImportError:
    sysid = None

Array = npt.NDArray[np.float64]

STEP = 0.005
"""Of its Runge-Kutta method [s]: the package's."""
SEQUENCE = 200
"""Samples of the sequences that a swing is cut into for its system identification: a second."""
HORIZONS = (400, 800, 1600)
"""Samples that are followed from the swing's beginning, one after another, before all of them."""
START_WITHIN = np.array([0.05, 0.05, 2.0, 2.0])
"""How far the fitted initial state may be from where it begins [rad, rad/s]."""
FREE = ("m1", "l2", "J2", "c1", "c2")
"""What is fitted to a swing, which shows no more than five base parameters: the others are frozen."""
_POINT = 1e-12
"""Inertia of what is a point, which the engine does not take as 0 [kg m^2]."""


def can_identify() -> bool:
    """Return whether the installed MuJoCo has its system identification: from version 3.5 on, with `mujoco[sysid]`."""
    return sysid is not None


def description(values: Mapping[str, float]) -> str:
    """Return MuJoCo's description of the rig; both joints are at 0 upright, the outer one is relative to the inner."""
    v = values
    return f"""
    <mujoco>
      <compiler angle="radian" inertiafromgeom="false"/>
      <option timestep="{STEP}" integrator="RK4" gravity="0 0 {-v["g"]:.17g}"><flag contact="disable"/></option>
      <worldbody>
        <body name="inner">
          <joint name="inner_joint" type="hinge" axis="0 1 0" damping="{v["c1"]:.17g}"/>
          {_inertial(v["m1"], v["l1"], v["J1"])}
          <body name="joint_mass" pos="0 0 {v["L"]:.17g}">{_inertial(v["m0"], 0.0, _POINT)}</body>
          <body name="outer" pos="0 0 {v["L"]:.17g}">
            <joint name="outer_joint" type="hinge" axis="0 1 0" damping="{v["c2"]:.17g}"/>
            {_inertial(v["m2"], v["l2"], v["J2"])}
          </body>
        </body>
      </worldbody>
      <sensor>
        <jointpos name="inner_angle" joint="inner_joint"/><jointpos name="outer_angle" joint="outer_joint"/>
      </sensor>
    </mujoco>"""


def _inertial(mass: float, along: float, inertia: float) -> str:
    inertias = " ".join([f"{inertia:.17g}"] * 3)
    return f'<inertial pos="0 0 {along:.17g}" mass="{max(mass, _POINT):.17g}" diaginertia="{inertias}"/>'


def relative(state: Array) -> Array:
    """Return the joints' angles and rates (4,) of theta1, theta2, omega1, omega2 (4,)."""
    theta1, theta2, omega1, omega2 = state
    return np.array([theta1, theta2 - theta1, omega1, omega2 - omega1])


def models_of(sets: Sequence[Mapping[str, float]]) -> list[mujoco.MjModel]:
    """Return compiled models of so many rigs."""
    return [mujoco.MjModel.from_xml_string(description(values)) for values in sets]


def rollout(models: list[mujoco.MjModel], start: Array, steps: int) -> Array:
    """Return theta1, theta2 (models, steps + 1, 2) [rad] from one state (4,), on this thread."""
    first = np.concatenate([[0.0], relative(start)])
    states, _ = mujoco.rollout.rollout(
        models, mujoco.MjData(models[0]), np.tile(first, (len(models), 1)), nstep=steps, persistent_pool=False
    )
    joints = np.concatenate([np.tile(first[1:3], (len(models), 1, 1)), states[:, :, 1:3]], axis=1)
    return np.cumsum(joints, axis=2)


def identify(
    time: Array,
    theta: Array,
    start: Array,
    initial: Mapping[str, float],
    lower: Array,
    upper: Array,
    watch: Callable[[Array], None] = lambda chromosomes: None,
) -> Array:
    """Return the chromosome (9,) that `mujoco.sysid` finds over one sequence.

    Args:
        time: (n,) evenly spaced times from 0 on [s].
        theta: (n, 2) measured theta1, theta2 [rad].
        start: (4,) state at time 0, which `mujoco.sysid` takes as known.
        initial: values that it begins with.
        lower: (9,) limits of the chromosome.
        upper: (9,) limits of the chromosome.
        watch: called with all chromosomes (n, 9) that are simulated; what it raises ends the fit.
    """
    spec = mujoco.MjSpec.from_string(description(initial))
    residual = sysid.build_residual_fn(models_sequences=[_sequences(spec, [(time, theta, start)])], n_threads=1)

    def watched(x: Array, fitted: object) -> object:
        watch(np.atleast_2d(x.T))
        return residual(x, fitted)

    return _optimum(_parameters(initial, lower, upper), watched)


def identify_swing(
    time: Array, theta: Array, states: Array, initial: dict[str, float], lower: Array, upper: Array
) -> Array:
    """Return the chromosome (9,) that `mujoco.sysid` finds over a whole swing, its initial state fitted, too.

    First over short sequences from filtered states, as its manual has it, then by a rollout of one's own, which it
    provides for, over one sequence that grows to the whole swing: its initial state is a parameter more.

    Args:
        time: (n,) evenly spaced times from 0 on [s].
        theta: (n, 2) measured theta1, theta2 [rad].
        states: (n, 4) filtered states at these times.
        initial: values that it begins with.
        lower: (9,) limits of the chromosome.
        upper: (9,) limits of the chromosome.
    """
    spec = mujoco.MjSpec.from_string(description(initial))
    model = spec.compile()
    parts = [slice(begin, begin + SEQUENCE) for begin in range(0, len(time) - SEQUENCE // 2, SEQUENCE)]
    short = _sequences(spec, [(time[part] - time[part][0], theta[part], states[part][0]) for part in parts])
    found = _optimum(_parameters(initial, lower, upper, FREE), _residual(theta, short))
    start = states[0]

    def rollout_from(*, param_dicts: Sequence[Any], initial_states: object, **others: object) -> Any:
        return sysid.sysid_rollout(
            initial_states=[_full_state(model, parameters["start"].value) for parameters in param_dicts], **others
        )

    for horizon in (*(horizon for horizon in HORIZONS if horizon < len(time)), len(time)):
        parameters = _parameters(initial | dict(zip(FREE, found, strict=True)), lower, upper, FREE)
        parameters.add(
            sysid.Parameter(
                "start", start, start - START_WITHIN, start + START_WITHIN, modifier=lambda spec, parameter: None
            )
        )
        whole = _sequences(spec, [(time[:horizon], theta[:horizon], start)])
        optimum = _optimum(parameters, _residual(theta[:horizon], whole, custom_rollout=rollout_from))
        found, start = np.split(optimum, [len(FREE)])
    values = initial | dict(zip(FREE, found, strict=True))
    return np.array([values[symbol] for symbol in SYMBOLS])


def _parameters(initial: Mapping[str, float], lower: Array, upper: Array, free: Collection[str] = SYMBOLS) -> Any:
    """Return the chromosome's parameters, and how each changes the model; those that are not free are frozen."""

    def bodies_mass(name: str) -> Callable[..., None]:
        return lambda spec, parameter: setattr(spec.body(name), "mass", parameter.value[0])

    def centre(name: str) -> Callable[..., None]:
        return lambda spec, parameter: setattr(spec.body(name), "ipos", [0.0, 0.0, parameter.value[0]])

    def inertia(name: str) -> Callable[..., None]:
        return lambda spec, parameter: setattr(spec.body(name), "inertia", [parameter.value[0]] * 3)

    def damping(name: str) -> Callable[..., None]:
        return lambda spec, parameter: setattr(spec.joint(name), "damping", [parameter.value[0], 0.0, 0.0])

    modifiers = {
        "m1": bodies_mass("inner"), "m2": bodies_mass("outer"), "m0": bodies_mass("joint_mass"),
        "l1": centre("inner"), "l2": centre("outer"), "J1": inertia("inner"), "J2": inertia("outer"),
        "c1": damping("inner_joint"), "c2": damping("outer_joint"),
    }  # fmt: skip
    parameters = sysid.ParameterDict()
    for symbol, least, most in zip(SYMBOLS, lower, upper, strict=True):
        parameters.add(
            sysid.Parameter(
                symbol,
                nominal=initial[symbol],
                min_value=least,
                max_value=most,
                frozen=symbol not in free,
                modifier=modifiers[symbol],
            )
        )
    return parameters


def _sequences(spec: Any, parts: Sequence[tuple[Array, Array, Array]]) -> Any:
    """Return what was measured: times from 0 on (n,), angles (n, 2) and the state at time 0 (4,) of each sequence."""
    model = spec.compile()
    # The places of the joints: what its sensors show after a step is from before it. There must be as many sensors.
    measured = [(f"{joint}_qpos", sysid.SignalType.MjStateQPos) for joint in ("inner_joint", "outer_joint")]
    times, angles, starts = zip(*parts, strict=True)
    return sysid.ModelSequences(
        "cart_double_pendulum",
        spec,
        [f"free_swing_{count}" for count in range(len(parts))],
        [_full_state(model, start) for start in starts],
        [sysid.TimeSeries(time, np.zeros((len(time), 0))) for time in times],
        [
            sysid.TimeSeries.from_names(time, np.diff(theta, axis=1, prepend=0.0), model, measured)
            for time, theta in zip(times, angles, strict=True)
        ],
    )


def _residual(theta: Array, sequences: Any, **more: object) -> Any:
    """Return its residual, in which an error of either encoder weighs the same; by itself it is over the angle."""
    inner, outer = np.linalg.norm(np.diff(theta, axis=1, prepend=0.0), axis=0)
    weights = {"inner_angle": inner, "outer_angle": outer}
    return sysid.build_residual_fn(models_sequences=[sequences], sensor_weights=weights, n_threads=1, **more)


def _full_state(model: mujoco.MjModel, state: Array) -> Any:
    joints = relative(state)
    return sysid.create_initial_state(model, joints[:2], joints[2:], np.empty(0))


def _optimum(parameters: Any, residual: Any) -> Array:
    with contextlib.redirect_stdout(io.StringIO()):  # it prints each iteration, whatever one asks of it
        found, _ = sysid.optimize(initial_params=parameters, residual_fn=residual, optimizer="mujoco")
    return np.asarray(found.as_vector())

"""What a user of MuJoCo would take: the rig as its bodies and joints, its rollout, and its system identification."""

import contextlib
import io
from collections.abc import Callable, Mapping, Sequence

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
    """Return the chromosome (9,) that `mujoco.sysid` finds.

    Args:
        time: (n,) evenly spaced times from 0 on [s].
        theta: (n, 2) measured theta1, theta2 [rad].
        start: (4,) state at time 0, which `mujoco.sysid` takes as known.
        initial: values that it begins with.
        lower: (9,) limits of the chromosome.
        upper: (9,) limits of the chromosome.
        watch: called with all chromosomes (n, 9) that are simulated; what it raises ends the fit.
    """

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
                symbol, nominal=initial[symbol], min_value=least, max_value=most, modifier=modifiers[symbol]
            )
        )
    spec = mujoco.MjSpec.from_string(description(initial))
    model = spec.compile()
    first = relative(start)
    joints = np.diff(theta, axis=1, prepend=0.0)
    # The places of the joints: what its sensors show after a step is from before it. There must be as many sensors.
    measured = [(f"{joint}_qpos", sysid.SignalType.MjStateQPos) for joint in ("inner_joint", "outer_joint")]
    sequences = sysid.ModelSequences(
        "cart_double_pendulum",
        spec,
        "free_swing",
        sysid.create_initial_state(model, first[:2], first[2:], np.empty(0)),
        sysid.TimeSeries(time, np.zeros((len(time), 0))),
        sysid.TimeSeries.from_names(time, joints, model, measured),
    )
    residual = sysid.build_residual_fn(models_sequences=[sequences], n_threads=1)

    def watched(x: Array, fitted: object) -> object:
        watch(np.atleast_2d(x.T))
        return residual(x, fitted)

    with contextlib.redirect_stdout(io.StringIO()):  # it prints each iteration, whatever one asks of it
        found, _ = sysid.optimize(initial_params=parameters, residual_fn=watched, optimizer="mujoco")
    return np.asarray(found.as_vector())

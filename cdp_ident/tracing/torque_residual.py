"""The missing torque in each joint: that of the measured motion less that of a model (inverse dynamics)."""

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from cdp_ident.fit.refinement import Fit
from cdp_ident.fit.windows import Window
from cdp_ident.model.layout import RODS_STATES
from cdp_ident.model.motions import InitialValueProblem, accelerations_at, motions
from cdp_ident.trial.kinematics import HALF_WIDTH

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class TorqueResidual:
    """The missing torque in each joint along the measured motion; columns are the two `JOINTS`.

    Measured accelerations are those of local cubics, which smooth out changes within about 0.1 s.
    """

    trial: npt.NDArray[np.int64]
    """(n,) which trial a sample is of."""
    time: Array
    """(n,) its time in the trial [s]."""
    angle: Array
    """(n, 2) angle of each joint: the inner one from hanging, the outer one relative to the inner rod [rad]."""
    speed: Array
    """(n, 2) speed of each joint [rad/s]."""
    torque: Array
    """(n, 2) missing torque in each joint, over A22 of the rig without weights [rad/s^2]."""


def torque_residual(fit: Fit) -> TorqueResidual:
    """Return the torques that a fitted model lacks over its windows (inverse dynamics), while the rods move."""
    parts = []
    # Cubics at the ends are one-sided and inaccurate; at rest, friction has any size up to its limit.
    inside = [(w.time > HALF_WIDTH) & (w.time < w.time[-1] - HALF_WIDTH) for w in fit.windows]
    moving = [chosen & np.all(w.counts == 1.0, axis=1) for w, chosen in zip(fit.windows, inside, strict=True)]
    for window, middle in zip(fit.windows, moving if any(map(np.any, moving)) else inside, strict=True):
        weighted = fit.model.with_weights(fit.values, window.weights)
        coefficients = fit.model.coefficients(weighted.values)
        A23, A33 = coefficients[:2]
        measured, accelerations = window.local_motion
        states = measured[middle]
        times = window.begin + window.time[middle]
        u = window.cart_acceleration[middle]
        acting = fit.model.acting(weighted.values, window.trial, weighted.carried)
        if acting.states > RODS_STATES:
            # What effects bring into the state is not measured: it is that of the model's motion.
            start = fit.model.initial_state(window.start)
            problem = InitialValueProblem(coefficients, start, window.grid, window.u, acting, window.begin)
            motion = motions([problem], shown=False).states
            states = np.concatenate([states, motion[middle, RODS_STATES:]], axis=1)
        lacking = accelerations[middle] - accelerations_at(coefficients, np.ascontiguousarray(states), u, acting, times)
        coupling = A23 * np.cos(states[:, 0] - states[:, 1])
        on_inner = lacking[:, 0] + coupling * lacking[:, 1]
        on_outer = coupling * lacking[:, 0] + A33 * lacking[:, 1]
        parts.append(
            (
                np.full(len(times), window.trial),
                times,
                np.stack([states[:, 0] - np.pi, states[:, 1] - states[:, 0]], axis=1),
                np.stack([states[:, 2], states[:, 3] - states[:, 2]], axis=1),
                # The outer joint's torque acts on the outer rod and, reversed, on the inner one.
                weighted.share * np.stack([on_inner + on_outer, on_outer], axis=1),
            )
        )
    return TorqueResidual(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def corrected(fit: Fit) -> Fit:
    """Return a fit whose windows show the angles of the rods: the encoders' errors in its model are taken out."""
    rods, remain = fit.model.with_exact_encoders()

    def without_errors(window: Window) -> Window:
        both = ((fit.model, fit.values), (rods, fit.values[remain]))
        shown, actual = (model.predict(values, window.start, window, "none")[0] for model, values in both)
        return replace(window, theta=window.theta - (shown - actual))

    return replace(fit, windows=tuple(without_errors(window) for window in fit.windows))

"""Balance a fitted pendulum upright: an LQR designed on its linear model, tried on a simulated rig.

    python3 $(ros2 pkg prefix --share cdp_ident)/examples/lqr.py identification/one/fitted.yaml

The controller knows the linear model only. The rig that it balances is the fitted model in full, dry friction and all;
nothing real moves. What a real rig needs besides, docs/how_to/linear_model.md tells.
"""

import argparse
import sys
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy.linalg import solve_continuous_are

from cdp_ident.configuration.fitted_model import FittedModel, read_fitted_model
from cdp_ident.errors import CdpIdentError
from cdp_ident.model.equilibria import EQUILIBRIA
from cdp_ident.model.linear import LinearModel, linearize
from cdp_ident.model.motions import simulate

Array = npt.NDArray[np.float64]

PERIOD = 0.005
"""Time from one command to the next [s]."""
LARGEST = np.array([0.2, 0.1, 0.1, 1.0, 1.0, 1.0])
"""Deviations of x, theta1, theta2 and their rates that weigh alike (Bryson's rule) [m, rad, m/s, rad/s]."""
LARGEST_INPUT = 5.0
"""Acceleration of the cart that weighs as much [m/s^2]."""
STRONGEST = 20.0
"""What the cart can do [m/s^2]."""
FALLEN = 0.5
"""Farther from upright the linear model says nothing [rad]."""


def design(model: LinearModel) -> Array:
    """Return the gain K (1, 6) of u = -K x that minimises the integral of x' Q x + u' R u."""
    Q, R = np.diag(LARGEST**-2.0), np.array([[LARGEST_INPUT**-2.0]])
    P = solve_continuous_are(model.A, model.B, Q, R)
    return np.asarray(np.linalg.solve(R, model.B.T @ P))


def balance(fitted: FittedModel, model: LinearModel, gain: Array, lean: float, seconds: float) -> tuple[Array, Array]:
    """Let go of a simulated rig whose rods lean by `lean` [rad], and balance it for a time.

    Returns:
        The deviations (n, 6) at each command, and the cart's accelerations (n,) [m/s^2]; both end where it falls.
    """
    torques = fitted.motion.acting(fitted.values, fitted.trial())
    cart, rods = np.zeros(2), np.array([*(model.theta + lean), 0.0, 0.0])
    deviations, inputs = [], []
    for _ in range(round(seconds / PERIOD)):
        angles = rods[:2] - model.theta
        deviations.append(np.array([cart[0], *angles, cart[1], *rods[2:]]))
        if np.abs(angles).max() > FALLEN:
            inputs.append(0.0)
            break
        u = float(np.clip(-gain @ deviations[-1], -STRONGEST, STRONGEST)[0])
        inputs.append(u)
        rods = simulate(fitted.coefficients, rods, np.array([PERIOD]), np.full(3, u), PERIOD, torques)[0]
        cart += PERIOD * np.array([cart[1] + 0.5 * PERIOD * u, u])
    return np.array(deviations), np.array(inputs)


def main(arguments: list[str]) -> int:
    """Design, balance, and tell how it went; return 1 where the rods fell."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("fitted", type=Path, help="fitted.yaml of identify")
    parser.add_argument("--lean", type=float, default=5.0, help="of both rods at the start [degrees] (5)")
    parser.add_argument("--seconds", type=float, default=10.0, help="(10)")
    options = parser.parse_args(arguments)

    if options.seconds < PERIOD:
        parser.error(f"--seconds must be {PERIOD} or more")
    try:
        fitted = read_fitted_model(options.fitted, "lqr")
        torques = fitted.motion.acting(fitted.values, fitted.trial())
        model = linearize(fitted.coefficients, EQUILIBRIA["upright"], torques)
    except CdpIdentError as error:
        parser.error(str(error))
    gain = design(model)
    closed = np.linalg.eigvals(model.A - model.B @ gain)
    print(f"u = -K x with K = [{', '.join(f'{value:.4g}' for value in gain[0])}]")
    print(f"closed loop: eigenvalues {', '.join(f'{value:.3g}' for value in sorted(closed, key=abs))} 1/s")

    deviations, inputs = balance(fitted, model, gain, np.radians(options.lean), options.seconds)
    degrees = np.degrees(np.abs(deviations[:, 1:3]).max(axis=1))
    time = PERIOD * len(deviations)
    print(f"the cart moved {np.ptp(deviations[:, 0]):.3f} m, accelerated by at most {np.abs(inputs).max():.2f} m/s^2")
    if np.abs(deviations[-1, 1:3]).max() > FALLEN:
        print(f"fell after {time:.2f} s: try a smaller --lean")
        return 1
    last = degrees[-round(1.0 / PERIOD) :].max()
    print(f"balanced for {time:.1f} s: from {degrees[0]:.2g} degrees to within {last:.2g} in the last second")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

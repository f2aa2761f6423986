"""Balance a fitted pendulum upright: an LQR and a Kalman filter of its linear model, tried on a simulated rig.

    python3 $(ros2 pkg prefix --share cdp_ident)/examples/lqr.py identification/one/fitted.yaml

The controller knows the linear model only, and is shown counts of encoders. The rig that it balances is the fitted
model in full, dry friction and all, on a cart whose drive has a lag and limits. balance.py balances a real one with it.
"""

import argparse
import sys
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy.linalg import expm, solve_discrete_are

from cdp_ident.configuration.fitted_model import FittedModel, read_fitted_model
from cdp_ident.errors import CdpIdentError, OptionError
from cdp_ident.model.equilibria import EQUILIBRIA
from cdp_ident.model.linear import LinearModel, linearize
from cdp_ident.rig.emulator.device import Encoders
from cdp_ident.rig.emulator.drive import Drive, DrivenCart
from cdp_ident.rig.emulator.motion import Motion
from cdp_ident.rig.emulator.script import Hold, LetGo, Wait, WaitForCommand

Array = npt.NDArray[np.float64]

PERIOD = 0.005
"""Time from one sample to the next [s]."""
LARGEST = np.array([0.2, 0.1, 0.1, 1.0, 1.0, 1.0])
"""Deviations of x, theta1, theta2 and their rates that weigh alike (Bryson's rule) [m, rad, m/s, rad/s]."""
LARGEST_INPUT = 5.0
"""Acceleration of the cart that weighs as much [m/s^2]."""
UNKNOWN = np.array([0.5, 1.0, 3.0])
"""Accelerations of cart and rods that the linear model does not know, from sample to sample [m/s^2, rad/s^2]."""
NOISE = np.array([1e-5, 3e-4, 4e-4])
"""Of the measured x, theta1 and theta2: that of encoders with 8000 counts a turn [m, rad]."""
FALLEN = 0.5
"""Farther from upright the linear model says nothing [rad]."""


class Controller:
    """u = -K z, where z is the Kalman filter's estimate of the state at the sample from which on u will act.

    The state is that of the linear model, the cart's acceleration, which follows the command with the drive's lag, and
    the command itself, which acts from the next sample on.
    """

    def __init__(self, model: LinearModel, period: float = PERIOD, drive: Drive = Drive()) -> None:  # noqa: B008
        self.theta, self._largest = model.theta, drive.acceleration
        rates = np.zeros((8, 8))
        rates[:6, :6], rates[:6, 6:7] = model.A, model.B
        rates[6, 6:] = -1.0 / drive.lag, 1.0 / drive.lag
        self._F = expm(rates * period)
        self._F[7] = 0.0
        G, self._C = np.eye(8)[:, 7:], np.eye(3, 8)
        Q, R = np.diag([*LARGEST**-2.0, 0.0, 0.0]), np.array([[LARGEST_INPUT**-2.0]])
        P = solve_discrete_are(self._F, G, Q, R)
        self.gain = np.linalg.solve(R + G.T @ P @ G, G.T @ P @ self._F)
        """K (1, 8)."""
        self.closed = np.linalg.eigvals(self._F - G @ self.gain)
        W, V = np.diag([*np.zeros(3), *(UNKNOWN * period) ** 2, 0.0, 0.0]), np.diag(NOISE**2)
        S = solve_discrete_are(self._F.T, self._C.T, W, V)
        self._of_surprise = np.linalg.solve(self._C @ S @ self._C.T + V, self._C @ S).T
        self._z = np.zeros(8)

    def deviation(self, measured: Array) -> Array:
        """Return how far x, theta1 and theta2 (3,) are from upright, whatever turns the rods have made."""
        return np.array([measured[0], *((measured[1:] - self.theta + np.pi) % (2 * np.pi) - np.pi)])

    def begin(self, deviation: Array) -> None:
        """Begin anew, at rest."""
        self._z = np.array([*deviation, *np.zeros(5)])

    def command(self, deviation: Array, samples: int = 1) -> float:
        """Return the acceleration of the cart to command [m/s^2].

        Args:
            deviation: (3,) of x, theta1 and theta2, as measured.
            samples: number of the sample, from the one before: more than 1 where some were lost.
        """
        for _ in range(samples):
            command = self._z[7]
            self._z = self._F @ self._z
            self._z[7] = command
        self._z += self._of_surprise @ (deviation - self._C @ self._z)
        self._z[7] = np.clip(-self.gain @ self._z, -self._largest, self._largest)[0]
        return float(self._z[7])


def upright(fitted: FittedModel) -> LinearModel:
    """Return the linear model about upright. Raises `OptionError` where the cart cannot control it."""
    model = linearize(fitted.coefficients, EQUILIBRIA["upright"], fitted.motion.acting(fitted.values, fitted.trial()))
    if not model.controllable:
        raise OptionError("the cart cannot control this pendulum: at least one mode cannot be moved by it")
    return model


def balance(fitted: FittedModel, controller: Controller, lean: Array, seconds: float) -> tuple[Array, Array]:
    """Let go of a simulated rig whose rods lean by `lean` (2,) [rad] from upright, and balance it for a time.

    Returns:
        x, theta1 and theta2 as deviations from upright (n, 3) at each sample, and the commands (n,) [m/s^2]; both end
        where it falls.
    """
    encoders, cart = Encoders(), DrivenCart(Drive())
    turns = np.array([encoders.inner_counts_per_turn, encoders.outer_counts_per_turn])
    count = np.array([encoders.metres_per_count, *(2 * np.pi / turns)])
    script = (Hold(*(controller.theta + lean), within=0.5), WaitForCommand(), LetGo(), Wait(seconds))
    torques = fitted.motion.acting(fitted.values, fitted.trial())
    motion = Motion(fitted.coefficients, script, PERIOD, torques, cart)
    motion.advance(round(0.6 / PERIOD))
    deviations, commands = [], []
    for number in range(round(seconds / PERIOD)):
        x, theta1, theta2 = motion.advance(1)[0, :3]
        deviations.append(controller.deviation(np.array([x, theta1, theta2])))
        if np.abs(deviations[-1][1:]).max() > FALLEN:
            commands.append(0.0)
            break
        x, inner, outer = count * np.round(np.array([x, theta1, theta2 - theta1]) / count)
        seen = controller.deviation(np.array([x, inner, inner + outer]))
        if number == 0:
            controller.begin(seen)
        commands.append(controller.command(seen))
        cart.command(commands[-1])
    return np.array(deviations), np.array(commands)


def main(arguments: list[str]) -> int:
    """Design, balance, and tell how it went; return 1 where the rods fell."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("fitted", type=Path, help="fitted.yaml of identify")
    parser.add_argument(
        "--lean", type=float, nargs="+", default=[5.0], help="of both rods, or of each, at the start [degrees] (5)"
    )
    parser.add_argument("--seconds", type=float, default=10.0, help="(10)")
    options = parser.parse_args(arguments)

    if options.seconds < PERIOD:
        parser.error(f"--seconds must be {PERIOD} or more")
    if len(options.lean) > 2:
        parser.error("--lean takes one angle or two")
    try:
        fitted = read_fitted_model(options.fitted, "lqr")
        controller = Controller(upright(fitted))
    except CdpIdentError as error:
        parser.error(str(error))
    print(f"u = -K z with K = [{', '.join(f'{value:.4g}' for value in controller.gain[0])}]")
    modes = sorted(controller.closed, key=abs, reverse=True)[:6]
    rates = np.log(np.array(modes)) / PERIOD
    print(f"closed loop: eigenvalues {', '.join(f'{value:.3g}' for value in rates)} 1/s")

    lean = np.radians(np.broadcast_to(options.lean, 2))
    deviations, commands = balance(fitted, controller, lean, options.seconds)
    degrees = np.degrees(np.abs(deviations[:, 1:]).max(axis=1))
    time = PERIOD * len(deviations)
    print(f"the cart moved {np.ptp(deviations[:, 0]):.3f} m, commanded at most {np.abs(commands).max():.2f} m/s^2")
    if degrees[-1] > np.degrees(FALLEN):
        print(f"fell after {time:.2f} s: try a smaller --lean")
        return 1
    last = degrees[-round(1.0 / PERIOD) :].max()
    print(f"balanced for {time:.1f} s: from {degrees[0]:.2g} degrees to within {last:.2g} in the last second")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Balance a fitted pendulum upright: an LQR and a Kalman filter of its linear model, tried on a simulated rig.

    python3 $(ros2 pkg prefix --share cdp_ident)/examples/lqr.py identification/one/fitted.yaml

The controller knows the linear model only, and is shown counts of encoders. The rig that it balances is the fitted
model in full, dry friction and all, on a cart whose drive has a lag and limits. balance.py balances a real one with it,
and swing_up.py first swings it up.
"""

import argparse
import json
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy.linalg import expm, solve_discrete_are

from cdp_ident.configuration.fitted_model import FittedModel, read_fitted_model
from cdp_ident.errors import CdpIdentError, OptionError
from cdp_ident.model.equilibria import EQUILIBRIA
from cdp_ident.model.linear import LinearModel, linearize
from cdp_ident.model.motions import accelerations_at, readings_of
from cdp_ident.output_folder import write_files
from cdp_ident.rig.emulator.device import Encoders
from cdp_ident.rig.emulator.motion import Drive, DrivenCart, Hold, LetGo, Motion, Wait, WaitForCommand

Array = npt.NDArray[np.float64]

PERIOD = 0.005
"""Time from one sample to the next [s]."""
SCHEMA = "cdp_ident/schedule/1"
"""Of a controller's file."""
LARGEST = np.array([0.2, 0.1, 0.1, 1.0, 1.0, 1.0])
"""Deviations of x, theta1, theta2 and their rates that weigh alike (Bryson's rule) [m, rad, m/s, rad/s]."""
LARGEST_INPUT = 5.0
"""Acceleration of the cart that weighs as much [m/s^2]."""
UNKNOWN = np.array([0.5, 1.0, 3.0])
"""Accelerations of cart and rods that the linear model does not know, from sample to sample [m/s^2, rad/s^2]."""
NOISE = np.array([1e-5, 3e-4, 4e-4])
"""Of the measured x, theta1 and theta2: that of encoders with 8000 counts a turn [m, rad]."""
SWAY = 3.0
"""To the regulator, dry friction damps like a viscous one that is as large at this rate of a joint [rad/s]."""
SLOW = 0.2
"""Elsewhere it grows to its full size within this rate [rad/s]."""
JOINT_RATES = np.array([[1.0, 0.0], [-1.0, 1.0]])
"""From the rates of theta1 and theta2 to those of the joints."""
FALLEN = 0.5
"""Farther from upright the linear model says nothing [rad]."""


@dataclass(frozen=True)
class Schedule:
    """What a controller follows and how, at each sample; from the last one on it goes on as there.

    A state has m numbers: x, theta1, theta2, their rates, the cart's acceleration, and the commands that do not act
    yet, the next one first.
    """

    states: Array
    """(n, m) the motion to follow."""
    commands: Array
    """(n,) what is commanded along it: accelerations of the cart [m/s^2]."""
    transitions: Array
    """(n, m, m) from a deviation at the sample to that at the next one."""
    inputs: Array
    """(n, m) what a command adds to that."""
    gains: Array
    """(n, m) K: what is commanded beside the motion's own is -K times the deviation."""
    filters: Array
    """(n, m, 3) by how much a surprise in the measured x, theta1, theta2 moves the estimated deviation."""
    friction: Array
    """(n, m, 2) what dry friction of the inner and the outer joint adds to the deviation at the next sample, where they
    slip forwards."""


def write_schedule(path: Path, schedule: Schedule, period: float = PERIOD) -> None:
    """Write a schedule, and the time from one sample to the next [s], as JSON."""
    content = {"period": period} | {name: of.tolist() for name, of in vars(schedule).items()}
    write_files(path.parent, {path.name: json.dumps({SCHEMA: content})})


def read_schedule(path: Path, period: float) -> Schedule:
    """Read one that was written.

    Raises:
        OptionError: it is no schedule, or one for samples of another spacing [s].
    """
    try:
        content = json.loads(path.read_bytes())[SCHEMA]
        planned = float(content.pop("period"))
        schedule = Schedule(**{name: np.array(of, dtype=float) for name, of in content.items()})
    except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
        raise OptionError(f"{path} is no file of swing_up.py ({type(error).__name__}: {error})") from error
    if abs(planned - period) > 1e-9:
        raise OptionError(f"{path} is for samples every {planned:g} s, not every {period:g} s")
    return schedule


class Controller:
    """Commands -K z beside what a motion needs; z is a Kalman filter's estimate of the deviation from it."""

    def __init__(
        self,
        schedule: Schedule,
        largest: float = Drive.acceleration,
        rods: Callable[[Array], Array] = lambda measured: measured,
    ) -> None:
        """Follow a schedule with commands of `largest` at most [m/s^2]; `rods` takes errors off what is measured."""
        self._schedule, self._largest, self._rods = schedule, largest, rods
        self.begin()

    def begin(self, measured: Array | None = None) -> None:
        """Begin anew, at rest: where x, theta1, theta2 (3,) are measured, or where the motion begins."""
        self._number, self._last = 0, self._schedule.commands[0]
        self._z = np.zeros(self._schedule.states.shape[1])
        if measured is not None:
            self._z[:3] = self.deviation(measured)

    def deviation(self, measured: Array) -> Array:
        """Return how far x, theta1 and theta2 (3,) are from the motion, whatever turns the rods have made."""
        away = self._rods(measured) - self._schedule.states[self._number, :3]
        return np.array([away[0], *((away[1:] + np.pi) % (2 * np.pi) - np.pi)])

    def command(self, measured: Array, samples: int = 1) -> float:
        """Return the acceleration of the cart to command [m/s^2].

        Args:
            measured: (3,) x, theta1 and theta2.
            samples: number of the sample, from the one before: more than 1 where some were lost, 0 for the first one.
        """
        schedule = self._schedule
        for _ in range(samples):
            k = self._number
            slipping = schedule.friction[k] @ (self._slips(self._z) - self._slips(0.0 * self._z))
            self._z = schedule.transitions[k] @ self._z + schedule.inputs[k] * (self._last - schedule.commands[k])
            self._z += slipping
            self._number = min(k + 1, len(schedule.commands) - 1)
        k = self._number
        self._z += schedule.filters[k] @ (self.deviation(measured) - self._z[:3])
        wanted = schedule.commands[k] - schedule.gains[k] @ self._z
        self._last = float(np.clip(wanted, -self._largest, self._largest))
        return self._last

    def _slips(self, deviation: Array) -> Array:
        """Return which way both joints slip (2,), from -1 to 1."""
        rates = self._schedule.states[self._number, 4:6] + deviation[4:6]
        return np.tanh(JOINT_RATES @ rates / SLOW)


@dataclass(frozen=True)
class Design:
    """What a controller is designed for, beside the rig's model."""

    period: float = PERIOD
    """Time from one sample to the next [s]."""
    drive: Drive = field(default_factory=Drive)
    """Of the cart."""
    delay: int = 1
    """Samples from a measurement until the command that answers it acts."""
    friction: bool = True
    """Whether the controller is to know of dry friction."""

    def sampled(self, A: Array, B: Array) -> tuple[Array, Array]:
        """Return F (..., m, m) and G (..., m) from a sample to the next of linear models (..., 6, 6) and (..., 6, 1).

        The drive follows with its lag what was commanded `delay` samples before.
        """
        rates = np.zeros((*A.shape[:-2], 8, 8))
        rates[..., :6, :6], rates[..., :6, 6:7] = A, B
        rates[..., 6, 6:] = -1.0 / self.drive.lag, 1.0 / self.drive.lag
        F = np.zeros((*A.shape[:-2], 7 + self.delay, 8 + self.delay))
        F[..., :7, :8] = expm(rates * self.period)[..., :7, :]
        F[..., 7:, 8:] = np.eye(self.delay)  # commands that wait move up
        return F[..., :-1], F[..., -1]

    @property
    def weights(self) -> tuple[Array, float]:
        """Q (m, m) and R of the regulator."""
        return np.diag([*LARGEST**-2.0, *np.zeros(1 + self.delay)]), LARGEST_INPUT**-2.0

    @property
    def noises(self) -> tuple[Array, Array]:
        """The covariances W (m, m), from a sample to the next, and V (3, 3) of what is measured."""
        return np.diag([*np.zeros(3), *(UNKNOWN * self.period) ** 2, *np.zeros(1 + self.delay)]), np.diag(NOISE**2)

    def of_friction(self, dry: Array) -> Array:
        """Return what each joint's friction adds to a state (..., m, 2), given accelerations by it (..., 2, 2)."""
        added = np.zeros((*dry.shape[:-2], 7 + self.delay, 2))
        if self.friction:
            added[..., 1:3, :], added[..., 4:6, :] = 0.5 * self.period**2 * dry, self.period * dry
        return added


def gain(P: Array, F: Array, G: Array, R: float) -> Array:
    """Return K (m,), given what a deviation at the next sample costs: z' P z."""
    return G @ P @ F / (R + G @ P @ G)


def of_surprise(S: Array, V: Array) -> Array:
    """Return by how much a surprise moves the estimate (m, 3), given the covariance S (m, m) of what was expected."""
    return np.linalg.solve(S[:3, :3] + V, S[:3]).T


def upright_schedule(fitted: FittedModel, design: Design = Design()) -> tuple[Schedule, Array]:  # noqa: B008
    """Return how the rods are held upright, a schedule of one sample, and what a deviation costs: z' P z.

    Raises:
        OptionError: the cart cannot control it.
    """
    model = upright(fitted)
    dry = dry_friction(fitted, model.theta)
    damped = model.A.copy()
    if design.friction:
        damped[4:, 4:] += dry @ JOINT_RATES / SWAY
    (F, G), (Q, R) = design.sampled(damped, model.B), design.weights
    P = solve_discrete_are(F, G[:, None], Q, np.array([[R]]))
    K = gain(P, F, G, R)
    (F, G), (W, V) = design.sampled(model.A, model.B), design.noises
    S = solve_discrete_are(F.T, np.eye(len(K), 3), W, V)
    states = np.array([[0.0, *model.theta, *np.zeros(len(K) - 3)]])
    arrays = F, G, K, of_surprise(S, V), design.of_friction(dry)
    return Schedule(states, np.zeros(1), *(of[None] for of in arrays)), P


def upright(fitted: FittedModel) -> LinearModel:
    """Return the linear model about upright. Raises `OptionError` where the cart cannot control it."""
    model = linearize(fitted.coefficients, EQUILIBRIA["upright"], fitted.motion.acting(fitted.values, fitted.trial()))
    if not model.controllable:
        raise OptionError("the cart cannot control this pendulum: at least one mode cannot be moved by it")
    return model


def dry_friction(fitted: FittedModel, theta: Array) -> Array:
    """Return accelerations of theta1, theta2 (rows) by dry friction where either joint slips forwards [rad/s^2]."""
    rates = SWAY * np.linalg.solve(JOINT_RATES, np.array([[1.0, -1.0, 1.0], [1.0, 1.0, -1.0]])).T
    states, acting = np.hstack([np.tile(theta, (3, 1)), rates]), fitted.motion.acting(fitted.values, fitted.trial())
    both, smooth = (
        accelerations_at(fitted.coefficients, states, np.zeros(3), acting.only(wanted))
        for wanted in (lambda effect: not effect.states, lambda effect: not (effect.states or effect.dry))
    )
    forwards, inner_back, outer_back = both - smooth
    return 0.5 * np.column_stack([forwards - inner_back, forwards - outer_back])


def rods_shown(fitted: FittedModel) -> Callable[[Array], Array]:
    """Return a function from measured x, theta1, theta2 (3,) to these without the encoders' errors that were found."""
    errors = fitted.motion.acting(fitted.values, fitted.trial()).only(
        lambda effect: not (effect.moves or effect.states or effect.law.lateness)
    )

    def rods(measured: Array) -> Array:
        if not errors.effects:
            return measured
        still = np.array([[*measured[1:], *np.zeros(5)]])
        shown = readings_of(fitted.coefficients, still, np.zeros((2, 0)), 1.0, errors)[0]
        return np.array([measured[0], *(2.0 * measured[1:] - np.cumsum(shown))])

    return rods


def balance(fitted: FittedModel, controller: Controller, start: Array, seconds: float) -> tuple[Array, Array]:
    """Let go of a simulated rig whose rods are held at theta1, theta2 `start` (2,) [rad], and control it for a time.

    A command reaches the drive with the sample after the one that it answers, as in an emulated rig.

    Returns:
        x, theta1 and theta2 as deviations from the motion to follow (n, 3) at each sample, and the commands (n,)
        [m/s^2]; both end where it falls.
    """
    encoders, cart = Encoders(), DrivenCart(Drive())
    turns = np.array([encoders.inner_counts_per_turn, encoders.outer_counts_per_turn])
    count = np.array([encoders.metres_per_count, *(2 * np.pi / turns)])
    script = (Hold(*start, within=0.5), WaitForCommand(), LetGo(), Wait(seconds))
    torques = fitted.motion.acting(fitted.values, fitted.trial())
    motion = Motion(fitted.coefficients, script, PERIOD, torques, cart)
    motion.advance(round(0.6 / PERIOD))
    deviations, commands = list[Array](), list[float]()
    for number in range(round(seconds / PERIOD)):
        x, theta1, theta2 = motion.advance(1)[0, :3]
        if commands:
            cart.command(commands[-1])
        shown = count * np.round(np.array([x, theta1, theta2 - theta1]) / count)
        measured = np.array([shown[0], shown[1], shown[1] + shown[2]])
        if number == 0:
            controller.begin(measured)
        commands.append(controller.command(measured, min(number, 1)))
        deviations.append(controller.deviation(np.array([x, theta1, theta2])))
        if np.abs(deviations[-1][1:]).max() > FALLEN:
            break
    return np.array(deviations), np.array(commands)


def add_design_arguments(parser: argparse.ArgumentParser) -> None:
    """Add what of a rig a controller is designed with, or not."""
    parser.add_argument("fitted", type=Path, help="fitted.yaml of identify")
    parser.add_argument(
        "--delay", type=int, choices=range(11), default=1, metavar="SAMPLES",
        help="from a measurement until the command that answers it acts (1)",
    )  # fmt: skip
    parser.add_argument("--ignore-friction", action="store_true", help="design as if there were no dry friction")


def design_of(options: argparse.Namespace) -> Design:
    """Return what such arguments say."""
    return Design(delay=options.delay, friction=not options.ignore_friction)


def main(arguments: list[str]) -> int:
    """Design, balance, and tell how it went; return 1 where the rods fell."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_design_arguments(parser)
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
        schedule, _ = upright_schedule(fitted, design_of(options))
    except CdpIdentError as error:
        parser.error(str(error))
    F, G, K = schedule.transitions[0], schedule.inputs[0], schedule.gains[0]
    print(f"u = -K z with K = [{', '.join(f'{value:.4g}' for value in K)}]")
    modes = sorted(np.linalg.eigvals(F - np.outer(G, K)), key=abs, reverse=True)[:6]
    rates = np.log(np.array(modes)) / PERIOD
    print(f"closed loop: eigenvalues {', '.join(f'{value:.3g}' for value in rates)} 1/s")

    lean = np.radians(np.broadcast_to(options.lean, 2))
    deviations, commands = balance(fitted, Controller(schedule), schedule.states[0, 1:3] + lean, options.seconds)
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

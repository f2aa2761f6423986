# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Hidden truths: trials of pendulums with effects that nobody is told of, and the answer sheet.

All of it follows from the kind and the seed: parameters, starts, noise, and how strong the effects are. Strength is
drawn by what it does: how far the effect moves the angles away from any motion that the paper's model can imitate by
other parameters and other starts, over windows of 2.5 s, as a multiple of the noise.
"""

import functools
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.integrate import odeint
from scipy.interpolate import CubicHermiteSpline

from reference import hidden_effects as effects
from reference.hidden_effects import HiddenEffect, Motion, State, Values
from reference.pendulum import TABLE_2, TABLE_3, TABLE_5, accelerations
from reference.truths import Measured

Array = npt.NDArray[np.float64]

RATE = 200
WINDOW = 2.5
"""Length of the windows over which effects are measured [s]."""
FIT_TRIALS = 2
"""Of the three trials, the first two are to be fitted; the last one is held out."""
_LEAD = 0.05
"""The motion begins so long before the trial [s], for encoders that are late."""
_TOLERANCE = 1e-10
_FREE = ("l2", "J1", "J2", "c1", "c2")
"""Parameters that move the five numbers of the paper's model in every direction."""
_RELATIVE_STEP = 1e-4
_START_STEP = 1e-5

EQUIVALENT = (
    frozenset({("gravity_tilt", "base"), ("encoder_offset", "inner")}),
    frozenset({("quadratic_friction", "inner"), ("air_drag", "inner")}),
)
"""Effects that are one and the same motion."""
UNKNOWN_TO_THE_PACKAGE = ("partial_rub",)


@dataclass(frozen=True)
class Hidden:
    """An effect as it is in one truth."""

    effect: HiddenEffect
    strength: float
    """In the effect's unit."""
    visible: float
    """What the paper's model and the truth's other effects cannot imitate of it, over the noise: see `visibility`."""

    @property
    def identity(self) -> tuple[str, str]:
        """Name and joint."""
        return self.effect.name, self.effect.joint

    @property
    def right(self) -> frozenset[tuple[str, str]]:
        """Names and joints, each of which is a right answer."""
        return next((same for same in EQUIVALENT if self.identity in same), frozenset({self.identity}))

    @property
    def known(self) -> bool:
        """Whether the package's catalogue has it."""
        return self.effect.name not in UNKNOWN_TO_THE_PACKAGE


@dataclass(frozen=True)
class Answer:
    """What is to be found out."""

    values: Values
    hidden: tuple[Hidden, ...]
    noise: Array
    """(2,) standard deviation of what the encoders add to theta1 and theta2, their steps included [rad]."""

    @property
    def floor(self) -> float:
        """Root mean square of the noise of both angles [rad]."""
        return float(np.sqrt(np.mean(self.noise**2)))


def motion(values: Values, hidden: Sequence[tuple[HiddenEffect, float]], start: Array, times: Array) -> Array:
    """Return the states (n, 4) at times (n,), beginning with the start (4,) at the first of them.

    Args:
        values: the physical values of all symbols.
        hidden: the effects that act, with their strengths.
        start: theta1, theta2 [rad], omega1, omega2 [rad/s] at times[0].
        times: (n,) time in the trial [s].
    """
    torques = [(effect.torque, strength) for effect, strength in hidden if effect.torque is not None and strength]
    compliance = next((strength for effect, strength in hidden if effect.compliant), 0.0)

    def derivative(time: float, state: State) -> tuple[float, ...]:
        torque1, torque2 = 0.0, 0.0
        for torque, strength in torques:
            more1, more2 = torque(time, state, values, strength)
            torque1, torque2 = torque1 + more1, torque2 + more2
        if not compliance:
            return state[2], state[3], *accelerations(values, state, 0.0, (torque1, torque2))  # type: ignore[arg-type]
        u = effects.cart_acceleration(values, state, (torque1, torque2), compliance)
        rods = accelerations(values, np.array(state[:4]), u, (torque1, torque2))
        return state[2], state[3], *rods, state[5], u

    begin = np.concatenate([start, np.zeros(2)]) if compliance else start
    states, report = odeint(
        lambda time, state: derivative(time, tuple(state.tolist())),
        begin, times, tfirst=True, rtol=_TOLERANCE, atol=_TOLERANCE, hmax=0.02, mxstep=20000, full_output=True,
    )  # fmt: skip
    if report["message"] != "Integration successful.":
        raise ArithmeticError(report["message"])
    return np.asarray(states[:, :4])


def encoders(values: Values, hidden: Sequence[tuple[HiddenEffect, float]], start: Array, times: Array) -> Array:
    """Return what the encoders show (n, 2) without noise, inner and outer [rad], from a start `_LEAD` before."""
    lead = round(_LEAD * RATE)
    whole = np.concatenate([times[0] + np.arange(-lead, 0) / RATE, times, times[-1:] + np.arange(1, lead) / RATE])
    states = motion(values, hidden, start, whole)

    @functools.lru_cache(maxsize=1)
    def spline() -> tuple[Callable[[Array], Array], Callable[[Array], Array]]:
        angles = CubicHermiteSpline(whole, states[:, :2], states[:, 2:])
        return angles, angles.derivative()

    def at(moments: Array) -> Array:
        if moments is times:
            return states[lead : lead + len(times)]
        angles, rates = spline()
        return np.concatenate([angles(moments), rates(moments)], axis=1)

    follow: Motion = at
    theta = at(times)[:, :2]
    shown = np.stack([theta[:, 0], theta[:, 1] - theta[:, 0]], axis=1)
    for effect, strength in hidden:
        if effect.reading is not None:
            shown = shown + effect.reading(times, follow, values, strength)
    return shown


def _one_trial(hidden: Sequence[tuple[HiddenEffect, float]], trial: int) -> list[tuple[HiddenEffect, float]]:
    return [(effect, strength) for effect, strength in hidden if effect.trial in (None, trial)]


def _angles(shown: Array) -> Array:
    """Return theta1, theta2 from the encoders' angles."""
    return np.cumsum(shown, axis=1)


def visibility(values: Values, candidates: Sequence[HiddenEffect], starts: Array, times: Sequence[Array]) -> Array:
    """Return by how much each effect moves the angles beyond imitation, for a unit of its strength [rad].

    Imitation is by the paper's parameters, by the start of each window, and by the other candidates. It is the root
    mean square in the middle one of the windows, for some are so chaotic that anything moves them; of what happens
    once, in the window where it is most.
    """
    rows: list[Array] = []
    owners: list[int] = []
    for trial, (start, moments) in enumerate(zip(starts, times, strict=True)):
        lead = round(_LEAD * RATE)
        path = motion(values, [], start, np.concatenate([moments[0] + np.arange(-lead, 0) / RATE, moments]))
        size = round(WINDOW * RATE)
        for first in range(0, len(moments) - size + 1, size):
            window, begin = moments[first : first + size], path[first]
            plain = _angles(encoders(values, [], begin, window)).ravel()

            def moved(
                effect: HiddenEffect, window: Array = window, begin: Array = begin, plain: Array = plain
            ) -> Array:
                there = _angles(encoders(values, [(effect, effect.small)], begin, window)).ravel()
                return (there - plain) / effect.small

            columns = [
                (_angles(encoders(values, [], begin + step, window)).ravel() - plain) / _START_STEP
                for step in _START_STEP * np.eye(4)
            ]
            basis, _ = np.linalg.qr(np.stack(columns, axis=1))
            free = []
            for symbol in _FREE:
                other = {**values, symbol: values[symbol] * (1.0 + _RELATIVE_STEP)}
                free.append((_angles(encoders(other, [], begin, window)).ravel() - plain) / _RELATIVE_STEP)
            for effect in candidates:
                free.append(moved(effect) if effect.trial in (None, trial) else np.zeros(len(plain)))
            block = np.stack(free, axis=1)
            rows.append(block - basis @ (basis.T @ block))
            owners += [len(rows) - 1] * len(block)
    table, owner = np.concatenate(rows), np.array(owners)
    result = []
    for k, effect in enumerate(candidates):
        column = table[:, len(_FREE) + k]
        others = np.delete(table, len(_FREE) + k, axis=1)
        scale = np.maximum(np.linalg.norm(others, axis=0), 1e-300)
        left = column - (others / scale) @ np.linalg.lstsq(others / scale, column, rcond=1e-10)[0]
        powers = np.bincount(owner, left**2) / np.bincount(owner)
        result.append(np.sqrt(np.median(powers) if effect.trial is None else powers.max()))
    return np.array(result)


def _effect(part: str, rng: np.random.Generator, durations: Sequence[float]) -> HiddenEffect:
    name, joint = part.split(".")
    trial = int(rng.integers(FIT_TRIALS))
    at = durations[trial] * rng.uniform(0.3, 0.7)
    makers: dict[str, Callable[[], HiddenEffect]] = {
        "coulomb_friction": lambda: effects.dry(joint),
        "stribeck_friction": lambda: effects.stribeck(joint, rng),
        "quadratic_friction": lambda: effects.quadratic(joint),
        "load_friction": lambda: effects.load_friction(joint),
        "air_drag": lambda: effects.drag(joint, rng),
        "joint_spring": lambda: effects.spring(joint, rng),
        "gravity_tilt": effects.tilt,
        "cogging_torque": lambda: effects.cogging(joint, rng),
        "impulse": lambda: effects.knock(joint, trial, at),
        "encoder_offset": lambda: effects.offset(joint),
        "encoder_scale": lambda: effects.scale(joint),
        "encoder_eccentricity": lambda: effects.eccentricity(joint, rng),
        "encoder_slip": lambda: effects.slip(joint, trial, at),
        "time_offset": effects.late,
        "partial_rub": lambda: effects.rub(joint, rng),
        "magnet": lambda: effects.magnet(joint, rng),
        "rod_flex": effects.flex,
        "pivot_compliance": effects.compliance,
        "backlash": lambda: effects.backlash(joint),
    }
    return makers[name]()


_SIGNED = ("gravity_tilt", "impulse", "encoder_offset", "encoder_scale", "encoder_slip", "time_offset")
_BOTH = (
    "coulomb_friction",
    "stribeck_friction",
    "quadratic_friction",
    "load_friction",
    "air_drag",
    "joint_spring",
    "cogging_torque",
    "impulse",
    "encoder_offset",
    "encoder_scale",
    "encoder_eccentricity",
    "encoder_slip",
    "backlash",
)
SINGLE = (*(f"{name}.{joint}" for name in _BOTH for joint in ("inner", "outer")), "gravity_tilt.base",
          "pivot_compliance.base", "time_offset.outer", "rod_flex.inner")  # fmt: skip
PAIRS = (
    "coulomb_friction.outer+air_drag.outer",
    "coulomb_friction.inner+coulomb_friction.outer",
    "coulomb_friction.inner+encoder_offset.outer",
    "encoder_offset.inner+encoder_offset.outer",
    "air_drag.outer+time_offset.outer",
    "coulomb_friction.inner+air_drag.outer",
    "gravity_tilt.base+coulomb_friction.inner",
    "joint_spring.inner+coulomb_friction.outer",
)
UNKNOWN = ("partial_rub.inner", "partial_rub.outer", "magnet.inner", "magnet.outer")
KINDS = ("none", *SINGLE, *PAIRS, *UNKNOWN)
"""All kinds of truth: none, each effect alone, common pairs, and effects that the package's catalogue lacks."""


def _pendulum(rng: np.random.Generator) -> dict[str, float]:
    values = dict(TABLE_5 if rng.random() < 0.5 else TABLE_2)
    for symbol in ("m1", "m2", "m0", "J1", "J2", "c1", "c2"):
        values[symbol] *= rng.uniform(0.7, 1.3)
    for symbol in ("l1", "l2"):
        values[symbol] *= rng.uniform(0.85, 1.15)
    return values


def _start(rng: np.random.Generator) -> Array:
    """Return a start (4,): let go at rest far from hanging, or on its way as the paper's was."""
    if rng.random() < 0.7:
        sides = rng.choice([-1.0, 1.0], 2)
        return np.array([*(np.pi + sides * rng.uniform(0.6, 2.5, 2)), 0.0, 0.0])
    return np.array(TABLE_3) * rng.uniform(0.8, 1.2, 4)


def hidden_truth(kind: str, seed: int, visible: float | None = None) -> tuple[list[Measured], Answer]:
    """Return three trials of a pendulum, the last one to be held out, and the answer sheet.

    Args:
        kind: one of `KINDS`.
        seed: of everything that is random.
        visible: how visible the effects are, over the noise (see `Hidden.visible`); random where not given.
    """
    rng = np.random.default_rng([seed, zlib.crc32(kind.encode())])
    values = _pendulum(rng)
    starts = np.array([_start(rng) for _ in range(FIT_TRIALS + 1)])
    times = [np.arange(round(rng.uniform(10.0, 15.0) * RATE)) / RATE for _ in starts]
    noise = float(np.exp(rng.uniform(np.log(0.2e-3), np.log(2e-3))))
    step = 2.0 * np.pi / int(rng.choice([8000, 20000]))
    parts = [] if kind == "none" else kind.split("+")
    present = [_effect(part, rng, [moments[-1] for moments in times]) for part in parts]

    each = np.sqrt(noise**2 + step**2 / 12.0)
    sheet_noise = each * np.sqrt([1.0, 2.0])
    floor = float(np.sqrt(np.mean(sheet_noise**2)))
    hidden = []
    if present:
        unit = visibility(values, present, starts[:FIT_TRIALS], times[:FIT_TRIALS])
        for effect, moved in zip(present, unit, strict=True):
            wanted = float(np.exp(rng.uniform(np.log(0.5), np.log(10.0))))
            strength = min((wanted if visible is None else visible) * floor / moved, effect.largest)
            direction = rng.choice([-1.0, 1.0]) if effect.name in _SIGNED else 1.0
            hidden.append(Hidden(effect, float(direction * strength), float(strength * moved / floor)))

    trials = []
    for index, (start, moments) in enumerate(zip(starts, times, strict=True)):
        acting = _one_trial([(h.effect, h.strength) for h in hidden], index)
        shown = encoders(values, acting, start, moments)
        counted = np.round((shown + rng.normal(scale=noise, size=shown.shape)) / step) * step
        trials.append(Measured(f"{kind} {seed}.{index}", moments, _angles(counted)))
    return trials, Answer(values, tuple(hidden), sheet_noise)

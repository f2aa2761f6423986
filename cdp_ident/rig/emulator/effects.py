"""Effects of the catalogue in an emulated rig: what its file says of them, and what its encoders make of the motion."""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from cdp_ident.errors import OptionError
from cdp_ident.model.effects.bending import bends, turned_along
from cdp_ident.model.effects.constants import GRAVITY, LENGTH, effect_constants
from cdp_ident.model.effects.effect import JOINTS, Effect, SensorEffect, TorqueEffect
from cdp_ident.model.effects.naming import effect_of
from cdp_ident.model.effects.play import Turned
from cdp_ident.model.effects.readings import added_by, of_joint
from cdp_ident.model.parameters import SYMBOLS, inertia_about_cart, physical_coefficients
from cdp_ident.model.runge_kutta import hermite
from cdp_ident.model.torques import NO_TORQUES, Torques
from cdp_ident.user_input import quoted

Array = npt.NDArray[np.float64]

_LATEST = 0.1
"""So much of the past is kept for an encoder that is late [s]."""


@dataclass(frozen=True)
class Effects:
    """The effects that an emulated rig has beside the paper's model."""

    torques: Torques = NO_TORQUES
    sensors: tuple[tuple[SensorEffect, Array], ...] = ()


NO_EFFECTS = Effects()


def parse_effects(content: Any, physical: Mapping[str, float], outer_length: float, where: str) -> Effects:
    """Return the effects of a rig's file: `{coulomb_friction: {inner: {torque: 0.002}}, …}`, in physical units.

    Names are those of `CATALOGUE`; of several forms of an effect the first is meant, unless `variant` (or, for
    `cogging_torque`, `periods`) says otherwise. What a joint has more than once, such as harmonics, is a list.
    `physical` are the rig's parameters, with any weights on its rods, and
    `outer_length` is what air drag acts along [m]. Times count from the emulator's start. Raises `OptionError` for what
    is unknown or out of its range.
    """
    if content == {}:
        return NO_EFFECTS
    A22 = float(inertia_about_cart(np.array([physical[symbol] for symbol in SYMBOLS]), physical["L"]))
    chosen = [
        _possible_now(*effect_of(name, joint, one, A22, where), f"{where}: {name}: {joint}")
        for name, joints in _mapping(content, where).items()
        for joint, given in _mapping(joints, f"{where}: {name}").items()
        for one in (given if isinstance(given, list) else [given])
    ]
    constants = effect_constants(physical_coefficients(physical), physical["L"], outer_length)
    torques = [(effect, values) for effect, values in chosen if isinstance(effect, TorqueEffect)]
    sensors = [(effect, np.array(values)) for effect, values in chosen if isinstance(effect, SensorEffect)]
    return Effects(Torques.of(torques, constants), tuple(sensors))


def _possible_now(effect: Effect, values: list[float], where: str) -> tuple[Effect, list[float]]:
    """Refuse an encoder that is early: what it would show has not happened yet."""
    if isinstance(effect, SensorEffect) and effect.delays and values[0] < 0.0:
        raise OptionError(
            f"{where}: {effect.parameters[0].name} is {values[0]:g}; an emulated encoder can only be late"
        )
    return effect, values


def _mapping(content: Any, where: str) -> dict[str, Any]:
    if not isinstance(content, dict):
        raise OptionError(f"{where}: expected keys with values, found {quoted(content)}")
    return content


class Readings:
    """What the encoders of the joints show of the motion, sample by sample."""

    def __init__(self, effects: Effects, period: float) -> None:
        self._sensors = effects.sensors
        self._length, self._gravity = effects.torques.constants[[LENGTH, GRAVITY]]
        self._period = period
        self._now = 0
        self._past: deque[Array] = deque(maxlen=max(2, round(_LATEST / period)))
        self._turned = Turned()

    def of(self, states: Array) -> Array:
        """Return the inner and outer encoder's angles (n, 2) [rad] of a motion's next samples (n, 7), but the cart."""
        for effect, values in self._sensors:
            if effect.bends:
                bend = bends(states, states[:, 4:6], states[:, 6], self._length, self._gravity) @ values
                states = states.copy()
                turned_along(states, bend)
        time = np.asarray((self._now + 1 + np.arange(len(states))) * self._period, dtype=np.float64)
        angles = [of_joint(states, joint) for joint in range(2)]
        for effect, values in self._sensors:
            if effect.delays:
                joint = JOINTS.index(effect.joint)
                angles[joint] = self._late(states, time, float(values[0]), joint)
        for effect, values in self._sensors:
            if effect.has_play:
                joint = JOINTS.index(effect.joint)
                middle = float(angles[joint][0])
                angles[joint] = self._turned.follow(joint, time, angles[joint], float(values[0]), middle).angle
        for effect, values in self._sensors:
            joint = JOINTS.index(effect.joint)
            angles[joint] = angles[joint] + added_by(effect, values, angles[joint], time)
        self._past.extend(states)
        self._now += len(states)
        return np.stack(angles, axis=1)

    def _late(self, states: Array, time: Array, delay: float, joint: int) -> Array:
        """Return a joint's angle as it was before each sample."""
        past = np.array([*self._past, *states]) if self._past else states
        begin = len(past) - len(states)
        stamps = time[0] + (np.arange(len(past)) - begin) * self._period
        if len(past) < 2:
            return of_joint(states, joint)
        at = np.maximum(time - delay, stamps[0])
        return _between(stamps, of_joint(past, joint), of_joint(past[:, 2:], joint), at)


def _between(stamps: Array, angle: Array, speed: Array, at: Array) -> Array:
    """Return an angle [rad] at times between stamps (n,) [s], at which it and its speed (n,) [rad/s] are known.

    It is Hermite's cubic. To load scipy's takes a third of the time that an emulator takes to start.
    """
    before = np.clip(np.searchsorted(stamps, at, side="right") - 1, 0, len(stamps) - 2)
    step = stamps[before + 1] - stamps[before]
    old, new, first, last = hermite((at - stamps[before]) / step, step)
    return np.asarray(old * angle[before] + new * angle[before + 1] + first * speed[before] + last * speed[before + 1])

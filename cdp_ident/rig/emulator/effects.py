# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Effects of the catalogue in an emulated rig: what its file says of them, and what its encoders make of the motion."""

import math
from collections import deque
from typing import Any

import numpy as np
import numpy.typing as npt

from cdp_ident.errors import OptionError
from cdp_ident.model.acting import NO_EFFECTS, ActingEffects
from cdp_ident.model.effects.catalogue import effect_of
from cdp_ident.model.effects.effect import JOINTS, Effect
from cdp_ident.model.motions import readings_of
from cdp_ident.model.time_grid import between
from cdp_ident.rig.emulator.fields import mapping

Array = npt.NDArray[np.float64]

_LONGEST_STEP = 1e-4
"""States of encoders' own go on by steps of this at most [s], as fast as filters and elastic couplings may be."""
_AT_REST = np.array([1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
"""What the rods have of a motion, before which they were at rest."""
_LATEST = 0.1
"""So much of the past is kept for an encoder that is late [s]."""


def parse_effects(content: Any, inertia: float, outer_length: float, where: str) -> ActingEffects:
    """Return the effects of a rig's file: `{coulomb_friction: {inner: {torque: 0.002}}, …}`, in physical units.

    Names are those of the catalogue, or of own effects; of several forms of an effect the first is meant, unless
    `variant` (or, for `cogging_torque`, `periods`) says otherwise. What a joint has more than once, such as harmonics,
    is a list. `inertia` is A22, that of any weights included [kg m^2], and `outer_length` is what air drag acts along
    [m]. Times count from the emulator's start. Raises `OptionError` for what is unknown or out of its range.
    """
    if content == {}:
        return NO_EFFECTS
    chosen = [
        _possible_now(*effect_of(name, joint, one, inertia, where), f"{where}: {name}: {joint}")
        for name, joints in mapping(content, where).items()
        for joint, given in mapping(joints, f"{where}: {name}").items()
        for one in (given if isinstance(given, list) else [given])
    ]
    return ActingEffects.of(chosen, outer_length)


def _possible_now(effect: Effect, values: list[float], where: str) -> tuple[Effect, list[float]]:
    """Refuse an encoder that is early: what it would show has not happened yet."""
    if effect.law.lateness and values[0] < 0.0:
        raise OptionError(
            f"{where}: {effect.parameters[0].name} is {values[0]:g}; an emulated encoder can only be late"
        )
    return effect, values


class Readings:
    """What the encoders of the joints show of the motion, sample by sample."""

    def __init__(self, coefficients: Array, effects: ActingEffects, period: float) -> None:
        self._coefficients, self._period, self._now = coefficients, period, 0
        self._late_by = dict.fromkeys(JOINTS, 0.0)
        for effect, values in effects.each():
            if effect.law.lateness:
                self._late_by[effect.joint] += values[0]
        self._encoders = effects.only(lambda effect: not effect.moves and not effect.law.lateness)
        self._own = np.zeros((2, self._encoders.states - 4))
        self._past: deque[Array] = deque(maxlen=max(2, round(_LATEST / period)))

    def of(self, states: Array) -> Array:
        """Return the inner and outer encoder's angles (n, 2) [rad] of a motion's next samples (n, 7), but the cart."""
        parts = math.ceil(self._period / _LONGEST_STEP) if self._own.size else 1
        since = np.array([self._past[-1] if self._past else states[0] * _AT_REST, *states])
        at = np.arange(1, parts * len(states) + 1) / parts
        between = np.column_stack([np.interp(at, np.arange(len(since)), column) for column in since.T])
        step = self._period / parts
        begin = self._now * self._period + step
        shown = readings_of(self._coefficients, between, self._own, step, self._encoders, begin)[parts - 1 :: parts]
        for joint, delay in enumerate(self._late_by.values()):
            if delay:
                shown[:, joint] += self._late(states, delay, joint) - of_joint(states, joint)
        self._past.extend(states)
        self._now += len(states)
        return shown

    def _late(self, states: Array, delay: float, joint: int) -> Array:
        """Return a joint's angle as it was before each sample."""
        past = np.array([*self._past, *states]) if self._past else states
        stamps = np.asarray((np.arange(len(past)) - (len(past) - len(states))) * self._period, dtype=np.float64)
        time: Array = np.asarray(np.arange(len(states)) * self._period, dtype=np.float64)
        if len(past) < 2:
            return of_joint(states, joint)
        at = np.maximum(time - delay, stamps[0])
        return between(stamps, of_joint(past, joint), of_joint(past[:, 2:], joint), at)


def of_joint(values: Array, joint: int) -> Array:
    """Return what a joint has, which turns by theta1 or theta2 - theta1, of values (n, 2 or more) of both rods."""
    return values[:, 0] if joint == 0 else values[:, 1] - values[:, 0]

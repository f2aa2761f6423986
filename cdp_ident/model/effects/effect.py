# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The description of an effect, from which it is searched, fitted, reported, simulated and served."""

import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from typing import Any, Literal

from cdp_ident.model.formulas.language import ACCELERATIONS
from cdp_ident.model.formulas.syntax import names_used

Joint = Literal["inner", "outer", "base"]
JOINTS: tuple[Joint, Joint] = ("inner", "outer")
"""The joints between bodies, in the order of the angles."""
HARMONIC = "sine*sin(periods*angle) + cosine*cos(periods*angle)"
"""What repeats so many times a turn of a joint, with parameters in this order."""
UNITS = {"kg": 1, "N": 1, "J": 1, "W": 1, "Pa": 1, "m": 0, "s": 0, "rad": 0, "Hz": 0, "1": 0}
"""Units of parameters, and how often each has a mass."""
_UNIT = re.compile(r"([A-Za-z]+|1)(?:\^(-?\d))?")


@cache
def mass_in(unit: str) -> int:
    """Return how often a unit has a mass. Raises `ValueError` where it is none, as N m s/rad or m^2 are."""
    total = 0
    for sign, part in zip((1, *([-1] * unit.count("/"))), unit.split("/"), strict=True):
        for factor in part.replace("*", " ").strip("() ").split():
            found = _UNIT.fullmatch(factor)
            if not found or found[1] not in UNITS:
                raise ValueError(f"{factor} is no unit")
            total += sign * UNITS[found[1]] * int(found[2] or 1)
    return total


@dataclass(frozen=True)
class EffectParameter:
    """A parameter of an effect."""

    name: str
    unit: str
    """Unit of its physical value."""
    lower: float
    """Lowest physically possible value, in the unit of the fit."""
    upper: float
    """Highest plausible value, in the unit of the fit."""
    typical: float
    """Initial value of a fit, where the effect is present."""
    width: float = 0.0
    """Standard deviation of its value beforehand, in the unit of the fit; by default a hundred times the typical
    value, of a shape parameter twice that."""
    power: int | None = None
    """The physical value is the fit's times A22 to this power; by default that of the mass in the unit."""
    begins: tuple[str, ...] = ()
    """Formulas of values to begin fits with, where the effect takes the place of one that it contains: of that one's
    parameters and the coefficients. An effect that contains none is looked for at each of these."""
    shape: bool = False
    """Whether it is a shape parameter: without meaning unless another parameter of the effect differs from zero."""
    optional: bool = False
    """Whether it may be left out in a file: it then has its typical value."""
    includes_weights: bool = False
    """Whether it is a mass that a joint carries, to which weights clamped beyond the joint add."""
    resolves: Literal["", "speed", "angle"] = ""
    """Whether it is a joint's speed or angle within which the law changes much: the integrator's steps resolve it."""

    @property
    def inertia_power(self) -> int:
        """The physical value is the fit's times A22 to this power: 1 for torques, which the model has over A22."""
        return mass_in(self.unit) if self.power is None else self.power

    @property
    def fixed(self) -> bool:
        """Whether it is a part of the effect's definition and not fitted."""
        return self.lower == self.upper

    @property
    def prior_width(self) -> float:
        """Standard deviation of its value before any trial is looked at: of a strength, as its limits let it be."""
        uniform = (self.upper - self.lower) / math.sqrt(12.0)
        return self.width or (2.0 * abs(self.typical) if self.shape else min(100.0 * abs(self.typical), uniform))

    def scale(self, inertia: float) -> float:
        """Return its physical value over its value in the fit, for the inertia A22 about the cart's joint [kg m^2]."""
        return inertia**self.inertia_power


@dataclass(frozen=True)
class State:
    """A number that an effect adds to the state of the rods; its rate is a part of the law."""

    name: str
    rate: str
    """Formula of its rate of change."""
    limit: float = math.inf
    """It stays where its size has reached this, until its rate leads back."""
    start_std: float = math.inf
    """Its standard deviation where a window begins, beforehand."""
    at_zero: str = ""
    """Formula of what it is where the effect has no strength, if that is known; its rate then does not matter."""


@dataclass(frozen=True)
class Curve:
    """A smooth curve whose coefficients are an effect's parameters."""

    over: Literal["angle", "speed"]
    """What it is a function of: the joint's angle (then it is periodic) or speed."""
    count: int
    """Number of its coefficients."""
    law: Callable[..., Any] | None = field(default=None, compare=False)
    """What computes it; see `curves`."""


@dataclass(frozen=True)
class Law:
    """What an effect adds to the equations of motion, or to what encoders show: formulas in the words of `language`."""

    torque: str = ""
    """Torque in the effect's joint on the body beyond it, and against it on the one before, over A22."""
    torques: tuple[str, str] = ("", "")
    """Generalised torques on theta1 and theta2, over A22. They may be linear in the accelerations, as inertias are."""
    friction: str = ""
    """Size of the dry friction in the joint, over A22: it acts against the motion, and at rest up to that."""
    cart: str = ""
    """Acceleration of the cart's joint [m/s^2], linear in the accelerations."""
    reading: str = ""
    """What the encoder of the joint shows beside the joint's angle [rad]."""
    readings: tuple[str, str] = ("", "")
    """What both encoders show beside their joints' angles [rad]."""
    lateness: str = ""
    """How late the encoder of the joint is read [s]; a formula of parameters alone."""
    where: tuple[tuple[str, str], ...] = ()
    """Names for parts of the formulas, with what they stand for."""
    states: tuple[State, ...] = ()

    @cached_property
    def formulas(self) -> dict[str, str]:
        """Formulas of what it adds, by what that is."""
        named = {
            "torque": self.torque, "torque on theta1": self.torques[0], "torque on theta2": self.torques[1],
            "friction": self.friction, "acceleration of the cart's joint": self.cart, "reading": self.reading,
            "inner reading": self.readings[0], "outer reading": self.readings[1], "lateness": self.lateness,
        }  # fmt: skip
        return {what: text for what, text in named.items() if text}

    @property
    def texts(self) -> list[str]:
        """All formulas: of what it adds, of their parts, and of rates."""
        return [*self.formulas.values(), *dict(self.where).values(), *(state.rate for state in self.states)]


@dataclass(frozen=True)
class Effect:
    """A physical effect that the paper's model lacks."""

    name: str
    joint: Joint
    description: str
    """What it is, for people, without the joint."""
    law: Law
    parameters: tuple[EffectParameter, ...]
    source: str
    variant: str = ""
    """Which of several forms of the same effect this is; empty where there is one."""
    at_an_instant: bool = False
    """Whether it happens once, in one trial, at its parameter `time`."""
    harmonic: bool = False
    """Whether it is one of many harmonics of a turn, which can imitate a part of any function of position. A joint may
    have several of them."""
    acts_as_zero: bool = False
    """Whether it cannot be distinguished from an encoder's zero that is off by the same in all trials."""
    contains: str = ""
    """Name of a simpler effect that this one is where some of its parameters are zero, if any. After a dot, the joint,
    if that is another one; after another dot, the variant, if it is that alone."""
    curve: Curve | None = field(default=None)
    """What its parameters are the coefficients of, where it is a nonparametric torque; they are fitted smoothly."""

    def __hash__(self) -> int:
        """Return one quickly: an effect is looked up often."""
        return hash((self.name, self.joint, self.variant))

    @property
    def key(self) -> str:
        """Name that no other effect of the catalogue has."""
        return ".".join(filter(None, (self.name, self.joint, self.variant)))

    @property
    def moves(self) -> bool:
        """Whether it changes the motion, and not only what encoders show."""
        return bool(self.law.torque or any(self.law.torques) or self.law.friction or self.law.cart)

    @property
    def dry(self) -> bool:
        """Whether it is a dry friction, with which a joint sticks."""
        return bool(self.law.friction)

    @property
    def of_angle(self) -> bool:
        """Whether it is a torque that depends on its joint's angle alone."""
        return bool(self.law.torque) and self.words <= {"angle"}

    @property
    def repeats(self) -> bool:
        """Whether it is an encoder's error that repeats many times a turn: a spectrum over the angle shows it."""
        return self.law.reading == HARMONIC and self.parameters[-1].shape

    def extends(self, other: "Effect") -> bool:
        """Return whether it contains another effect."""
        name, joint, variant = (*self.contains.split("."), "", "")[:3]
        same = (other.name, other.joint) == (name, joint or self.joint) and other != self
        return same and variant in ("", other.variant)

    @property
    def is_of_a_zero(self) -> bool:
        """Whether it acts as an encoder's zero that is off, in all trials or from an instant on."""
        return self.acts_as_zero or (self.at_an_instant and not self.moves)

    @property
    def of_both_encoders(self) -> bool:
        """Whether it changes what both encoders show, as no error of one of them does."""
        return any(self.law.readings)

    @property
    def uses_accelerations(self) -> bool:
        """Whether the law depends on accelerations of the motion itself."""
        return bool(self.words & {*ACCELERATIONS, "acceleration", "pull"})

    @cached_property
    def words(self) -> set[str]:
        """Names in the formulas that are not the law's own."""
        if self.curve is not None:
            return {self.curve.over}
        own = {p.name for p in self.parameters} | {state.name for state in self.law.states}
        return names_used(self.law.texts) - own - dict(self.law.where).keys()

    @property
    def states(self) -> int:
        """How many numbers it adds to those of the rods' state."""
        return len(self.law.states)

    @property
    def known_at_zero(self) -> bool:
        """Whether its states are known where it has no strength, so that there are none to follow."""
        return all(state.at_zero for state in self.law.states)

    @property
    def brings_states(self) -> bool:
        """Whether the motion itself depends on states of its own."""
        return self.moves and self.states > 0

    @property
    def formula(self) -> str:
        """The law in one line, as it is simulated."""
        if self.curve is not None:
            return f"a cubic B-spline over the joint's {self.curve.over}, {self.curve.count} coefficients"
        parts = [f"{what} = {text}" for what, text in self.law.formulas.items()]
        parts += [f"{state.name}' = {state.rate}" for state in self.law.states]
        parts += [f"{name} = {text}" for name, text in self.law.where]
        return "; ".join(parts)

    @property
    def has_score(self) -> bool:
        """Whether a score test is defined for it: not for an effect of an instant, or one that cannot be zero.

        Curves have a score test of their own, and what repeats has a spectrum. What has a memory is tried in the place
        of the effect that it contains.
        """
        return not (self.at_an_instant or self.curve or self.remembers or self.repeats) and any(
            p.lower <= 0.0 <= p.upper for p in self.parameters if not p.shape
        )

    @property
    def is_local(self) -> bool:
        """Whether it acts at a place that has to be looked for: a shape parameter begins at many."""
        return not self.contains and any(p.begins for p in self.parameters if p.shape and not p.fixed)

    @property
    def at_place_of_joint(self) -> bool:
        """Whether it is a torque that acts where its joint is at a place, whether or not that moves: a stiffness."""
        stiff = any(p.unit == "N m/rad" for p in self.parameters)
        depends = self.words <= {"angle", "speed"} and not self.states
        return self.is_local and stiff and depends and bool(self.law.torque)

    @property
    def remembers(self) -> bool:
        """Whether it is a torque in its joint that depends on what the joint did before."""
        return bool(self.law.torque and self.law.states)


def exclude_each_other(one: Effect, other: Effect) -> bool:
    """Return whether a model has at most one of two effects: forms of the same one in a joint, but for harmonics."""
    if one.harmonic and other.harmonic:
        return one.key == other.key
    return (one.name, one.joint) == (other.name, other.joint)


def in_joints(
    name: str, description: str, law: Law, parameters: Sequence[EffectParameter], source: str, **rest: Any
) -> tuple[Effect, ...]:
    """Return the same effect of each joint."""
    return tuple(Effect(name, joint, description, law, tuple(parameters), source, **rest) for joint in JOINTS)


TIME = EffectParameter("time", "s", 0.0, math.inf, 0.0, width=math.inf, shape=True)
"""When it happens, of an effect of an instant: anywhere in a trial."""
_WARMS_UP_IN = (3, 10)
"""Time constants that fits begin with [s]."""
_TIME_CONSTANT = EffectParameter(
    "time_constant", "s", 0.3, 1000.0, 5.0, shape=True, begins=tuple(map(str, _WARMS_UP_IN))
)


def ends_at(last: EffectParameter, drifting: str) -> EffectParameter:
    """Return what a value ends at that changes ever more slowly, `last + change*exp(-t/time_constant)`.

    Where it changes evenly, the same value is that of a name, `drifting`, with a `drift`.
    """
    return replace(last, begins=tuple(f"{drifting} + drift*{tau}" for tau in _WARMS_UP_IN))


def dies_away(change: EffectParameter) -> tuple[EffectParameter, EffectParameter]:
    """Return the parameters of what dies away along a trial, `change*exp(-t/time_constant)`, and fits begin with."""
    return replace(change, begins=tuple(f"-drift*{tau}" for tau in _WARMS_UP_IN)), _TIME_CONSTANT


def off_by_an_angle(
    name: str, angle: str, joints: Sequence[Joint], descriptions: Sequence[str], law: Callable[[str], Law], source: str
) -> tuple[Effect, ...]:
    """Return what acts as a zero that is off: always the same, drifting evenly, or ever more slowly.

    Each of the three is described; the law is that of a formula of what it is off by, which has a name.
    """
    off, drift = EffectParameter(angle, "rad", -0.3, 0.3, 0.01), EffectParameter("drift", "rad/s", -0.05, 0.05, 0.001)
    relaxing = ends_at(replace(off, name=f"last_{angle}"), angle), *dies_away(replace(off, name="change"))
    forms: tuple[tuple[str, str, tuple[EffectParameter, ...], str], ...] = (
        ("", angle, (off,), ""),
        ("drifting", f"{angle} + drift*t", (off, drift), ""),
        ("relaxing", f"last_{angle} + change*exp(-t/time_constant)", relaxing, f"{name}..drifting"),
    )
    return tuple(
        Effect(name, joint, what, law(now), of, source, variant, acts_as_zero=not variant, contains=simpler)
        for what, (variant, now, of, simpler) in zip(descriptions, forms, strict=True)
        for joint in joints
    )


def harmonic_in_joints(
    name: str, description: str, law: Law, periods: int, size: EffectParameter, source: str
) -> tuple[Effect, ...]:
    """Return a harmonic of a turn of each joint: its law has `sine`, `cosine` and how many `periods` a turn has.

    The name is that of all harmonics; `size` is what `sine` and `cosine` are alike in.
    """
    of_turn = EffectParameter("periods", "1", float(periods), float(periods), float(periods))
    parameters = (replace(size, name="sine"), replace(size, name="cosine"), of_turn)
    return in_joints(name, description, law, parameters, source, variant=f"{periods} per turn", harmonic=True)

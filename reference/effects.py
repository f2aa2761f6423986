# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What can go on in a rig beyond the paper's model, of a strength that can be chosen.

Their sizes go with the rig: torques with its weight's moments, drag with its inertias, compliances with its weight.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal, cast

import numpy as np

from reference import encoders, torques
from reference.dry_friction import DryFriction
from reference.encoders import Reading
from reference.mechanics import Cart, Rig
from reference.plant import Plant
from reference.torques import Joint, Torque

InPlant = Callable[[Plant, float], Plant]
Place = Literal["inner", "outer", "base"]


@dataclass(frozen=True)
class Effect:
    """One effect. What it does is a function of its strength, so that the same one can be made weak or strong."""

    name: str
    joint: Place
    unit: str
    """Unit of the strength."""
    small: float
    """A strength at which what it does is still in proportion to it."""
    largest: float
    """The largest strength that a rig of this size may have."""
    in_plant: InPlant | None = None
    """`(plant, strength)` to the plant with it."""
    in_reading: Callable[[float], Reading] | None = None
    """From the strength to what the encoders add."""
    late: bool = False
    """Whether the outer encoder is read later than the inner one, by the strength [s]."""
    signed: bool = False
    """Whether its strength may be negative."""
    trial: int | None = None
    """For what happens once: in which of the trials."""
    counted: bool = False
    """Whether its strength is a whole number of an encoder's counts."""
    stopping: float | None = None
    """The strength with which the joint comes to rest when it is meant to, where that is how it is chosen."""


@dataclass(frozen=True)
class Occasion:
    """What an effect is drawn for."""

    values: Mapping[str, float]
    durations: Sequence[float]
    """Of the trials in which something may happen once [s]."""
    rng: np.random.Generator
    harmonics: set[tuple[str, int]] = field(default_factory=set)
    """Joint and periods a turn of those that were drawn: two of one joint with as many periods are one."""

    def periods(self, joint: str) -> int:
        """Return a number of periods a turn that no harmonic of this joint has yet."""
        while (joint, drawn := int(self.rng.integers(3, 17))) in self.harmonics:
            pass
        self.harmonics.add((joint, drawn))
        return drawn

    def moment(self, joint: str) -> float:
        """Return the weight's largest moment about a joint [N m]."""
        v = self.values
        first = v["m1"] * v["l1"] + (v["m2"] + v["m0"]) * v["L"] if joint == "inner" else v["m2"] * v["l2"]
        return first * v["g"]

    def inertia(self, joint: str) -> float:
        """Return the inertia about a joint, both rods straight or the outer one alone [kg m^2]."""
        v = self.values
        outer = v["m2"] * v["l2"] ** 2 + v["J2"]
        return (
            v["m1"] * v["l1"] ** 2 + v["J1"] + (v["m2"] + v["m0"]) * v["L"] ** 2 + outer if joint == "inner" else outer
        )

    @property
    def weight(self) -> float:
        """Of all that hangs on the cart [N]."""
        return (self.values["m1"] + self.values["m2"] + self.values["m0"]) * self.values["g"]

    def stopping(self, joint: str) -> float:
        """Return a dry friction [N m] that stops a swing of a radian and more in 2 to 8 s.

        A swing falls by four times the friction over the moment in each period.
        """
        period = 2.0 * math.pi * math.sqrt(self.inertia(joint) / self.moment(joint))
        return self.moment(joint) * 1.2 * period / (4.0 * self.rng.uniform(2.0, 8.0))


def _dry(joint: Joint, change: Callable[[DryFriction, float], DryFriction]) -> InPlant:
    """Return how dry friction gets into a joint, beside what is there."""

    def put(plant: Plant, strength: float) -> Plant:
        if joint == "inner":
            return replace(plant, inner=change(plant.inner, strength))
        return replace(plant, outer=change(plant.outer, strength))

    return put


def _acting(torque: Callable[[float], Torque]) -> InPlant:
    return lambda plant, strength: replace(plant, torques=(*plant.torques, torque(strength)))


def _on_rig(change: Callable[[Rig, float], Rig]) -> InPlant:
    return lambda plant, strength: replace(plant, rig=change(plant.rig, strength))


def draw(part: str, occasion: Occasion) -> Effect:
    """Return an effect by its `name.joint`; all but its strength is drawn at random."""
    name, joint = part.split(".")
    if joint == "base":
        return _of_base(name, occasion)
    place = cast(Joint, joint)
    if name in _DRY:
        return _DRY[name](place, occasion)
    return (_torque if name in _TORQUES else _reading)(name, place, occasion)


def _coulomb(joint: Joint, of: Occasion) -> Effect:
    moment = of.moment(joint)
    put = _dry(joint, lambda there, size: replace(there, torque=size))
    return Effect("coulomb_friction", joint, "N m", 1e-4 * moment, 0.25 * moment, put)


def _stopping(joint: Joint, of: Occasion) -> Effect:
    return replace(_coulomb(joint, of), stopping=of.stopping(joint))


def _stribeck(joint: Joint, of: Occasion) -> Effect:
    moment, speed, more = of.moment(joint), of.rng.uniform(0.3, 1.5), of.rng.uniform(0.6, 1.5)
    put = _dry(joint, lambda there, size: replace(there, torque=size, extra=more * size, speed=speed))
    return Effect("stribeck_friction", joint, "N m", 1e-4 * moment, 0.12 * moment, put)


def _breakaway(joint: Joint, of: Occasion) -> Effect:
    return replace(_stribeck(joint, of), stopping=of.stopping(joint))


def _drifting(joint: Joint, of: Occasion) -> Effect:
    moment, share = of.moment(joint), of.rng.uniform(-0.8, 0.8) / max(of.durations)
    put = _dry(joint, lambda there, size: replace(there, torque=size, drift=share * size))
    return Effect("drifting_friction", joint, "N m", 1e-4 * moment, 0.1 * moment, put)


def _load(joint: Joint, of: Occasion) -> Effect:
    length = of.values["L"]
    put = _dry(joint, lambda there, size: replace(there, lever=size))
    return Effect("load_friction", joint, "m", 1e-4 * length, 0.02 * length, put)


def _rub(joint: Joint, of: Occasion) -> Effect:
    moment, middle, half = of.moment(joint), of.rng.uniform(-0.8, 0.8), of.rng.uniform(0.2, 0.5)
    put = _dry(joint, lambda there, size: replace(there, rub=size, rub_middle=middle, rub_half=half))
    return Effect("partial_rub", joint, "N m", 1e-4 * moment, 0.25 * moment, put)


_DRY: dict[str, Callable[[Joint, Occasion], Effect]] = {
    "coulomb_friction": _coulomb,
    "stopping": _stopping,
    "stribeck_friction": _stribeck,
    "breakaway": _breakaway,
    "drifting_friction": _drifting,
    "load_friction": _load,
    "partial_rub": _rub,
}

_TORQUES = ("quadratic_friction", "joint_spring", "cogging_torque", "magnet", "air_drag", "bob_drag", "impulse",
            "presliding_friction", "rotor_inertia", "constant_torque", "varying_viscosity", "end_stop",
            "drifting_viscosity", "eddy_brake")  # fmt: skip


def _torque(name: str, joint: Joint, of: Occasion) -> Effect:
    rng, moment, inertia = of.rng, of.moment(joint), of.inertia(joint)
    if name == "quadratic_friction":
        put = _acting(lambda size: torques.quadratic(joint, size))
        return Effect(name, joint, "N m s^2", 1e-4 * inertia, 0.3 * inertia, put)
    if name == "joint_spring":
        at_ease = rng.uniform(-0.3, 0.3)
        put = _acting(lambda size: torques.spring(joint, size, at_ease))
        return Effect(name, joint, "N m/rad", 1e-4 * moment, moment, put)
    if name == "cogging_torque":
        periods, phase = of.periods(joint), rng.uniform(-math.pi, math.pi)
        put = _acting(lambda size: torques.cogging(joint, size, periods, phase))
        return Effect(name, joint, "N m", 1e-4 * moment, 0.2 * moment, put)
    if name == "magnet":
        at, reach = rng.uniform(-0.8, 0.8), rng.uniform(0.08, 0.25)
        put = _acting(lambda size: torques.magnet(joint, size, at, reach))
        return Effect(name, joint, "N m", 1e-4 * moment, 0.3 * moment, put)
    if name == "end_stop":
        place, loss = float(rng.choice([-1.0, 1.0]) * rng.uniform(0.4, 1.2)), rng.uniform(0.0, 0.3)
        put = _acting(lambda size: torques.stop(joint, size, place, loss))
        return Effect(name, joint, "N m/rad", 1e-4 * moment, 10.0 * moment, put)
    if name == "air_drag":
        shortest = 2.0 * of.values["l2"]
        whole = shortest + rng.uniform() * max(of.values["L"] - shortest, 0.0)
        length = whole if joint == "outer" and rng.random() < 0.7 else 0.0
        put = _acting(lambda size: torques.drag(joint, size, length))
        return Effect(name, joint, "N m s^2", 1e-4 * inertia, 0.3 * inertia, put)
    if name == "bob_drag":
        place = of.values["l2"] * rng.uniform(1.0, 2.0)
        put = _acting(lambda size: torques.bob(size, place))
        return Effect(name, joint, "N m s^2", 1e-4 * inertia, 0.3 * inertia, put)
    if name == "impulse":
        trial, at = _once(of)
        put = _acting(lambda size: torques.knock(joint, size, at, 0.04))
        swing = math.sqrt(moment * inertia)
        return Effect(name, joint, "N m s", 1e-4 * swing, swing, put, signed=True, trial=trial)
    if name == "constant_torque":
        put = _acting(lambda size: torques.constant(joint, size))
        return Effect(name, joint, "N m", 1e-4 * moment, 0.1 * moment, put, signed=True)
    if name == "varying_viscosity":
        periods, phase = int(rng.integers(1, 3)), rng.uniform(-math.pi, math.pi)
        put = _acting(lambda size: torques.eddy_currents(joint, size, periods, phase))
        return Effect(name, joint, "N m s", 1e-4 * inertia, 0.3 * inertia, put)
    if name == "eddy_brake":
        at, half = rng.uniform(-0.6, 0.6), rng.uniform(0.3, 0.9)
        put = _acting(lambda size: torques.eddy_brake(joint, size, at, half))
        return Effect(name, joint, "N m s", 1e-4 * inertia, 3.0 * inertia, put)
    if name == "drifting_viscosity":
        time_constant = rng.uniform(0.3, 1.0) * max(of.durations)
        put = _acting(lambda size: torques.cooling(joint, size, time_constant))
        return Effect(name, joint, "N m s", 1e-4 * inertia, 0.3 * inertia, put)
    if name == "presliding_friction":
        give = float(np.exp(rng.uniform(np.log(1e-3), np.log(0.5))))
        put = _acting(lambda size: torques.dahl(joint, size, size / give))
        return Effect(name, joint, "N m", 1e-4 * moment, 0.1 * moment, put)
    put = _on_rig(lambda rig, size: replace(rig, rotor=size))
    return Effect(name, joint, "kg m^2", 1e-4 * inertia, 0.5 * inertia, put)


def _of_base(name: str, of: Occasion) -> Effect:
    if name == "oblique_view":
        axis = of.rng.uniform(-math.pi, math.pi)
        return Effect(name, "base", "1", 1e-5, 0.05, in_reading=lambda size: encoders.oblique_view(size, axis))
    if name == "side_force":
        outer = of.moment("outer") / of.moment("inner") * of.rng.uniform(-3.0, 0.0)
        put = _acting(lambda size: torques.wind(size, outer * size))
        return Effect(name, "base", "N m", 1e-4 * of.moment("inner"), 0.1 * of.moment("inner"), put, signed=True)
    if name == "gravity_tilt":
        return Effect(name, "base", "rad", 1e-5, 0.1, _on_rig(lambda rig, size: replace(rig, tilt=size)), signed=True)
    rods = of.weight / of.values["g"]
    shares = (0.1, 1.0) if name == "pivot_compliance" else (2.0, 20.0)
    mass = rods * float(np.exp(of.rng.uniform(*np.log(shares))))
    damping = of.rng.uniform(0.02, 0.3)

    def held(rig: Rig, compliance: float) -> Rig:
        critical = 2.0 * math.sqrt((rods + mass) / compliance)
        return replace(rig, cart=Cart(mass, 1.0 / compliance, damping * critical))

    softest = 0.02 * of.values["L"] / of.weight
    return Effect(name, "base", "m/N", 5e-3 * softest, softest, _on_rig(held))


def _reading(name: str, joint: Joint, of: Occasion) -> Effect:
    if name == "encoder_offset":
        return Effect(
            name, joint, "rad", 1e-5, 0.1, in_reading=lambda size: encoders.offset(joint, size), signed=True
        )  # fmt: skip
    if name == "drifting_encoder_offset":
        duration = max(of.durations)
        return Effect(
            "encoder_offset", joint, "rad", 1e-5, 0.1,
            in_reading=lambda size: encoders.drifting_offset(joint, size, duration), signed=True,
        )  # fmt: skip
    if name == "encoder_scale":
        return Effect(name, joint, "1", 1e-5, 0.05, in_reading=lambda size: encoders.scale(joint, size), signed=True)
    if name == "encoder_eccentricity":
        phase = of.rng.uniform(-math.pi, math.pi)
        return Effect(name, joint, "rad", 1e-5, 0.05, in_reading=lambda size: encoders.eccentricity(joint, size, phase))
    if name in ("encoder_harmonic", "encoder_interpolation"):
        few, many = (2, 5) if name == "encoder_harmonic" else (8, 200)
        periods, phase = int(of.rng.integers(few, many)), of.rng.uniform(-math.pi, math.pi)
        # An encoder goes on counting in one direction.
        largest = min(0.05, 0.3 / periods)
        return Effect(
            name, joint, "rad", 1e-5, largest, in_reading=lambda size: encoders.harmonic(joint, size, periods, phase)
        )
    if name == "encoder_filter":
        longest = 0.05 * math.sqrt(of.values["L"] / of.values["g"])
        return Effect(name, joint, "s", 1e-3 * longest, longest, in_reading=lambda size: encoders.low_pass(joint, size))
    if name == "encoder_compliance":
        damping, unit = of.rng.uniform(0.05, 0.3), of.values["L"] / of.values["g"]
        return Effect(
            name, joint, "s^2", 1e-5 * unit, 0.01 * unit,
            in_reading=lambda size: encoders.elastic_coupling(joint, size, damping),
        )  # fmt: skip
    if name == "encoder_slip":
        trial, at = _once(of)
        return Effect(
            name, joint, "rad", 1e-5, 0.2, in_reading=lambda size: encoders.slip(joint, size, at), signed=True,
            counted=True, trial=trial,
        )  # fmt: skip
    if name == "backlash":
        return Effect(name, joint, "rad", 1e-5, 0.03, in_reading=lambda size: encoders.backlash(joint, size))
    if name == "rod_flex":
        softest = 0.02 * of.values["L"] / of.weight
        return Effect(name, joint, "m/N", 1e-4 * softest, softest, in_reading=encoders.rod_flex)
    if name == "time_offset":
        return Effect(name, joint, "s", 1e-5, 0.02, late=True, signed=True)
    raise ValueError(f"there is no effect {name!r}")


def _once(of: Occasion) -> tuple[int, float]:
    """Return in which trial something happens once, and when [s]."""
    trial = int(of.rng.integers(len(of.durations)))
    return trial, of.durations[trial] * of.rng.uniform(0.3, 0.7)

"""The description of an effect, from which it is searched, fitted, reported, simulated and served."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Joint = Literal["inner", "outer", "base"]
JOINTS: tuple[Joint, Joint] = ("inner", "outer")
"""The joints between bodies, in the order of the angles."""

MOST_OF_A_LAW = 3
"""Parameters of an effect that is no curve, at most."""
NOT_BY_STATE, NOT_BY_COEFFICIENTS, NOT_BY_ANY = (0.0,) * 4, (0.0,) * 7, (0.0,) * MOST_OF_A_LAW
"""Derivatives of what does not depend on the state, on the coefficients, or on parameters."""


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
    inertia_power: int = 0
    """The physical value is the fit's times A22 to this power: 1 for torques, which the model has over A22."""
    shape: bool = False
    """Whether it is a shape parameter: without meaning unless another parameter of the effect differs from zero."""
    optional: bool = False
    """Whether it may be left out in a file: it then has its typical value."""
    includes_weights: bool = False
    """Whether it is a mass that a joint carries, to which weights clamped beyond the joint add."""

    @property
    def fixed(self) -> bool:
        """Whether it is a part of the effect's definition and not fitted."""
        return self.lower == self.upper

    def scale(self, inertia: float) -> float:
        """Return its physical value over its value in the fit, for the inertia A22 about the cart's joint [kg m^2]."""
        return inertia**self.inertia_power


class Form(IntEnum):
    """How a torque enters the equations of motion, and so what its compiled `law` is called with.

    Laws return values over A22 and their derivatives: in closed form, but for those of the quasi-static base by the
    state, which are differences. Laws of forms JOINT and RODS are functions of numbers alone, so that they can be
    computed for many motions at a time; they have up to three parameters, of which those that they lack are zero.
    """

    JOINT = 0
    """A torque between the two bodies of its joint. `law(angle, speed, parameters)` returns it, and its derivatives by
    angle, by speed, and (three numbers) by the parameters; angle from hanging and speed are the joint's."""
    RODS = 1
    """Torques on the rods. `law(state, turned, time, parameters, constants)` returns the generalised ones on theta1 and
    theta2, and for each its derivatives by the four numbers of the state, by the seven `COEFFICIENTS`, and by three
    parameters; `turned` are both angles' sines and cosines."""
    COUPLING = 2
    """A constant that adds to the inertia between the rods, A23 cos(theta1 - theta2); it has no law, its one parameter
    is that constant."""
    BASE = 3
    """The cart's joint itself moves on a spring; it has no law. Its two states are position [m] and speed [m/s], its
    parameters compliance, natural frequency and damping ratio (see `dynamics`)."""
    MEMORY = 4
    """A torque between the two bodies of its joint that depends on a state of its own, which has a rate. `law(speed,
    direction, own, values, row, slopes)` returns torque and rate; the parameters are `values[row]`, the direction, 1 or
    -1, is that of the speed, and changes between steps only; `slopes[0]` takes the torque's derivatives by the joint's
    speed, by its own state, and by each parameter, `slopes[1]` the rate's."""
    CURVE = 5
    """A torque between the two bodies of its joint that is a curve. `law(angle, speed, values, row, slopes)` returns
    it; the coefficients are `values[row]`, and `slopes[0]` takes the derivatives by angle, by speed, and by each."""


@dataclass(frozen=True)
class Curve:
    """A smooth curve whose coefficients are an effect's parameters."""

    over: Literal["angle", "speed"]
    """What it is a function of: the joint's angle (then it is periodic) or speed."""
    count: int
    """Number of its coefficients."""


@dataclass(frozen=True)
class TorqueEffect:
    """An effect that enters the equations of motion."""

    name: str
    joint: Joint
    variant: str
    """Which of several forms of the same effect this is; empty where there is one."""
    description: str
    """What it is, for people, without the joint."""
    formula: str
    source: str
    parameters: tuple[EffectParameter, ...]
    law: Callable[..., Any] | None
    """Compiled; see `Form`."""
    form: Form = Form.JOINT
    dry: bool = False
    """Whether `law` gives the size of a set-valued friction of the joint instead: it acts against the joint's motion,
    and holds the joint still while a torque of that size suffices. Of form RODS, the first value returned is it."""
    at_an_instant: bool = False
    """Whether it happens once, in one trial, at its parameter `time`: an impulse on the rod of its joint."""
    harmonic: bool = False
    """Whether it is one of many harmonics of a turn, which can imitate a part of any function of position. A joint may
    have several of them."""
    of_angle: bool = False
    """Whether its torque is a function of the joint's angle alone, as a curve over the angle is."""
    states: int = 0
    """How many numbers it adds to those of the rods' state."""
    start_std: float = math.inf
    """Standard deviation of each of them where a window begins, beforehand."""
    in_balance: bool = False
    """Whether the balance of forces looks for it, before anything is simulated: where it is strong, the paper's model
    fits so badly that its residual does not show it. Dry friction in both joints is looked for together, anything else
    alone."""
    acts_as_zero: bool = False
    """Whether it cannot be distinguished from an encoder's zero that is off by the same in all trials."""
    linear: bool = True
    """Whether it is linear in small motions: dry friction, drag (of second order) and impulses are not."""
    turns_over: str = ""
    """Name of a parameter that is a joint speed, or of form MEMORY a joint angle, within which the torque changes; the
    integrator's steps resolve it."""
    contains: str = ""
    """Name of a simpler effect of the same joint that this one is where some of its parameters are zero, if any."""
    begins: Callable[[float, Array], Sequence[Sequence[float]]] | None = None
    """Parameters to begin fits with that go on from the simpler effect: `begins(strength, coefficients)`, given its
    first parameter and the model's coefficients (7,). Where that is none, their typical values do."""
    curve: Curve | None = None
    """What its parameters are the coefficients of, where it is a torque without a name; they are fitted smoothly."""

    @property
    def key(self) -> str:
        """Name that no other effect of the catalogue has."""
        return ".".join(filter(None, (self.name, self.joint, self.variant)))

    @property
    def brings_states(self) -> bool:
        """Whether it adds states to those of the rods."""
        return self.states > 0

    @property
    def has_score(self) -> bool:
        """Whether a score test is defined for it: not for an effect of an instant, or one that cannot be zero.

        Curves have a score test of their own. What has a memory is tried in the place of the effect that it contains.
        """
        return not (self.at_an_instant or self.curve or self.form is Form.MEMORY) and any(
            p.lower <= 0.0 <= p.upper for p in self.parameters if not p.shape
        )


@dataclass(frozen=True)
class SensorEffect:
    """An effect that the encoders have on the angles they report; the motion itself is not changed."""

    name: str
    joint: Joint
    variant: str
    description: str
    formula: str
    source: str
    parameters: tuple[EffectParameter, ...]
    law: Callable[..., Any] | None
    """Compiled. `law(angle, time, values, row, slopes)` returns what is added to the encoder's angle [rad]; the
    parameters are `values[row]`, and `slopes[row]` takes the derivatives by the joint's angle and by each parameter.
    None where nothing is added."""
    delays: bool = False
    """Whether its one parameter is by how much the encoder is late [s]."""
    has_play: bool = False
    """Whether its one parameter is the gap in the encoder's coupling [rad], within which the joint turns without the
    encoder."""
    bends: bool = False
    """Whether it is no error of an encoder, but a rod that bends, so that both encoders sit askew; see `bending`."""
    at_an_instant: bool = False
    """Whether it happens once, in one trial: it is added from its parameter `time` on."""
    acts_as_zero: bool = False
    """Whether it is an encoder's zero that is off by the same in all trials."""
    is_scale: bool = False
    """Whether readings are one plus its parameter times the angle from where the rods hang."""

    @property
    def key(self) -> str:
        """Name that no other effect of the catalogue has."""
        return ".".join(filter(None, (self.name, self.joint, self.variant)))

    @property
    def harmonic(self) -> bool:
        """Return false: it is not a torque."""
        return False

    @property
    def curve(self) -> None:
        """Return nothing: it is not a torque."""
        return None

    @property
    def brings_states(self) -> bool:
        """Return false: the motion itself is not changed."""
        return False

    @property
    def has_score(self) -> bool:
        """Whether a score test is defined for it."""
        return not self.at_an_instant


Effect = TorqueEffect | SensorEffect


def exclude_each_other(one: Effect, other: Effect) -> bool:
    """Return whether a model has at most one of two effects: forms of the same one in a joint, but for harmonics."""
    if one.harmonic and other.harmonic:
        return one.key == other.key
    return (one.name, one.joint) == (other.name, other.joint)

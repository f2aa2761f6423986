"""What an effect is: one description, from which it is searched, fitted, reported, simulated and served."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Joint = Literal["inner", "outer", "base"]


@dataclass(frozen=True)
class EffectParameter:
    """A number that an effect is given by."""

    name: str
    unit: str
    """Unit of its physical value."""
    lower: float
    """Lowest physically possible value, in the unit of the fit."""
    upper: float
    """Highest plausible value, in the unit of the fit."""
    typical: float
    """A value to begin a fit with, where the effect is present."""
    inertia_power: int = 0
    """The physical value is the fit's times A22 to this power: 1 for torques, which the model has over A22."""
    shape: bool = False
    """Whether it has no meaning unless another parameter of the effect differs from zero."""
    optional: bool = False
    """Whether an effect may be given without it: it then has its typical value."""

    @property
    def fixed(self) -> bool:
        """Whether it is a part of the effect's definition and not fitted."""
        return self.lower == self.upper

    def scale(self, inertia: float) -> float:
        """Return its physical value over its value in the fit, for the inertia A22 about the cart's joint [kg m^2]."""
        return inertia**self.inertia_power


@dataclass(frozen=True)
class TorqueEffect:
    """An effect that enters the equations of motion as a torque."""

    name: str
    joint: Joint
    variant: str
    """Which of several forms of the same effect this is; empty where there is one."""
    description: str
    """What it is, for people, without the joint."""
    formula: str
    source: str
    parameters: tuple[EffectParameter, ...]
    torque: Callable[..., Any]
    """Compiled: `(theta1, theta2, omega1, omega2, time, values, row, constants)` to the generalised torques on theta1
    and theta2 over A22 [rad/s^2], with the effect's parameters in `values[row]`."""
    at_an_instant: bool = False
    """Whether it happens once, in one trial, at its parameter `time`."""
    harmonic: bool = False
    """Whether it is one of many harmonics of a turn, which can imitate a part of whatever depends on position."""
    linear: bool = True
    """Whether it acts on the smallest motions in proportion to them. Dry friction stops them, drag vanishes before
    them, a knock does not depend on them."""
    contains: str = ""
    """Name of a simpler effect of the same joint that this one is where some of its parameters are zero, if any."""

    @property
    def key(self) -> str:
        """Name that no other effect of the catalogue has."""
        return ".".join(filter(None, (self.name, self.joint, self.variant)))


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
    reading: Callable[[Array, Array, Array], tuple[Array, Array]]
    """`(angle, time, values)` to what is added to the encoder's angle (n,) [rad], and that with respect to the angle
    and to each parameter, (n, 1 + parameters)."""
    delays: bool = False
    """Whether its one parameter is by how much the encoder is late [s], instead of anything added."""
    at_an_instant: bool = False
    """Whether it happens once, in one trial, at its parameter `time`."""

    @property
    def key(self) -> str:
        """Name that no other effect of the catalogue has."""
        return ".".join(filter(None, (self.name, self.joint, self.variant)))


Effect = TorqueEffect | SensorEffect

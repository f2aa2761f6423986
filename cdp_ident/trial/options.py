# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Options of loading a trial, whose defaults are the project's conventions, and how messages name them."""

import math
from dataclasses import dataclass, fields
from typing import ClassVar, Literal, get_args

from cdp_ident.errors import OptionError

OuterAngle = Literal["relative", "absolute"]
Zero = Literal["upright", "hanging"]
Time = Literal["auto", "stamps", "receipt"]
Unit = Literal["radians", "degrees", "gradians", "milliradians", "turns"]
ScaleFrom = Literal["hanging", "zero"]
Conventions = Literal["refuse", "warn"]
Input = Literal["auto", "none", "cart", "joints"]

UNITS: dict[Unit, float] = {
    **{"radians": 1.0, "degrees": math.pi / 180, "gradians": math.pi / 200, "milliradians": 1e-3},
    "turns": 2.0 * math.pi,
}
"""Of readings [rad]."""


@dataclass(frozen=True)
class TrialOptions:
    """How a bag's joint states are to be understood, and what of them is taken.

    Raises OptionError where a value makes no sense.
    """

    topic: str = "joint_states"
    """Topic of the sensor_msgs/JointState messages, or several with blanks between; without a leading `/`, one in a
    namespace will do."""
    time: Time = "auto"
    """What tells when samples were measured; auto: the stamps, or receipt where stamps are missing or useless."""
    inner_joint: str = "inner_joint"
    """Name of the joint between cart and inner rod."""
    outer_joint: str = "outer_joint"
    """Name of the joint between the rods."""
    cart_joint: str = "cart_joint"
    """Name of the cart's joint; the cart is taken to be at rest where a bag lacks it. Empty: do not look for it."""
    input: Input = "auto"
    """What drives the motion that is taken: nothing, the measured cart, or motors in the joints; auto: nothing, or
    where no motion is free for long what drives most of it. Efforts of motors are in [N m]."""
    inner_unit: Unit = "radians"
    """Unit of the inner joint's readings."""
    outer_unit: Unit = "radians"
    """Unit of the outer joint's readings."""
    outer_angle: OuterAngle = "relative"
    """Whether the outer joint's position is the angle relative to the inner rod, or absolute."""
    zero: Zero = "upright"
    """Where the absolute angles are zero. A relative outer angle is zero with the rods in line."""
    inner_sign: int = 1
    """1 if the inner joint counts positive towards the cart's +x, -1 if the other way."""
    outer_sign: int = 1
    """1 if the outer joint counts positive towards the cart's +x, -1 if the other way."""
    inner_offset: float = 0.0
    """What is added to the inner joint's angle, where its zero is neither upright nor hanging [rad]."""
    outer_offset: float = 0.0
    """What is added to the outer joint's angle, absolute or relative as it is, likewise [rad]."""
    inner_scale: float = 1.0
    """What the inner joint's readings are over the angle that it turns by, where its counts per turn are wrong [1]."""
    outer_scale: float = 1.0
    """What the outer joint's readings are over the angle that it turns by, where its counts per turn are wrong [1]."""
    scale_from: ScaleFrom = "hanging"
    """Where absolute readings with a scale are right: where the rods hang, or where they are zero."""
    cart_sign: int = 1
    """1 if the cart's joint counts positive towards +x, -1 if the other way."""
    start: float = 0.0
    """Nothing earlier after the first sample is used [s]."""
    stop: float = math.inf
    """Nothing later after the first sample is used [s]."""
    longest_gap: float = 0.0
    """A longer gap between samples parts the recording, as turns could be lost; 0: as the motion's speed asks [s]."""
    cart_limit: float = 0.01
    """A cart that moves further within about half a second [m] is being driven or pushed; less is measured motion."""
    hand_torque: float = 0.1
    """A torque on a rod beyond gravity and friction, as a share of gravity's largest on it, of a hand [1]."""
    rest_amplitude: float = 0.01
    """A stretch in which neither rod moves more than this, or than four times the noise, is rest [rad rms]."""
    shortest: float = 0.0
    """Zero-input motion shorter than this is no trial; 0: about a swing, as fast as this pendulum swings [s]."""
    conventions: Conventions = "refuse"
    """What to do where the data contradict zero, outer_angle or the signs: refuse the bag, or only warn."""

    def __post_init__(self) -> None:
        for option in fields(self):
            value, choices = getattr(self, option.name), get_args(option.type)
            if choices and value not in choices:
                raise OptionError(f"{option.name} is {value!r}: expected one of {', '.join(choices)}")
        for name in ("inner_sign", "outer_sign", "cart_sign"):
            if getattr(self, name) not in (1, -1):
                raise OptionError(f"{name} is {getattr(self, name)!r}: expected 1 or -1")
        for name in ("inner_offset", "outer_offset"):
            if not math.isfinite(getattr(self, name)):
                raise OptionError(f"{name} is {getattr(self, name)!r}: expected an angle")
        for name in ("longest_gap", "shortest"):
            if not 0 <= getattr(self, name) < math.inf:
                raise OptionError(f"{name} is {getattr(self, name)!r}: expected a positive number, or 0")
        for name in ("inner_scale", "outer_scale", "cart_limit", "hand_torque", "rest_amplitude"):
            if not 0 < getattr(self, name) < math.inf:
                raise OptionError(f"{name} is {getattr(self, name)!r}: expected a positive number")
        if not 0 <= self.start < self.stop:
            raise OptionError(f"start {self.start} s and stop {self.stop} s leave nothing: expected 0 <= start < stop")
        if not (self.topic.strip("/ ") and self.inner_joint and self.outer_joint):
            raise OptionError("topic, inner_joint and outer_joint must not be empty")
        joints = [self.inner_joint, self.outer_joint, self.cart_joint]
        if len(set(joints)) < len(joints):
            raise OptionError(f"inner, outer and cart joint must be different joints, not {', '.join(joints)}")

    insist: ClassVar[str] = "conventions: warn takes the data all the same"
    """How the user gets his way."""
    all_settable: ClassVar[bool] = True
    """Whether the user can set units and the cart's joint, too."""

    def called(self, option: str) -> str:
        """Return how the user writes an option: here, as a key of a parameter file."""
        return option

    def setting(self, option: str, value: object) -> str:
        """Return how the user sets it."""
        return f"{self.called(option)}: {value}"

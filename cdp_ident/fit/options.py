# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""How trials are fitted: everything that a user may choose, with its default."""

import math
from dataclasses import dataclass, field
from typing import Literal

from cdp_ident.errors import OptionError
from cdp_ident.fit.model_unknowns import TORQUE_STD
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.objective import PAPER_SPAN, SHORT_IGA
from cdp_ident.fit.prior import Mechanism, Prior
from cdp_ident.search.options import METHODS, GeneticOptions

_SHORTEST_WINDOW = 0.001
"""In a shorter one no trial has samples enough [s]."""


@dataclass(frozen=True)
class IdentifyOptions:
    """How trials are identified."""

    prior: Prior = field(default_factory=Prior)
    """Nominal and known values, and the box of the search."""
    method: Literal["iga", "tga"] | None = None
    """The paper's search in full, by name; None: the improved one, cut short, as the fit takes over from it."""
    genetic: GeneticOptions | None = None
    """The search's settings, where they are not those of the method."""
    seed: int = 1
    """Seed of the only random generator."""
    window: float = 0.0
    """Length of the windows over which predictions are judged [s]; 0 for what suits the rig and its motion."""
    length_std: float = 0.005
    """How well L is known before it is fitted: its standard deviation as a share of it, by default that of a length
    measured with a ruler; 0 where it is exact."""
    gravity_std: float = 0.0
    """How well g is known before it is fitted, likewise; where the cart rests, motion shows L / g alone."""
    torque_std: float = TORQUE_STD
    """How well torques of motors are known, where these drive the joints: the relative standard deviation of a torque
    constant."""
    named_effects_only: bool = False
    """Whether nonparametric torques are left unexplained, instead of being identified as curves."""
    effects_file: str = ""
    """YAML file of effects that are looked for beside the catalogue's; as --effects."""
    motion_for_effects: float = 0.0
    """Length of the motion in which effects are looked for, in windows spread evenly over all of it [s]; 0 for as much
    as suffices."""

    def __post_init__(self) -> None:
        if self.window and not _SHORTEST_WINDOW <= self.window < math.inf:
            raise OptionError(
                f"window is {self.window} s; it must be at least {_SHORTEST_WINDOW} s, or 0 for what suits the rig"
            )
        for name in ("length_std", "gravity_std", "torque_std"):
            std = getattr(self, name)
            if not std >= 0.0:
                raise OptionError(f"{name} is {std}; it must be a share of it such as 0.005, or 0 where it is exact")
        if self.motion_for_effects < 0.0:
            raise OptionError(f"motion_for_effects is {self.motion_for_effects} s; it must be positive, or 0")
        if self.method is not None and self.method not in METHODS:
            raise OptionError(f"method is {self.method!r}; it must be one of {', '.join(METHODS)}")

    @property
    def search(self) -> GeneticOptions:
        """The search's settings."""
        return self.genetic or (METHODS[self.method] if self.method else SHORT_IGA)

    def span(self, window: float) -> float:
        """Return how long the search simulates from one initial state [s], given the length of a window [s]."""
        return PAPER_SPAN if self.method else window

    @property
    def model(self) -> MotionModel:
        """The model to be fitted."""
        return MotionModel(Mechanism.of(self.prior), self.length_std, self.gravity_std)

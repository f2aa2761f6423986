# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a recorder is to do."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

from cdp_ident.rig.recording.detector import TrialLimits
from cdp_ident.rig.recording.facts import JointNames
from cdp_ident.user_input import Limits


@dataclass(frozen=True)
class RecorderOptions:
    """What to record, where, and what counts as a trial."""

    folder: Path = Path("trials")
    """Where bags go, each in a folder of its own."""
    name: str = "trial"
    """What names of bags begin with; the time follows."""
    joints: JointNames = field(default_factory=JointNames)
    limits: TrialLimits = field(default_factory=TrialLimits)
    pre_trigger: Annotated[float, Limits(0.0, 60.0)] = 1.0
    """How much from before the release is kept [s]."""
    cart_limit: Annotated[float, Limits(0.0, 10.0)] = 0.002
    """With more motion of the cart a trial is not zero-input [m]."""
    shortest: Annotated[float, Limits(0.0, 3600.0)] = 5.0
    """A shorter trial is of little use [s]."""
    rearm: bool = False
    """Arm at the start and after each trial without being asked."""

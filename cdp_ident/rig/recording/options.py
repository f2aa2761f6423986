"""What a recorder is to do."""

from dataclasses import dataclass, field
from pathlib import Path

from cdp_ident.rig.recording.detector import TrialLimits
from cdp_ident.rig.recording.facts import JointNames


@dataclass(frozen=True)
class RecorderOptions:
    """What to record, where, and what counts as a trial."""

    folder: Path
    """Bags go here, each in a folder of its own."""
    name: str = "trial"
    """Their names are this and the time."""
    joints: JointNames = field(default_factory=JointNames)
    limits: TrialLimits = field(default_factory=TrialLimits)
    pre_trigger: float = 1.0
    """How much from before the release is kept [s]."""
    cart_limit: float = 0.002
    """More motion of the cart is not zero-input [m]."""
    shortest: float = 5.0
    """A shorter trial is of little use [s]."""
    rearm: bool = False
    """Whether to arm at the start and after each trial without being asked."""

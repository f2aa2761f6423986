"""The parameters that say what counts as held, let go and at rest."""

from cdp_ident.rig.recording.detector import TrialLimits
from cdp_ident.ros.parameters import Parameters


def declare_trial_limits(parameters: Parameters) -> TrialLimits:
    """Declare the limits of a trial and return them."""
    defaults = TrialLimits()

    def number(name: str, default: float, description: str, unit: str, maximum: float) -> float:
        return parameters.declare(name, default, description, unit=unit, minimum=0.0, maximum=maximum)

    return TrialLimits(
        hold=number("hold_limit", defaults.hold, "held: both joints stay within this for 0.3 s", "rad", 1.0),
        away=number("away_limit", defaults.away, "held, not hanging: a rod is this far from hanging", "rad", 3.0),
        release=number("release_limit", defaults.release, "let go: a joint is this far from its hold", "rad", 3.0),
        rest=number("rest_limit", defaults.rest, "at rest: both joints stay within this for 1 s", "rad", 1.0),
        longest=number("longest", defaults.longest, "a trial ends after this", "s", 86400.0),
        silence=number("silence", defaults.silence, "a trial ends where samples are missing for longer", "s", 60.0),
    )

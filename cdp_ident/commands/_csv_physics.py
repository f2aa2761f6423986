"""Length, rate and gravity's direction by the motion itself, compared with the arguments of `import_csv`."""

import numpy as np

from cdp_ident.commands._csv_recording import Recording
from cdp_ident.errors import TrialError
from cdp_ident.model.parameters import NOMINAL
from cdp_ident.trial.find import Found
from cdp_ident.trial.gravity import gravity_of
from cdp_ident.trial.joints import Samples
from cdp_ident.trial.options import TrialOptions

_LARGEST_LEAN = 0.3
"""Largest lean of a camera [rad]; beyond it, columns are likely exchanged."""
_LENGTH_OFF = 0.05
"""Share by which the length that the motion shows may differ from the one given, besides four standard deviations."""
_WELL_KNOWN = 0.2
"""Standard deviation, as a share, up to which a length is worth saying."""


def check_film(samples: Samples, meaning: TrialOptions) -> None:
    """Raise TrialError where gravity does not pull down in the picture."""
    directions = gravity_of(samples, meaning)
    lean = 0.0 if directions is None else float(np.angle(np.mean(np.exp(1j * directions))))
    if abs(lean) <= _LARGEST_LEAN:
        return
    degrees = np.degrees(lean)
    if abs(abs(degrees) - 180) < np.degrees(_LARGEST_LEAN):
        raise TrialError("gravity pulls up in the picture: y counts the other way, give the other --y-axis")
    raise TrialError(
        f"gravity's direction is about {degrees:.0f} degrees from the picture's vertical: check which columns are x "
        "and y; if the camera leans so, --lean takes it out"
    )


def what_the_motion_says(found: Found, recording: Recording, rate: float | None) -> list[str]:
    """Return lines about how well the balance of forces holds, and with which length."""
    if found.balance is None or not found.balance.lumped.has_certain_signs:
        return []
    lumped = found.balance.lumped
    lines = [f"balance of forces: {lumped.unexplained:.1%} of the inner rod's acceleration is unexplained"]
    g = NOMINAL["g"]
    length, std = g * lumped.length_over_gravity, g * lumped.length_std
    if length > 0 and std < _WELL_KNOWN * length:
        lines[0] += f"; it holds with L = {length:.3g} +- {max(std, 1e-3 * length):.1g} m at g = {g:g} m/s^2"
        given = recording.length
        if given and abs(length / given - 1) > _LENGTH_OFF + 4 * std / given:
            faster = np.sqrt(given / length)
            remedy = f"--rate {rate / faster:.4g}" if rate else f"times that are {faster:.3g} times as long"
            lines.append(
                f"warning: the joints are {given:.3g} m apart, but the motion is that of {length:.3g} m: with {remedy} "
                "they agree; check rate, times and length"
            )
    return lines

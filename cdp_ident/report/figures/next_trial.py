"""Maps of the information that a next trial would bring, over the angles from which both rods are let go."""

from collections.abc import Iterator

import numpy as np

from cdp_ident.design.starts import HAND
from cdp_ident.diagnosis.identifiability import CONFIDENCE
from cdp_ident.report.advice import advice_title, advice_words, is_determined_now
from cdp_ident.report.figures.description import Array, Axis, Dots, Figure, Heat, Panel
from cdp_ident.report.schema import Section


def next_trial(report: Section) -> Iterator[Figure]:
    """Yield the maps of all that is asked of a next trial."""
    found = report["next_trial"]
    if not found or not found["advice"]:
        return
    yield Figure(
        "next_trial",
        "What a next trial would bring",
        "By the angles from hanging from which both rods are let go, at rest. Blue: to what share of their width "
        "intervals fall, the deeper the further, or of a value that no trial shows yet its interval then; of two "
        "effects, vermilion: by how many standard deviations they would differ. The ring is the start to take; "
        f"its number is that for a hand that misses by up to {HAND:.0f}°.",
        " ".join(f"{words}." for words in advice_words(report)),
        [_panel(advice) for advice in found["advice"]],
    )


def _panel(advice: Section) -> Panel:
    of = advice["map"]
    values = np.array(of["values"])
    inner, outer = np.degrees(of["inner_rad"]), np.degrees(of["outer_rad"])
    title = f"{advice_title(advice)}{', with a weight' if advice['weights'] else ''}"
    column, row = _place(inner, advice["inner_rad"]), _place(outer, advice["outer_rad"])
    if np.isfinite(values[column, row]):
        values[column, row] = advice["expected"]  # what the words say of it: where the hand misses it, too
    if not advice["against"]:
        is_known = is_determined_now(advice)
        values, title = (100.0 if is_known else 100.0 * CONFIDENCE) * values, f"{title} [{'' if is_known else '± '}%]"
    most = max(float(np.max(np.abs(values[np.isfinite(values)]), initial=0.0)), 1e-300)
    half = 100.0 if is_determined_now(advice) else most
    limits = (-most, most) if advice["against"] else (0.0, 2.0 * half)
    x, y = (np.array([float(place)]) for place in (column, len(outer) - 1 - row))
    chosen = Dots("the start to take", "ink", x, y, size=34.0, opacity=1.0, hollow=True)
    return Panel(
        Axis("inner rod, from hanging [°]", ticks=_ticks(inner)),
        Axis("outer rod, from hanging [°]", ticks=_ticks(outer[::-1])),
        [Heat([f"{angle:.0f}" for angle in inner], values.T[::-1], limits, 1 if advice["against"] else 0), chosen],
        title,
        260,
    )


def _place(angles: Array, chosen: float) -> int:
    """Return the place of an angle [rad] among some [degrees]."""
    return int(np.argmin(np.abs(angles - np.degrees(chosen))))


def _ticks(angles: Array) -> list[tuple[float, str]]:
    # Names of all places, as the ends of the axis follow from them; written at quarter turns.
    return [(float(place), f"{angle:.0f}" if round(angle) % 90 == 0 else "") for place, angle in enumerate(angles)]

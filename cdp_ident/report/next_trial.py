# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which trial to record next: what `report.json` holds of it, in words, and as maps over the starts."""

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from cdp_ident.arrays import Array
from cdp_ident.design.discrimination import RecordedMotion
from cdp_ident.design.knowledge import Knowledge
from cdp_ident.design.questions import ALL, Advice, answers, usual_questions
from cdp_ident.design.starts import HAND, Grid
from cdp_ident.errors import CdpIdentError
from cdp_ident.fit.physical import CONFIDENCE
from cdp_ident.model.parameters import INERTIA
from cdp_ident.report.figures.description import Axis, Figure, Heat, Line, Panel
from cdp_ident.report.outcome import Outcome
from cdp_ident.report.schema import ADVICE, REPORT, Also, Section, filled
from cdp_ident.report.wording import key_words, short_name, weights_words

NOISES = {
    "new_noise_rad": "new", "noise_kept": "kept", "noise_mixed": "mixed", "unknown_torque_over_A22": "torque",
    "time_noise_s": "time", "base_moves": "of_base", "absolute_angles": "absolute",
}  # fmt: skip
"""What is assumed of encoders and unknown torques, as `Noise` names it."""
REPORT_SPACING = 45.0
"""Of the starts that a report surveys [degrees]."""
_HARDLY_LESS = 0.95
"""What leaves intervals as wide as that share of what they are is not worth a trial."""


def next_trial_section(
    outcome: Outcome, failed: Callable[[str], None], ends: Callable[[], bool] = lambda: False
) -> Section | None:
    """Return the most informative next trials; None where the fit failed.

    Where no motion can be computed, or `ends` returns true meanwhile, there is none either, and `failed` is called with
    the reason.
    """
    trace, data = outcome.trace, outcome.identification.data
    if trace.failure:
        return None
    last = trace.completed
    try:
        knowledge = Knowledge.of(last.whole, last.fit.values, trace.covariance, last.inertia.value)
        motion = partial(RecordedMotion.of, trials=data.trials)
        questions = usual_questions(knowledge.model, [effect.also_possible for effect in trace.effects])
        used = [trial.weights for trial in outcome.loaded.trials]
        advice = answers(knowledge, motion, questions, Grid.of(REPORT_SPACING), used, ends)
        assumed = {name: getattr(knowledge.noise, of) for name, of in NOISES.items()}
        assumed["step_rad"] = knowledge.sampling.steps
        section = {
            "assumed": Also(knowledge.sampling, assumed),
            "advice": [advice_section(one) for one in advice if one],
        }
        return dict(filled(REPORT["properties"]["next_trial"], section))
    except (CdpIdentError, np.linalg.LinAlgError) as error:
        failed(f"which trial to record next: {error}")
        return None


def advice_section(advice: Advice) -> Section:
    """Return advice as `report.json` holds it."""
    question = {"for": advice.question.about, "against": advice.question.against or None}
    of_start = {**vars(advice), **question, "map": Also(advice.grid, {"values": advice.values})}
    return dict(filled(ADVICE, Also(advice.trial, of_start)))


def advice_title(advice: Section) -> str:
    """Say what a trial is to tell of."""
    if advice["against"]:
        return f"{key_words(advice['for'])}, or {key_words(advice['against'])}"
    return "all base parameters" if advice["for"] == ALL else short_name(advice["for"])


def advice_words(report: Section) -> list[str]:
    """Say which trial to record next, for each purpose, and what it would bring."""
    found = report["next_trial"]
    return [one_advice(advice) for advice in found["advice"]] if found else []


def one_advice(advice: Section) -> str:
    """Say from where to let go for one purpose, with which weight, and what that would bring."""
    several = len(advice["names"]) > 1
    if not advice["against"] and is_determined_now(advice) and advice["expected"] > _HARDLY_LESS:
        least = _percent(1.0 - _HARDLY_LESS)
        return f"{advice_title(advice)}: no trial makes {'them' if several else 'it'} surer by as much as {least}"
    start = f"let go with the inner rod {_held(advice['inner_rad'])} and the outer rod {_held(advice['outer_rad'])}"
    if advice["weights"]:
        start = f"clamp {weights_words(advice)}, and {start}"
    besides = ", and with it every torque in N m" if advice["for"] == INERTIA.symbol else ""
    return f"{advice_title(advice)}{besides}: {start}: {_gained(advice, several)}"


def _gained(advice: Section, several: bool) -> str:
    expected, worst, unloaded = (advice[key] for key in ("expected", "worst", "expected_unloaded"))
    otherwise = "; without a weight {}" if np.isfinite(unloaded) else ""
    missed = f"at worst, where the hand misses by {HAND:.0f}°"
    if advice["against"]:
        now = f"the two are then {expected:.2g} standard deviations apart, now {advice['deviations_now']:.2g}"
        return now + otherwise.format(f"{unloaded:.2g}")
    if is_determined_now(advice):
        share = f"{_percent(expected)} of what {'they are' if several else 'it is'} ({_percent(worst)} {missed})"
        falls = "their intervals fall" if several else "its interval falls"
        return f"{falls} to {share}" + otherwise.format(f"to {_percent(unloaded)}")
    if several:
        return "they are determined then"
    if not np.isfinite(expected):
        return "these trials do not show it, and no such trial does"
    width, widest = (_percent(CONFIDENCE * relative_std) for relative_std in (expected, worst))
    return f"these trials do not show it; it is determined then, to ± {width} ({widest} {missed})"


def _percent(share: float) -> str:
    """Write a share to its two leading digits."""
    return f"{float(f'{100 * share:.2g}'):g} %"


def is_determined_now(advice: Section) -> bool:
    """Return whether the trials that there are show all values that a next one is to tell of."""
    return all(np.isfinite(std) for std in advice["std_now"])


def _held(from_hanging: float) -> str:
    angle = round(float(np.degrees(from_hanging)))
    return "upright" if abs(angle) == 180 else f"at {angle:+d}°" if angle else "hanging"


def advice_map(report: Section) -> Iterator[Figure]:
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
    chosen = Line("the start to take", "ink", x, y, 0.0, shape="circle-open", size=34.0)
    return Panel(
        Axis("inner rod, from hanging [°]", ticks=_ticks(inner)),
        Axis("outer rod, from hanging [°]", ticks=_ticks(outer[::-1])),
        [Heat(values.T[::-1], limits, 1 if advice["against"] else 0), chosen],
        title,
        260,
    )


def _place(angles: Array, chosen: float) -> int:
    """Return the place of an angle [rad] among some [degrees]."""
    return int(np.argmin(np.abs(angles - np.degrees(chosen))))


def _ticks(angles: Array) -> list[tuple[float, str]]:
    # Names of all places, as the ends of the axis follow from them; written at quarter turns.
    return [(float(place), f"{angle:.0f}" if round(angle) % 90 == 0 else "") for place, angle in enumerate(angles)]

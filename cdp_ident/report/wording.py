"""What several forms of a report say in the same words, and the few numbers that they derive from it."""

from collections.abc import Iterator, Sequence
from typing import Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from cdp_ident.model.effects.catalogue import known_effects
from cdp_ident.model.parameters import CONSTANTS, GROUPS, INERTIA, SYMBOLS, Group, groups_of, inertia_about_cart
from cdp_ident.report.formatting import CERTAINTY, per_cent, with_std
from cdp_ident.report.schema import Section

_FELT, _MOST_IN_DOUBT = 0.5, 3
"""Effects in doubt are mentioned if they make half of a standard deviation, and at most so many."""
_ALL = 0.95
"""From this share of the fitted motion on, effects were looked for in all of it."""


class Model(NamedTuple):
    """One fitted model, as pictures name it."""

    key: Literal["before", "after"]
    """Its key in `report.json`, and the name of its curves and of its colour in every picture."""
    label: str


def models(report: Section) -> list[Model]:
    """Return the paper's model and, where effects were found, the model with them."""
    before = Model("before", "before: the paper's model, fitted")
    return [before, Model("after", "after: with the effects found")] if report["effects"] else [before]


def nominal_value(report: Section, symbol: str) -> float:
    """Return what was known of a physical parameter before: its measured value, or else its nominal one."""
    options = report["run"]["options"]
    if symbol == INERTIA.symbol:
        return float(inertia_about_cart(_nominal_values(report), nominal_value(report, "L")))
    if symbol in (constant.symbol for constant in CONSTANTS):
        return float(options[symbol])
    known = options.get(f"known.{symbol}")
    return float(options[f"nominal.{symbol}"] if known is None else known)


def nominal_groups(report: Section) -> dict[str, float]:
    """Return the base parameters of the values known before, by their symbols."""
    values = groups_of(_nominal_values(report), nominal_value(report, "L"))
    return {group.symbol: float(value) for group, value in zip(GROUPS, values, strict=True)}


def _nominal_values(report: Section) -> npt.NDArray[np.float64]:
    return np.array([nominal_value(report, symbol) for symbol in SYMBOLS])


def how_determined(report: Section, symbol: str) -> str:
    """Say how the model that a report ends with came to the value of a physical parameter."""
    quantity = report["after"]["physical"][symbol]
    if quantity["std"] == 0.0:
        return "given"
    if report["run"]["options"].get(f"known.{symbol}") is not None:
        return "measured"
    return "yes" if quantity["determined"] else "no: nearest to nominal"


def expected_in_words(report: Section) -> Iterator[str]:
    """Say what became of the effects of an earlier report, and which are new; nothing without `--like`."""
    for effect in report["expected"]:
        changes = (
            f"{name} {p['before']:.4g} -> {p['now']:.4g} ({p['deviations']:.1f} std)"
            for name, p in effect["parameters"].items()
        )
        became = {
            "withdrawn": "withdrawn: these trials do not show it",
            "new": "new",
            "confirmed": f"confirmed: {', '.join(changes)}, torques over A22",
        }
        yield f"{effect_name(effect)} is {became[effect['state']]}"


def effect_name(effect: Section) -> str:
    """Name an effect shortly, for lists and tables: its kind, its variant, and where."""
    parts = (effect["name"].replace("_", " "), effect["variant"], effect["joint"], effect.get("trial"))
    return ", ".join(filter(None, parts))


def effect_title(effect: Section) -> str:
    """Name an effect for people: what it is, and where."""
    of_encoders = {known.name for known in known_effects() if not known.moves and not known.of_both_encoders}
    part = "encoder" if effect["name"] in of_encoders else "joint"
    place = "base" if effect["joint"] == "base" else f"{effect['joint']} {part}"
    variant = f", {effect['variant']}" if effect["variant"] and not effect["curve"] else ""
    trial = f", in {effect['trial']}" if effect["trial"] else ""
    doubt = "" if effect["curve"] else CERTAINTY[effect["certainty"]]
    return f"{doubt}{effect['description']} ({place}{variant}{trial})"


def key_words(key: str) -> str:
    """Write an effect's key, as the selection has it, for people."""
    return key.replace("_", " ").replace(".", ", ")


def action_words(step: Section) -> str:
    """Say what was done at a step of the selection."""
    said = str(step["action"])
    for key in sorted((effect.key for effect in known_effects()), key=len, reverse=True):
        said = said.replace(key, key_words(key))
    return said


def effects_words(keys: Sequence[str]) -> str:
    """Write the keys of effects that a model was tried with; of none it is the same model, fitted from elsewhere."""
    return " and ".join(map(key_words, keys)) or "the same, from elsewhere"


def determined_words(report: Section) -> list[str]:
    """Say what the trials determine, and what they neither show nor exclude that would change base parameters."""
    groups, in_doubt = report["after"]["groups"], []
    for effect in report["in_doubt"]:
        changed = []
        for group in GROUPS:
            value, std = (groups[group.symbol][of] for of in ("value", "std"))
            change = effect["changes"][group.symbol]
            if value and effect["weight"] * change**2 > (_FELT * std) ** 2:
                changed.append(f"{group.formula} by {100.0 * change / abs(value):+.2g} %")
        if changed:
            in_doubt.append(
                f"{key_words(effect['effect'])}, is neither shown nor excluded; it would change {', '.join(changed)}, "
                "and intervals allow for that"
            )
    return [*report["identifiability"]["words"], *in_doubt[:_MOST_IN_DOUBT]]


def noise_floor(report: Section) -> float:
    """Return the noise of both encoders' angles together [rad]."""
    return float(np.sqrt(np.mean(np.square(list(report["noise_rad"].values())))))


def group_words(group: Group) -> str:
    """Write a base parameter's short name and what it stands for."""
    return f"{short_name(group.symbol)} = {group.formula}"


def role_words(trial: Section) -> str:
    """Say what a trial was for."""
    return "fitted" if trial["role"] == "fit" else "held out"


def weights_words(trial: Section) -> str:
    """Say which weights a trial has: mass, place and rod of each; nothing where it has none."""
    return "; ".join(
        f"{with_std(weight['mass'], weight['mass_std'])} kg at {with_std(weight['place'], weight['place_std'])} m "
        f"on the {weight['rod']} rod"
        for weight in trial["weights"]
    )


def short_name(symbol: str) -> str:
    """Write a base parameter as a fraction, and a parameter of an effect or weight in words."""
    if symbol.startswith("weight_error."):
        return symbol.replace("_", " ").replace(".", ", ", 2)
    return key_words(symbol) if "." in symbol else symbol.replace("one_over_", "1/").replace("_over_", "/")


def predicted_for(report: Section, limit: int) -> str:
    """Say for how long the models predict within one of the limits, by its place, in seconds without the unit."""
    within = [report["prediction"][model.key]["within"][limit] for model in models(report)]
    return " -> ".join(f"{'≥ ' if one['longer'] else ''}{one['median_s']:.3g}" for one in within)


def share_words(report: Section) -> list[str]:
    """Say in what share of long recordings effects were looked for; nothing where it was all."""
    looked_in = report["selection"]["looked_in_s"]
    fitted = report["refinement"]["windows"]["fit"] * report["before"]["error"]["fit"]["window_s"]
    if not 0.0 < looked_in < _ALL * fitted:
        return []
    return [
        f"effects were looked for in {looked_in:.3g} s of {fitted:.3g} s of motion, spread evenly over the trials; "
        "what was found there is fitted to all"
    ]


def validation_words(report: Section) -> Iterator[str]:
    """Say how the models do where control engineers look: fit in per cent, prediction, and residuals."""
    fits = {
        angle: " -> ".join(
            per_cent(report[model.key]["error"]["holdout"][f"fit_{angle}_percent"]) for model in models(report)
        )
        for angle in ("theta1", "theta2")
    }
    said = ", ".join(f"{angle} {fit} %" for angle, fit in fits.items())
    yield f"fit over held-out windows (NRMSE, as of MATLAB's compare): {said}"
    if ahead := report["prediction"]:
        said = ", ".join(
            f"within {within['limit_deg']:.3g}° for {predicted_for(report, place)} s"
            for place, within in enumerate(ahead["before"]["within"])
        )
        where = "in held-out trials" if ahead["held_out"] else "in the trials, fitted motion among it"
        yield (
            f"after {ahead['told_s']:.2g} s of measured motion, the model predicts {said} (median of "
            f"{ahead['starts']} starts {where})"
        )
    found = report["residuals"]["after"]
    if found["white"]:
        yield "residuals over held-out windows: white"
    else:
        said = " and ".join(
            f"{max(map(abs, found[angle]['values'][1:])):.2f} in {angle} (chance: {found[angle]['bound']:.2f})"
            for angle in ("theta1", "theta2")
            if found[angle]["related"]
        )
        yield f"residuals over held-out windows are correlated in time, by up to {said}"
    if found["crosswise"]["related"]:
        yield "those of the two angles are correlated with each other"
    if found["cart"] and any(of["related"] for of in found["cart"].values()):
        yield "they have to do with the cart's acceleration: the model lacks a part of its effect"

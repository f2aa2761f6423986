"""The quantities of a report that can be compared with another's: base parameters, effects, physical values."""

import math
from dataclasses import dataclass

from cdp_ident.report.formatting import number, quantity_words, unit, with_std
from cdp_ident.report.schema import Section
from cdp_ident.report.wording import effect_name, how_determined


@dataclass(frozen=True)
class Quantity:
    """A number of a report, to be read and to be compared."""

    text: str
    value: float = math.nan
    """As the motion shows it; not a number where it says nothing."""
    std: float = math.nan

    @property
    def is_known(self) -> bool:
        """Whether it can be compared."""
        return math.isfinite(self.value) and math.isfinite(self.std) and self.std > 0.0


def fitted_quantity(report: Section, kind: str, name: str) -> Quantity:
    """Return one of the `groups` or of the `physical` values of the model that a report ends with."""
    found = report["after"][kind][name]
    text = f"{with_std(found['value'], found['std'])} {unit(found['unit'])}".strip()
    # A physical value that is not determined is where the nominal values have put it, and one that was measured
    # beforehand where that has: in all reports alike.
    says_something = kind == "groups" or how_determined(report, name) == "yes"
    return Quantity(text, number(found["value"]), number(found["std"])) if says_something else Quantity(text)


def effect_quantities(report: Section, of_trials: bool = True) -> dict[str, Quantity]:
    """Return the parameters of the effects by what people call them; their values are of torques over A22.

    `of_trials` says whether effects are among them that belong to one trial alone.
    """
    found = {}
    for effect in report["effects"]:
        if effect["trial"] and not of_trials:
            continue
        for name, quantity in effect["parameters"].items():
            shown = [number(quantity["as_fitted"][of]) for of in ("value", "std")]
            found[f"{effect_name(effect)}: {name}"] = Quantity(quantity_words(quantity), *shown)
    return found

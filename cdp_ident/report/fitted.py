"""The fitted parameters as ROS has them: in `fitted.yaml` and on the node."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from cdp_ident.configuration.fitted_model import EFFECT_PREFIX, GROUP_PREFIX, OUTER_ROD_LENGTH, TRIAL
from cdp_ident.configuration.parameter_file import parameter_file
from cdp_ident.model.effects.naming import VARIANT
from cdp_ident.model.parameters import CONSTANTS, GROUPS, PARAMETERS
from cdp_ident.report.contents import Section


@dataclass(frozen=True)
class FittedParameter:
    """One result under its name on ROS."""

    name: str
    value: float | bool | str
    description: str
    unit: str
    minimum: float | None = 0.0
    """Lowest possible value; None where the value may be infinite, which no range can hold."""


def fitted_parameters(report: Section) -> Iterator[FittedParameter]:
    """Yield the parameters of the model that a report ends with: first their values.

    Then `std.<name>`, infinite where the trials do not show the parameter at all, and `determined.<name>`: whether
    trials and measured values determine it; at last the effects, `effects.<name>.<joint>.<parameter>`. Of an effect
    that a joint has more than once (knocks), the later ones have a number after the joint: `effects.impulse.inner.2.…`.
    """
    fit = report["after"]
    described = {parameter.symbol: parameter.description for parameter in (*PARAMETERS, *CONSTANTS)}
    described |= {f"{GROUP_PREFIX}{group.symbol}": group.formula for group in GROUPS}
    quantities = {
        **fit["physical"],
        **{f"{GROUP_PREFIX}{symbol}": quantity for symbol, quantity in fit["groups"].items()},
    }
    for name, quantity in quantities.items():
        yield FittedParameter(name, quantity["value"], f"fitted: {described[name]}", quantity["unit"])
    for name, quantity in quantities.items():
        std = np.inf if quantity["std"] is None else quantity["std"]
        yield FittedParameter(f"std.{name}", std, f"standard deviation of {name}", quantity["unit"], None)
    for name, quantity in quantities.items():
        yield FittedParameter(
            f"determined.{name}", quantity["determined"], f"whether the trials determine {name}", "", None
        )
    yield FittedParameter(
        OUTER_ROD_LENGTH, fit["outer_rod_length_m"], "taken to be: length of the outer rod, for air drag along it", "m"
    )
    seen: Counter[str] = Counter()
    for effect in report["effects"]:
        prefix = f"{EFFECT_PREFIX}{effect['name']}.{effect['joint']}"
        seen[prefix] += 1
        yield from _effect_parameters(effect, prefix if seen[prefix] == 1 else f"{prefix}.{seen[prefix]}")


def _effect_parameters(effect: Section, prefix: str) -> Iterator[FittedParameter]:
    for name in (VARIANT, TRIAL):
        if effect[name]:
            yield FittedParameter(f"{prefix}.{name}", effect[name], f"{name} of {effect['description']}", "", None)
    for name, quantity in effect["parameters"].items():
        description = f"{effect['description']}: {effect['formula']}"
        yield FittedParameter(f"{prefix}.{name}", quantity["value"], description, quantity["unit"], None)
    for name, quantity in effect["parameters"].items():
        std = np.inf if quantity["std"] is None else quantity["std"]
        description = f"standard deviation of {prefix}.{name}"
        yield FittedParameter(f"std.{prefix}.{name}", std, description, quantity["unit"], None)


def fitted_yaml(report: Section) -> str:
    """Return the text of `fitted.yaml`."""
    values = {parameter.name: parameter.value for parameter in fitted_parameters(report)}
    bags = ", ".join(trial["name"] for trial in report["trials"] if trial["role"] == "fit")
    comments = [f"Fitted by cdp_ident identify from {bags!r}; report.json tells how. SI units, radians."]
    return parameter_file(values, comments)

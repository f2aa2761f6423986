# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The YAML file that describes an emulated rig."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from cdp_ident.errors import OptionError
from cdp_ident.model.acting import NO_EFFECTS, ActingEffects, outer_rod_length
from cdp_ident.model.effects.own import OWN_EFFECTS, use
from cdp_ident.model.parameters import GROUPS, LARGEST, NOMINAL, SYMBOLS, inertia_about_cart, physical_coefficients
from cdp_ident.model.weights import ADDED, INERTIA, RODS, Weight, added_by, weights_of
from cdp_ident.rig.emulator.device import Encoders
from cdp_ident.rig.emulator.drive import Drive
from cdp_ident.rig.emulator.effects import parse_effects
from cdp_ident.rig.emulator.fields import mapping, of_fields
from cdp_ident.rig.emulator.script import DEFAULT_SCRIPT, Command, MoveCart, WaitForCommand, parse_script
from cdp_ident.user_input import number
from cdp_ident.yaml_file import read_yaml


@dataclass(frozen=True)
class EmulatedRig:
    """A rig and what is done with it; the default is the paper's pendulum (Table 2), let go once."""

    parameters: dict[str, float] = field(default_factory=lambda: dict(NOMINAL))
    """Physical parameters by the paper's symbols."""
    encoders: Encoders = field(default_factory=Encoders)
    rate: float = 200.0
    """Samples a second [Hz]."""
    clock_error: float = 0.0
    """By how much the device's clock is fast (1e-4: 100 ppm)."""
    script: tuple[Command, ...] = DEFAULT_SCRIPT
    effects: ActingEffects = NO_EFFECTS
    """What its physics have beside the paper's model."""
    weights: tuple[Weight, ...] = ()
    """Clamped to its rods; the parameters are those of the rods without them."""

    drive: Drive | None = None
    """Of its cart, which the host commands; without one the script moves it."""

    @property
    def inertia(self) -> float:
        """A22, that of the weights included [kg m^2]."""
        return self._bare_inertia + float(added_by(self.weights, self.parameters["L"])[INERTIA])

    @property
    def _bare_inertia(self) -> float:
        rods = np.array([self.parameters[symbol] for symbol in SYMBOLS])
        return float(inertia_about_cart(rods, self.parameters["L"]))

    def coefficients(self) -> npt.NDArray[np.float64]:
        """Return what `simulate` takes. Raises `OptionError` where the parameters are no mechanism."""
        groups, constants = np.split(physical_coefficients(self.parameters), [len(GROUPS)])
        added = added_by(self.weights, self.parameters["L"])[INERTIA + 1 :]
        return np.concatenate([(self._bare_inertia * groups + added) / self.inertia, constants])


_KEYS = ("parameters", "added", OWN_EFFECTS, "effects", "encoders", "rate", "clock_error", "drive", "script", "repeat")


def load_rig(path: Path) -> EmulatedRig:
    """Return the rig that a YAML file describes; what it leaves out is as in `EmulatedRig()`.

    Raises `OptionError` for a file that cannot be read, an unknown key (naming the nearest known one), or a value
    that is not possible.
    """
    try:
        content: Any = read_yaml(path)
    except (OSError, ValueError) as error:
        raise OptionError(f"the rig's file {path} cannot be read: {error}") from error
    content = mapping(content, str(path), _KEYS)
    rig = EmulatedRig()
    parameters = {
        symbol: number(value, f"{path}: parameters: {symbol}", 1e-6 if symbol == "L" else 0.0, LARGEST)
        for symbol, value in mapping(content.get("parameters", {}), f"{path}: parameters", tuple(NOMINAL)).items()
    }
    script = parse_script(content["script"], f"{path}: script") if "script" in content else rig.script
    drive = of_fields(content["drive"], Drive, f"{path}: drive") if "drive" in content else None
    rig = replace(
        rig,
        parameters=rig.parameters | parameters,
        encoders=of_fields(content.get("encoders", {}), Encoders, f"{path}: encoders"),
        rate=number(content.get("rate", rig.rate), f"{path}: rate", minimum=1.0, maximum=5000.0),
        clock_error=number(content.get("clock_error", 0.0), f"{path}: clock_error", minimum=-0.01, maximum=0.01),
        drive=drive,
        script=script * int(number(content.get("repeat", 1), f"{path}: repeat", minimum=1, maximum=10_000)),
    )
    not_possible, why = (MoveCart, "cart") if rig.drive else (WaitForCommand, "wait_for_command")
    if any(isinstance(command, not_possible) for command in script):
        has = "has a drive, which alone moves it" if rig.drive else "has no drive; give the key drive"
        raise OptionError(f"{path}: script: {why} is not possible, for the cart {has}")
    added = mapping(content.get(ADDED, {}), f"{path}: {ADDED}", RODS)
    weights = weights_of({f"{ADDED}.{rod}": weight for rod, weight in added.items()}, str(path))
    rig = replace(rig, weights=tuple(weight for weight in weights.values() if weight))
    rig.coefficients()
    use(mapping(content.get(OWN_EFFECTS, {}), f"{path}: {OWN_EFFECTS}"), rig.inertia, f"{path}: {OWN_EFFECTS}")
    outer_length = outer_rod_length(rig.parameters["L"], rig.parameters["l2"])
    effects = parse_effects(content.get("effects", {}), rig.inertia, outer_length, f"{path}: effects")
    return replace(rig, effects=effects)

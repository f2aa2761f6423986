# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The YAML file that describes an emulated rig."""

import math
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from cdp_ident.errors import OptionError
from cdp_ident.model.acting import NO_EFFECTS, ActingEffects, outer_rod_length
from cdp_ident.model.effects.catalogue import effect_of
from cdp_ident.model.effects.effect import Effect
from cdp_ident.model.effects.own import OWN_EFFECTS, use
from cdp_ident.model.parameters import GROUPS, LARGEST, NOMINAL, SYMBOLS, inertia_about_cart, physical_coefficients
from cdp_ident.model.weights import ADDED, INERTIA, RODS, Weight, added_by, weights_of
from cdp_ident.rig.emulator.device import Encoders
from cdp_ident.rig.emulator.motion import Command, Drive, Hold, LetGo, MoveCart, Wait, WaitForCommand
from cdp_ident.user_input import mapping_of, number, of_fields, quoted, refuse_unknown
from cdp_ident.yaml_file import read_yaml

DEFAULT_SCRIPT: tuple[Command, ...] = (
    Wait(3.0),
    Hold(math.radians(60.0), math.radians(60.0)),
    Wait(1.5),
    LetGo(),
    Wait(25.0),
)

_KINDS: dict[str, type[Command]] = {
    "wait": Wait,
    "hold": Hold,
    "cart": MoveCart,
    "let_go": LetGo,
    "wait_for_command": WaitForCommand,
}
"""By their names in a rig's file."""


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
    content = mapping_of(content, str(path), _KEYS)
    parameters = {
        symbol: number(value, f"{path}: parameters: {symbol}", 1e-6 if symbol == "L" else 0.0, LARGEST)
        for symbol, value in mapping_of(content.get("parameters", {}), f"{path}: parameters", tuple(NOMINAL)).items()
    }
    script = parse_script(content["script"], f"{path}: script") if "script" in content else DEFAULT_SCRIPT
    drive = of_fields(content["drive"], Drive, f"{path}: drive") if "drive" in content else None
    encoders = of_fields(content.get("encoders", {}), Encoders, f"{path}: encoders")
    rate = number(content.get("rate", EmulatedRig.rate), f"{path}: rate", 1.0, 5000.0)
    clock_error = number(content.get("clock_error", 0.0), f"{path}: clock_error", -0.01, 0.01)
    repeat = int(number(content.get("repeat", 1), f"{path}: repeat", 1, 10_000))
    not_possible, why = (MoveCart, "cart") if drive else (WaitForCommand, "wait_for_command")
    if any(isinstance(command, not_possible) for command in script):
        has = "has a drive, which alone moves it" if drive else "has no drive; give the key drive"
        raise OptionError(f"{path}: script: {why} is not possible, for the cart {has}")
    added = mapping_of(content.get(ADDED, {}), f"{path}: {ADDED}", RODS)
    weights = weights_of({f"{ADDED}.{rod}": weight for rod, weight in added.items()}, str(path))
    clamped = tuple(weight for weight in weights.values() if weight)
    rig = EmulatedRig(NOMINAL | parameters, encoders, rate, clock_error, script * repeat, weights=clamped, drive=drive)
    rig.coefficients()
    use(mapping_of(content.get(OWN_EFFECTS, {}), f"{path}: {OWN_EFFECTS}"), rig.inertia, f"{path}: {OWN_EFFECTS}")
    outer_length = outer_rod_length(rig.parameters["L"], rig.parameters["l2"])
    effects = parse_effects(content.get("effects", {}), rig.inertia, outer_length, f"{path}: effects")
    return replace(rig, effects=effects)


def parse_script(content: Any, where: str) -> tuple[Command, ...]:
    """Return the commands of a list as it stands in a YAML file.

    `- wait: 2.0`, `- hold: {theta1: 1.0, theta2: 1.2, within: 1.5}`, `- let_go`, `- cart: {to: 0.1, within: 0.5}`,
    `- wait_for_command`. Raises `OptionError` where it is something else; `where` says in which file.
    """
    if not isinstance(content, list) or not content:
        raise OptionError(f"{where}: expected a list of {', '.join(_KINDS)}, found {quoted(content)}")
    return tuple(_command(entry, f"{where}, entry {number}") for number, entry in enumerate(content, 1))


def _command(entry: Any, where: str) -> Command:
    if isinstance(entry, str) and entry in _KINDS and not fields(_KINDS[entry]):
        return of_fields({}, _KINDS[entry], where)
    if not isinstance(entry, dict) or len(entry) != 1:
        raise OptionError(f"{where}: expected one of {', '.join(_KINDS)}, found {quoted(entry)}")
    ((name, value),) = entry.items()
    refuse_unknown([name], _KINDS, f"command in {where}")
    if not fields(_KINDS[name]):
        raise OptionError(f"{where}: {name} takes no value")
    return of_fields({"seconds": value} if name == "wait" else value, _KINDS[name], f"{where}: {name}")


def parse_effects(content: Any, inertia: float, outer_length: float, where: str) -> ActingEffects:
    """Return the effects of a rig's file: `{coulomb_friction: {inner: {torque: 0.002}}, …}`, in physical units.

    Names are those of the catalogue, or of own effects; of several forms of an effect the first is meant, unless
    `variant` (or, for `cogging_torque`, `periods`) says otherwise. What a joint has more than once, such as harmonics,
    is a list. `inertia` is A22, that of any weights included [kg m^2], and `outer_length` is what air drag acts along
    [m]. Times count from the emulator's start. Raises `OptionError` for what is unknown or out of its range.
    """
    if content == {}:
        return NO_EFFECTS
    chosen = [
        _possible_now(*effect_of(name, joint, one, inertia, where), f"{where}: {name}: {joint}")
        for name, joints in mapping_of(content, where).items()
        for joint, given in mapping_of(joints, f"{where}: {name}").items()
        for one in (given if isinstance(given, list) else [given])
    ]
    return ActingEffects.of(chosen, outer_length)


def _possible_now(effect: Effect, values: list[float], where: str) -> tuple[Effect, list[float]]:
    """Refuse an encoder that is early: what it would show has not happened yet."""
    if effect.law.lateness and values[0] < 0.0:
        raise OptionError(
            f"{where}: {effect.parameters[0].name} is {values[0]:g}; an emulated encoder can only be late"
        )
    return effect, values

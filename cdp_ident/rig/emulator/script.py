# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the hand and the cart do, one command after another."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from cdp_ident.errors import OptionError
from cdp_ident.user_input import number, quoted, refuse_unknown


@dataclass(frozen=True)
class Wait:
    """Leave everything as it is: a held pendulum held, a free one swinging."""

    seconds: float


@dataclass(frozen=True)
class Hold:
    """Catch the pendulum, lead it to a position in the time `within` [s], and hold it there."""

    theta1: float
    """Angle of the inner rod from upright [rad]; likewise the outer rod's."""
    theta2: float
    within: float = 1.5


@dataclass(frozen=True)
class LetGo:
    """Let the pendulum swing."""


@dataclass(frozen=True)
class MoveCart:
    """Move the cart to a position [m] in the time `within` [s]."""

    to: float
    within: float = 1.0


@dataclass(frozen=True)
class WaitForCommand:
    """Leave everything as it is until the cart's drive obeys a command."""


_LONGEST = 1e6
"""Seconds, of a wait or a motion of the hand."""

Command = Wait | Hold | LetGo | MoveCart | WaitForCommand

DEFAULT_SCRIPT: tuple[Command, ...] = (
    Wait(3.0),
    Hold(math.radians(60.0), math.radians(60.0)),
    Wait(1.5),
    LetGo(),
    Wait(25.0),
)

_WITHOUT_VALUE: dict[str, Command] = {"let_go": LetGo(), "wait_for_command": WaitForCommand()}
_NAMES = ("wait", "hold", "cart", *_WITHOUT_VALUE)


def parse_script(content: Any, where: str) -> tuple[Command, ...]:
    """Return the commands of a list as it stands in a YAML file.

    `- wait: 2.0`, `- hold: {theta1: 1.0, theta2: 1.2, within: 1.5}`, `- let_go`, `- cart: {to: 0.1, within: 0.5}`,
    `- wait_for_command`. Raises `OptionError` where it is something else; `where` says in which file.
    """
    if not isinstance(content, list) or not content:
        raise OptionError(f"{where}: expected a list of {', '.join(_NAMES)}, found {quoted(content)}")
    return tuple(_command(entry, f"{where}, entry {number}") for number, entry in enumerate(content, 1))


def _command(entry: Any, where: str) -> Command:
    if isinstance(entry, str) and entry in _WITHOUT_VALUE:
        return _WITHOUT_VALUE[entry]
    if not isinstance(entry, dict) or len(entry) != 1:
        raise OptionError(f"{where}: expected one of {', '.join(_NAMES)}, found {quoted(entry)}")
    ((name, value),) = entry.items()
    refuse_unknown([name], _NAMES, f"command in {where}")
    if name == "wait":
        return Wait(number(value, f"{where}: wait", minimum=0.0, maximum=_LONGEST))
    if name == "hold":
        values = _numbers(value, ("theta1", "theta2"), f"{where}: hold")
        return Hold(**values)
    if name == "cart":
        return MoveCart(**_numbers(value, ("to",), f"{where}: cart"))
    raise OptionError(f"{where}: {name} takes no value")


def _numbers(value: Any, needed: tuple[str, ...], where: str) -> dict[str, float]:
    if not isinstance(value, Mapping):
        raise OptionError(f"{where}: expected {', '.join(needed)} and within, found {quoted(value)}")
    refuse_unknown(value, (*needed, "within"), f"key in {where}")
    missing = [name for name in needed if name not in value]
    if missing:
        raise OptionError(f"{where}: {', '.join(missing)} is missing")
    return {
        name: number(entry, f"{where}: {name}", *((0.01, _LONGEST) if name == "within" else (-1000.0, 1000.0)))
        for name, entry in value.items()
    }

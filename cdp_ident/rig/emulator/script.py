# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the hand and the cart do, one command after another."""

import math
from dataclasses import dataclass, fields
from typing import Annotated, Any

from cdp_ident.errors import OptionError
from cdp_ident.rig.emulator.fields import of_fields
from cdp_ident.user_input import Limits, quoted, refuse_unknown

_Place = Annotated[float, Limits(-1000.0, 1000.0)]
_Within = Annotated[float, Limits(0.01, 1e6)]


@dataclass(frozen=True)
class Wait:
    """Leave everything as it is: a held pendulum held, a free one swinging."""

    seconds: Annotated[float, Limits(0.0, 1e6)]


@dataclass(frozen=True)
class Hold:
    """Catch the pendulum, lead it to a position in the time `within` [s], and hold it there."""

    theta1: _Place
    """Angle of the inner rod from upright [rad]; likewise the outer rod's."""
    theta2: _Place
    within: _Within = 1.5


@dataclass(frozen=True)
class LetGo:
    """Let the pendulum swing."""


@dataclass(frozen=True)
class MoveCart:
    """Move the cart to a position [m] in the time `within` [s]."""

    to: _Place
    within: _Within = 1.0


@dataclass(frozen=True)
class WaitForCommand:
    """Leave everything as it is until the cart's drive obeys a command."""


Command = Wait | Hold | LetGo | MoveCart | WaitForCommand

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

# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Trials of an emulated rig, recorded as those of a real one are."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

from cdp_ident.demo.nodes import Nodes
from cdp_ident.errors import OptionError
from cdp_ident.outside_text import shown
from cdp_ident.rig.emulator.configuration import load_rig
from cdp_ident.rig.emulator.motion import LetGo, Wait

RIG = Path(__file__).with_name("rig.yaml")
"""The rig of the demonstration and of the example bags."""

_SPARE = 0.5
"""A trial ends so long before the hand catches the pendulum again [s]."""
_PATIENCE = 60.0
"""Longest wait for a release or an end, beside the swing itself [s]."""
_COMPILING = 600.0
"""Longest wait for the rig [s]: the first time it compiles its physics before its port is there."""


def record_trials(nodes: Nodes, rig: Path, folder: Path, say: Callable[[str], None]) -> list[Path]:
    """Record every swing of an emulated rig's script, through driver and recorder; return the bags.

    The serial port's link, the driver's zero and `trials/` go into a folder; `say` is given what people should see.

    Raises:
        OptionError: the rig's file is not usable.
        CdpIdentError: a node ended, or something did not happen in time.
    """
    swings = swing_times(rig)
    port, trials = folder / "rig_port", folder / "trials"
    longest = min(swings) - _SPARE
    arguments = {
        "driver": ("--ros-args", "-p", f"port:={port}", "-p", f"zero_file:={folder / 'zero.yaml'}"),
        "recorder": ("--ros-args", "-p", f"folder:={trials}", "-p", "rearm:=true", "-p", f"longest:={longest}"),
        # The rig comes last: its script begins when it is switched on, and by then all are ready for it.
        "emulator": ("--link", str(port), "--rig", str(rig)),
    }
    states, bags = nodes.hear("/recorder/state"), nodes.hear("/recorder/bag")
    for name, words in arguments.items():
        if name == "emulator":
            nodes.wait_for("the start of the recorder", lambda: "armed" in states)
        say(f"$ ros2 run cdp_ident {name} {shown(' '.join(words))} &")
        nodes.start(name, *words)
    nodes.wait_for("the start of the rig", port.exists, _COMPILING)
    say(f"\n$ ros2 service call /driver/zero_hanging std_srvs/srv/Trigger\n{nodes.trigger('/driver/zero_hanging')}\n")
    patience = max(swings) + _PATIENCE
    for number in range(1, len(swings) + 1):
        nodes.wait_for("a release", partial(_reached, states, "recording", number), patience)
        say(f"trial {number} of {len(swings)}: the hand has let go, the recorder noticed and records")
        nodes.wait_for("the end of a trial", partial(_reached, bags, "", number), patience)
        say(f"trial {number} of {len(swings)} is {shown(bags[-1])}")
    for name in ("recorder", "driver", "emulator"):
        nodes.stop(name)
    return [Path(bag) for bag in bags]


def swing_times(rig: Path) -> list[float]:
    """Return how long the pendulum swings after each release that an emulated rig's script has [s].

    Raises `OptionError` where the file is not usable, or has fewer than two swings: one to fit, one to hold out.
    """
    times: list[float] = []
    swings = False
    for command in load_rig(rig).script:
        if isinstance(command, LetGo):
            times.append(0.0)
            swings = True
        elif isinstance(command, Wait) and swings:
            times[-1] += command.seconds
        else:
            swings = False
    if len(times) < 2 or min(times) <= _SPARE:
        raise OptionError(f"{rig}: expected a script that lets go twice or more and waits each time, found {times} s")
    return times


def _reached(heard: list[str], word: str, count: int) -> bool:
    """Return whether so many of what was heard contain a word."""
    return sum(word in said for said in heard) >= count

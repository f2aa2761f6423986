# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Does a better model make a controller work at first try?

Rigs of the reference engine, of all sizes and with one to three effects that nobody is told of, are identified from two
free swings. Controllers are designed, by the same rules for all of them, with the nominal values, with what the paper's
search alone finds, with its model refined, and with the effects that were found. Each then has one try on the rig: to
stand for 60 s from 3 degrees (examples/lqr.py), and to swing up from hanging and stand (examples/swing_up.py). The
cart's drive has a lag that is not known exactly, limits that grow with the rig, and answers one sample late.

`python -m benchmarks.transfer` takes a hundred rigs; results are kept in `--out`, and a run that was interrupted goes
on from there. `--write` makes the table of docs/how_to/linear_model.md. It needs CasADi.
"""

import argparse
import dataclasses
import importlib
import math
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from rich.console import Console

from benchmarks._kept import Kept, add_arguments, kept
from benchmarks._product import traced
from benchmarks._tables import Table
from cdp_ident.configuration.fitted_model import FittedModel, fitted_model
from cdp_ident.errors import CdpIdentError
from cdp_ident.model.parameters import SYMBOLS
from cdp_ident.rig.emulator.motion import Drive, DrivenCart
from reference.driven import DrivenRods
from reference.encoders import Turned, joint_angles, theta_of
from reference.kinds import SEVERAL, SINGLE, STICKING
from reference.mechanics import Rig
from reference.plant import Plant
from reference.truths import Truth, truth

Array = npt.NDArray[np.float64]

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "how_to" / "linear_model.md"
BEGIN, END = "<!-- made by python -m benchmarks.transfer --write -->\n", "<!-- end of it -->\n"
sys.path.append(str(ROOT / "examples"))
lqr: Any = importlib.import_module("lqr")
swing_up: Any = importlib.import_module("swing_up")

MODELS = ("nominal", "search", "refined", "effects")
OTHERS: dict[str, dict[str, Any]] = {
    "effects, friction ignored": {"friction": False},
    "effects, delay ignored": {"delay": 0},
}
"""Controllers of the last one that are designed with less."""
LEAN = 3.0
"""Both rods lean by so much at first, each to a side drawn at random [degrees]."""
STANDS = 60.0
"""It is to stand for so long [s] …"""
STANDS_AFTERWARDS = 10.0
"""… and after the swing-up."""
LOST = 1.0
"""A rod this far from where it is to be is lost [rad]."""
LAGS = (0.005, 0.02)
"""Of the drives [s]; 0.01 is known."""
_PARTS = 5
"""The drive's acceleration is taken to be constant within a part of a sample."""
_NOT_TAKEN = ("impulse", "encoder_slip", "backlash", "encoder_compliance", "time_offset")
"""What happens once, and encoders that show what was."""
KINDS = tuple(
    kind
    for kind in (*SINGLE, *SEVERAL, *STICKING)
    if not any(part.partition(".")[0] in _NOT_TAKEN for part in kind.split("+"))
)
_STRIDE = 7
"""From one kind to the next, so that few rigs are of all sorts."""


@dataclasses.dataclass(frozen=True)
class Tried:
    """What came of one try."""

    stood: bool
    error: float
    """The largest of both rods' angles, until it was lost [rad]."""
    travel: float
    """Of the cart, from end to end [m]."""


def examine(job: str) -> Kept:
    """Identify one rig, `KIND/SEED`, and try the controllers of all models on it."""
    kind, seed = job.split("/")
    made = truth(kind, int(seed))
    return {"job": job, **tries(made, designs(made))}


def tries(made: Truth, models: Mapping[str, FittedModel]) -> dict[str, Any]:
    """Return what came of the tries of all controllers, and what of the rig was known at last."""
    variants = [(name, models[name], dict[str, Any]()) for name in MODELS]
    variants += [(name, models[MODELS[-1]], options) for name, options in OTHERS.items()]
    found = [active.effect.key for active in models[MODELS[-1]].motion.effects]
    came = {name: {task: _tried(made, task, model, **options) for task in TASKS} for name, model, options in variants}
    return {"size": made.setting.size, "found": found, **came}


def designs(made: Truth) -> dict[str, FittedModel]:
    """Return the models of a rig, from the least that is known of it to the most."""
    nominal = dict(made.setting.nominal)
    trace = traced(made, "iga")
    best = dict(zip(SYMBOLS, trace.completed.search.best.tolist(), strict=True))
    fits = [FittedModel(nominal, of.model, of.values) for of in (trace.before.fit, trace.completed.fit)]
    models = (fitted_model(nominal, "nominal"), fitted_model(nominal | best, "search"), *fits)
    return dict(zip(MODELS, models, strict=True))


def _tried(made: Truth, task: str, design: FittedModel, friction: bool = True, delay: int = 1) -> dict[str, Any]:
    try:
        return dataclasses.asdict(TASKS[task](made, design, friction, delay))
    except CdpIdentError as error:
        return {"no design": str(error)}


def stand(made: Truth, design: FittedModel, friction: bool, delay: int) -> Tried:
    """Let go of rods that lean, and hold them upright."""
    schedule, _ = lqr.upright_schedule(design, lqr.Design(drive=known_drive(made), delay=delay, friction=friction))
    sides = np.random.default_rng(made.seed).choice([-1.0, 1.0], 2)
    return run(made, design, schedule, np.radians(LEAN) * sides, STANDS)


def swing(made: Truth, design: FittedModel, friction: bool, delay: int) -> Tried:
    """Let go of rods that hang, swing them up and hold them."""
    schedule = swing_up.swing_up_schedule(design, lqr.Design(drive=known_drive(made), delay=delay, friction=friction))
    return run(made, design, schedule, np.full(2, math.pi), lqr.PERIOD * len(schedule.commands) + STANDS_AFTERWARDS)


TASKS: dict[str, Callable[[Truth, FittedModel, bool, int], Tried]] = {"stand": stand, "swing up": swing}


def known_drive(made: Truth) -> Drive:
    """Return what is known of the drive of a rig: limits as of the paper's rig, in its own units."""
    usual, size = Drive(), made.setting.size
    return dataclasses.replace(usual, rail=usual.rail * size, speed=usual.speed * math.sqrt(size))


def run(made: Truth, design: FittedModel, schedule: Any, start: Array, seconds: float) -> Tried:
    """Control a hidden rig from a start (2,) of theta1, theta2 at rest."""
    rng = np.random.default_rng([made.seed, 1])
    drive = dataclasses.replace(known_drive(made), lag=float(np.exp(rng.uniform(*np.log(LAGS)))))
    cart, controller = DrivenCart(drive), lqr.Controller(schedule, drive.acceleration, lqr.rods_shown(design))
    plant = Plant(Rig(made.setting.values))
    for hidden in made.hidden:
        if hidden.effect.in_plant is not None:
            plant = hidden.effect.in_plant(plant, hidden.strength)
    rods = DrivenRods(plant, np.array([*start, 0.0, 0.0]))
    readings = [h.effect.in_reading(h.strength) for h in made.hidden if h.effect.in_reading is not None]
    spacing = lqr.PERIOD / _PARTS
    times = 0.5 * spacing * np.arange(1, 2 * _PARTS + 1)
    place, errors, places = 0.0, list[float](), list[float]()
    for number in range(round(seconds / lqr.PERIOD)):
        joints = joint_angles(rods.now)
        turned = Turned(made.setting.values, rods.now, joints)
        shown = joints + sum((reading(turned) for reading in readings), np.zeros_like(joints))
        theta = theta_of(made.setting.counter.count(shown, rng))[0]
        measured = np.array([place, *theta])
        if number == 0:
            controller.begin(measured)
            command = controller.command(measured, 0)
        else:
            cart.command(command)  # that of the sample before
            command = controller.command(measured)
        away = rods.now.states[0, :2] - schedule.states[min(number, len(schedule.states) - 1), 1:3]
        errors.append(float(np.abs((away + np.pi) % (2.0 * np.pi) - np.pi).max()))
        places.append(place)
        if errors[-1] > LOST:
            break
        positions, accelerations = cart.advance(times)
        rods.advance(accelerations[::2], spacing)
        place = float(positions[-1])
    return Tried(errors[-1] <= LOST, max(errors), max(places) - min(places))


def table(results: Sequence[Kept]) -> Table:
    """Return a row for each controller: how many stood, and of these the largest error and the cart's travel."""
    rows = []
    for name in (*MODELS, *OTHERS):
        cells = [name]
        for task in TASKS:
            stood = [result[name][task] | result for result in results if result[name][task].get("stood")]
            cells.append(f"{len(stood)} of {len(results)}")
            errors = [math.degrees(tried["error"]) for tried in stood] or [math.nan]
            travels = [tried["travel"] / tried["size"] for tried in stood] or [math.nan]
            cells += [f"{np.median(of):.2g}, {max(of):.2g}" for of in (errors, travels)]
        rows.append(cells)
    per_task = ("largest error [°]", "travel [m]")
    columns = ["designed with", *(column for task in TASKS for column in (task, *per_task))]
    notes = "Errors and travels are of those that stood, median and worst; travels as of a rig of the paper's size."
    return Table(f"First tries of {len(results)} rigs", columns, rows, notes)


def written(page: str, results: Sequence[Kept]) -> str:
    """Return a page with the table in its place."""
    before, _, rest = page.partition(BEGIN)
    return f"{before}{BEGIN}\n{table(results).as_markdown()}\n\n{END}{rest.partition(END)[2]}"


def main(arguments: Sequence[str] = ()) -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.transfer")
    parser.add_argument("--count", type=int, default=100, help="rigs")
    add_arguments(parser, 900.0)
    parser.add_argument("--write", action="store_true", help="put the table into its page")
    options = parser.parse_args(arguments)
    jobs = [f"{KINDS[_STRIDE * seed % len(KINDS)]}/{seed}" for seed in range(options.count)]
    results = list(kept(examine, jobs, options.out, options.limit, options.jobs))
    if options.write:
        PAGE.write_text(written(PAGE.read_text(encoding="utf-8"), results), encoding="utf-8")
    else:
        Console(width=None if sys.stdout.isatty() else 160).print(table(results).for_terminal())


if __name__ == "__main__":
    main(sys.argv[1:])

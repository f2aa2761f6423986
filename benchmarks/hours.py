# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""An hour of motion: time and memory of an identification over its length.

Bags of a rig with dry friction in the outer joint, a cable at the inner one and an inner encoder that is off, 60 s of
free swing each at 200 Hz, and one of ten minutes at 1 kHz. Each length is identified in a process of its own, on all
cores, from the bags on disk to the files of the report; the memory is the largest that the process ever had.
`python -m benchmarks.hours` takes two minutes to an hour, `python -m benchmarks.hours MINUTES …` lengths of one's own.
"""

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from rich.console import Console

from benchmarks._tables import Table, number, whole
from cdp_ident.bag.joint_state import MESSAGE_TYPE, serialize_joint_state
from cdp_ident.bag.writer import BagWriter
from cdp_ident.configuration.settings import Settings
from cdp_ident.machine.parallel import core_count
from cdp_ident.output_folder import json_text
from cdp_ident.pipeline.identify import identify
from cdp_ident.pipeline.job import load
from cdp_ident.report.contents import report
from cdp_ident.report.curves import curves, curves_npz
from cdp_ident.report.folder import CURVES, PAGE, REPORT, write_result
from cdp_ident.report.outcome import Job, Outcome
from cdp_ident.report.pictures import draw
from cdp_ident.tracing.trace import trace
from reference.dry_friction import DryFriction
from reference.pendulum import TABLE_5
from reference.sticking import motion
from reference.torques import SPRING, Torque
from scenarios.twin import as_measured

MINUTES = (2, 5, 10, 20, 60)
OFFSET = 6e-3
"""What the inner encoder is off by [rad]."""
STIFFNESS = 0.01
"""Of the cable [N m/rad]."""


@dataclass(frozen=True)
class Case:
    """What is identified."""

    trials: int
    duration: float = 60.0
    """Of each [s]."""
    rate: int = 200
    """Samples a second."""

    @property
    def damping(self) -> float:
        """Factor on the rig's frictions, by which it swings for the whole of a trial."""
        return min(1.0, 60.0 / self.duration)

    def write(self, folder: Path) -> list[Path]:
        """Write its bags."""
        rng = np.random.default_rng(5)
        clock = np.arange(round(self.duration * self.rate)) / self.rate
        rig = {**TABLE_5, "c1": 8e-4 * self.damping, "c2": 2e-4 * self.damping}
        friction, cable = DryFriction(torque=6e-4 * self.damping), Torque(SPRING, "inner", (STIFFNESS, 0.0))
        bags = []
        for count in range(self.trials):
            start = np.pi + rng.choice([-1.0, 1.0], 2) * rng.uniform(0.8, 2.0, 2)
            states = motion(rig, [*start, 0.0, 0.0], clock, outer=friction, torques=[cable])
            theta = as_measured(states[:, :2], rng) + OFFSET
            bags.append(folder / f"swing_{count:02d}")
            _write(bags[-1], clock, np.column_stack([theta[:, 0], theta[:, 1] - theta[:, 0]]))
        return bags


@dataclass(frozen=True)
class Cost:
    """What an identification took, in seconds of the clock unless it says otherwise."""

    read: float
    """Bags."""
    fit: float
    """The paper's model."""
    trace: float
    """Effects, in a share of the motion, and what was found over all of it."""
    report: float
    """Its files: numbers, curves and page."""
    cpu: float
    """Processor time of all."""
    memory: float
    """Largest resident size [MB]."""
    page: float
    """Size of the page [MB]."""
    looked_in: float
    """Motion in which effects were looked for [s]."""
    found: tuple[str, ...]


def _write(folder: Path, clock: npt.NDArray[np.float64], joints: npt.NDArray[np.float64]) -> None:
    with BagWriter(folder) as writer:
        for time_, (inner, outer) in zip(clock.tolist(), joints.tolist(), strict=True):
            stamp = 1_717_156_800_000_000_000 + round(1e9 * time_)
            message = serialize_joint_state(("inner_joint", "outer_joint"), [inner, outer], stamp)
            writer.write("/joint_states", MESSAGE_TYPE, stamp, message)
        writer.close({})


def cost(bags: Sequence[Path], out: Path) -> Cost:
    """Identify bags in this process, as `identify` does with its defaults."""
    marks = [time.monotonic()]
    loaded = load(Job(tuple(bags), (), Settings()))
    marks.append(time.monotonic())
    found = identify(loaded.fit, [], loaded.job.settings.identify)
    marks.append(time.monotonic())
    outcome = Outcome(loaded, found, trace(found), 0.0, 0.0)
    marks.append(time.monotonic())
    content = report(outcome)
    out.mkdir()
    write_result(out, {REPORT: json_text(content), CURVES: curves_npz(curves(outcome))}, None)
    draw(out)
    marks.append(time.monotonic())
    read, fit, traced, files = np.diff(marks).tolist()
    return Cost(
        read,
        fit,
        traced,
        files,
        cpu=time.process_time(),
        memory=resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
        page=(out / PAGE).stat().st_size / 1e6,
        looked_in=content["selection"]["looked_in_s"],
        found=tuple(f"{effect['name']} {effect['joint']}" for effect in content["effects"]),
    )


def measured(case: Case) -> Cost:
    """Identify a case in a process of its own."""
    with tempfile.TemporaryDirectory() as name:
        bags = case.write(Path(name))
        command = [sys.executable, "-m", "benchmarks.hours", "--bags", *map(str, bags), "--out", f"{name}/out"]
        done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
    return Cost(**json.loads(done.stdout.splitlines()[-1]))


def table_of(costs: Sequence[tuple[str, Case, Cost]]) -> Table:
    """Return costs as a table."""
    rows = [
        (
            name,
            whole(case.trials * case.duration * case.rate),
            whole(of.looked_in),
            *(number(seconds) for seconds in (of.read, of.fit, of.trace, of.report)),
            whole(of.read + of.fit + of.trace + of.report),
            whole(of.cpu),
            whole(of.memory),
            number(of.page),
            ", ".join(of.found),
        )
        for name, case, of in costs
    ]
    columns = ("free swing", "samples", "looked for effects in [s]", "bags read [s]", "paper's model [s]",
               "effects [s]", "files [s]", "together [s]", "processor [s]",
               "memory [MB]", "page [MB]", "found")  # fmt: skip
    return Table(f"Over length, on {core_count()} cores", columns, rows)


def main(arguments: Sequence[str] = ()) -> None:
    """Measure lengths, or identify the bags of one."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.hours", description=__doc__)
    parser.add_argument("minutes", nargs="*", type=int, help="lengths, each of bags of 60 s")
    parser.add_argument("--bags", nargs="+", type=Path, help="identify these, and print what it took as JSON")
    parser.add_argument("--out", type=Path, help="where their report goes")
    given = parser.parse_args(arguments)
    if given.bags:
        print(json.dumps(asdict(cost(given.bags, given.out))))
        return
    cases = {f"{minutes} min": Case(minutes) for minutes in given.minutes or MINUTES}
    if not given.minutes:
        cases["10 min in one bag, 1 kHz"] = Case(1, 600.0, 1000)
    console, costs = Console(width=200), []
    for name, case in cases.items():
        costs.append((name, case, measured(case)))
        console.print(table_of(costs[-1:]).for_terminal())
    console.print(table_of(costs).as_markdown(), markup=False, highlight=False, soft_wrap=True)


if __name__ == "__main__":
    main(sys.argv[1:])

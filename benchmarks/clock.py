# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The device's clock: whether intervals hold the rig's values over recordings through port, driver, DDS and recorder.

`python -m benchmarks.clock [--count N] [--jobs N] [--folder DIR]` records three swings of an emulated rig each time, in
real time, the rig's clock off as crystals are, and identifies the paper's model from them, by the device's own time and
by the stamps. Bags that a folder has already are not recorded anew.
"""

import argparse
import os
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import yaml
from rich.console import Console
from rich.table import Table

from benchmarks._workers import each
from cdp_ident.bag.reader import read_joint_states
from cdp_ident.errors import CdpIdentError
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.model.parameters import GROUPS, SYMBOLS, groups_of
from cdp_ident.pipeline.identify import identify
from cdp_ident.rig.emulator.configuration import load_rig
from cdp_ident.trial.find import find_trial
from cdp_ident.trial.joints import select_joints
from cdp_ident.trial.load import load_trial
from cdp_ident.trial.options import TrialOptions
from cdp_ident.trial.trial import Trial

Array = npt.NDArray[np.float64]

CRYSTAL = 30e-6
"""Standard deviation of the clocks' errors: that of cheap crystals."""
HAND = 0.1
"""How differently the hand lets go [rad], so that the counts' rounding is another each time."""
TIMES = ("device", "stamps")
"""By which times trials are identified."""
_TRIALS = 3
_LIMIT = 600.0


@dataclass(frozen=True)
class Recording:
    """One run of a rig."""

    number: int
    folder: Path
    domain: int
    """ROS's domain that its nodes have for themselves."""


@dataclass(frozen=True)
class Judged:
    """What came of one recording."""

    number: int
    deviations: dict[str, Array]
    """By the times used: (base parameters,) fitted less true value, in standard deviations."""
    p_value: dict[str, float]
    """How likely the trials would differ so much if they had the same parameters."""
    said: str = ""
    """Why there is nothing."""


def work(recording: Recording) -> Judged:
    """Record, identify and judge."""
    try:
        return judge(recording, record(recording))
    except CdpIdentError as error:
        return failed(recording, str(error))


def failed(recording: Recording, reason: str) -> Judged:
    """Return that nothing came of a recording."""
    return Judged(recording.number, {}, {}, reason)


def record(recording: Recording) -> list[Path]:
    """Return the bags of three swings, recorded by nodes that are processes of their own."""
    folder = recording.folder / str(recording.number)
    bags = sorted((folder / "trials").glob("trial_*"))
    if len(bags) == _TRIALS:
        return bags
    os.environ |= {"ROS_DOMAIN_ID": str(recording.domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    from cdp_ident.demo.nodes import Nodes  # noqa: PLC0415 - it reads the domain
    from cdp_ident.demo.recording import RIG, record_trials  # noqa: PLC0415

    folder.mkdir(parents=True, exist_ok=True)
    rig = yaml.safe_load(RIG.read_text())
    rig["effects"] = {}  # the paper's model is all that there is to find
    generator = np.random.default_rng(recording.number)
    rig["clock_error"] = float(generator.normal(0.0, CRYSTAL))
    for hold in (command["hold"] for command in rig["script"] if "hold" in command):
        for angle in ("theta1", "theta2"):
            hold[angle] += float(generator.normal(0.0, HAND))
    (folder / "rig.yaml").write_text(yaml.safe_dump(rig))
    with Nodes(folder / "logs") as nodes:
        return record_trials(nodes, folder / "rig.yaml", folder, lambda said: None)


def judge(recording: Recording, bags: Sequence[Path]) -> Judged:
    """Identify bags by the device's time and by the stamps, and compare with the rig's values."""
    rig = load_rig(recording.folder / str(recording.number) / "rig.yaml")
    truth = groups_of(np.array([rig.parameters[symbol] for symbol in SYMBOLS]), rig.parameters["L"])
    deviations, p_value = {}, {}
    for times, trials in zip(TIMES, (list(map(load_trial, bags)), list(map(by_stamps, bags))), strict=True):
        found = identify(trials, [], IdentifyOptions(seed=1))
        deviations[times] = (found.fit.values - truth) / np.sqrt(np.diag(found.covariance))
        p_value[times] = found.repeatability.p_value if found.repeatability else 1.0
    return Judged(recording.number, deviations, p_value)


def by_stamps(bag: Path) -> Trial:
    """Load a trial as if the bag had no device's time."""
    recording = replace(read_joint_states(bag, "joint_states"), device=None)
    samples, _ = select_joints(recording, TrialOptions())
    return replace(find_trial(samples, TrialOptions()).trial, name=recording.name)


def report(judged: Sequence[Judged], console: Console) -> None:
    """Print how often intervals hold the truth, and how far values are off."""
    good = [one for one in judged if not one.said]
    for one in judged:
        if one.said:
            console.print(f"recording {one.number}: {one.said}", highlight=False)
    if not good:
        return
    table = Table(title=f"{len(good)} recordings of {_TRIALS} swings: deviations over their standard deviations, rms")
    for heading in (
        "times",
        *(group.symbol for group in GROUPS),
        "worst",
        "in 95 % intervals",
        "trials agree",
        "least p",
    ):
        table.add_column(heading)
    for times in TIMES:
        table.add_row(times, *_row(np.array([one.deviations[times] for one in good]), [o.p_value[times] for o in good]))
    console.print(table)


def _row(deviations: Array, p_values: Sequence[float]) -> Iterator[str]:
    yield from (f"{rms:.2f}" for rms in np.sqrt(np.mean(deviations**2, axis=0)))
    yield f"{np.abs(deviations).max():.1f}"
    yield f"{np.mean(np.abs(deviations) < 1.96):.0%}"
    yield f"{np.mean(np.array(p_values) > 0.01):.0%}"
    yield f"{min(p_values):.2g}"


def main(arguments: Sequence[str] = ()) -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser("benchmarks.clock")
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--jobs", type=int, default=4)
    parser.add_argument("--domain", type=int, default=int(os.environ.get("ROS_DOMAIN_ID", "0")), help="ROS's first one")
    parser.add_argument("--folder", type=Path, help="where bags go, or are")
    options = parser.parse_args(list(arguments))
    console = Console(width=None if sys.stdout.isatty() else 150)
    with tempfile.TemporaryDirectory() as made:
        folder = options.folder or Path(made)
        recordings = [Recording(k, folder, (options.domain + k) % 100) for k in range(options.count)]
        judged = []
        for one in each(work, recordings, options.jobs, _LIMIT, failed):
            judged.append(one)
            console.print(f"{one.number}: {_line(one)}", highlight=False)
        report(judged, console)


def _line(one: Judged) -> str:
    return one.said or "; ".join(
        f"{times} {np.array2string(deviations, precision=1, suppress_small=True)} p = {one.p_value[times]:.2g}"
        for times, deviations in one.deviations.items()
    )


if __name__ == "__main__":
    main(sys.argv[1:])
